"""Two effects at once to first order: which pairs are worth fitting.

    residual + change_1 + change_2 + C_1 s_1 + C_2 s_2 -> min

About the values that each effect has alone, and, since two that act against each other have none, about start values.
First order promises too much where steps are long: the pairs are put in order by what they really leave there.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise

import numpy as np

from damper_estimator.diagnosis.baseline import Baseline
from damper_estimator.diagnosis.diagnosis_data import force_rows, targets
from damper_estimator.diagnosis.evaluation import Errors, errors, remaining_of
from damper_estimator.diagnosis.hypotheses import Hypothesis, within
from damper_estimator.diagnosis.ranking import Round
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.diagnosis.trial_fit import TrialFit, linearised, sketch
from damper_estimator.model import DamperModel
from damper_estimator.numerics import damped_step

_FITTED = 4  # pairs of each kind
_CHECKED = 40  # pairs of each kind, at their ends and on the way there
_WAY = (1.0, 0.5)
INEXACT = 1.3  # times what a pair may leave: to first order it may leave so much
_FAR = 10.0  # times what explains all of the error: steps are hardly damped


@dataclass(frozen=True)
class Couple:
    """Two hypotheses to first order.

    Attributes:
        left: share of the squared error, with penalties.
        effects: at the values that the steps begin at.
        steps: of their parameters.
    """

    left: float
    effects: tuple[Hypothesis, Hypothesis]
    steps: tuple[np.ndarray, ...]

    @property
    def names(self) -> tuple[str, str]:
        """Of both effects."""
        return self.effects[0].name, self.effects[1].name

    def added_to(self, model: DamperModel, share: float = 1.0) -> DamperModel:
        """The model with both, after this share of the steps, within what is physical."""
        for hypothesis, step in zip(self.effects, self.steps, strict=True):
            model, places = hypothesis.added_to(model)
            vector = np.array([slot.value for slot in model.slots])
            bounds = [slot.parameter for slot in within(model, {hypothesis.name: hypothesis.region})]
            for i, change in zip(places, step, strict=True):
                vector[i] = np.clip(vector[i] + share * change, bounds[i].lower, bounds[i].upper)
            model = model.with_vector(vector)
        return model


@dataclass(frozen=True)
class _Term:
    """An effect to first order, with the lowest and highest steps (k,) of its parameters, in their sizes.

    About its start values steps are long, and end at bounds; those about its fit need none.
    """

    effect: Hypothesis
    fit: TrialFit
    low: np.ndarray | float
    high: np.ndarray | float


def couples_of(current: Round, most: float) -> tuple[list[Couple], list[Couple]]:
    """All pairs of different phenomena, the one that leaves least to first order first: about the fits, and about the
    start values.

    Of two that act against each other the fits say little. Starts are looked at where a form-free test leaves no more
    than a pair may.
    """
    tried = [one for one in current.hypotheses if not one.exclusion]
    ended = [(replace(one, element=one.fitted_element), one.fit) for one in tried if one.fit.derivatives_fit.shape[1]]
    felt: list[tuple[Hypothesis, TrialFit]] = []
    if min((test.error for test in current.tests), default=1.0) <= most:
        begun = [(one, linearised(current.baseline, one)) for one in _begun(tried) if one.effect.kind != "series"]
        felt = [(one, fit) for one, fit in begun if fit.sizes.any()]
    return (
        _combined(current, [_Term(one, fit, -np.inf, np.inf) for one, fit in ended]),
        _combined(current, [_Term(one, fit, *_bounds(current, one, fit)) for one, fit in felt]),
    )


def most_promising(current: Round, couples: Sequence[Couple], most: float) -> list[Couple]:
    """The best of each two phenomena, with every effect in two at most."""
    found: list[Couple] = []
    for one in _checked(current, [one for one in couples if one.left < INEXACT * most][:_CHECKED]):
        if len(found) == _FITTED:
            break
        phenomena = {effect.phenomenon for effect in one.effects}
        is_new = all({effect.phenomenon for effect in other.effects} != phenomena for other in found)
        if is_new and all(sum(name in other.names for other in found) < 2 for name in one.names):
            found.append(one)
    return found


def _checked(current: Round, couples: Sequence[Couple]) -> list[Couple]:
    """In order of what they really leave on excerpts, where the steps end or on the way there."""
    rows, model = sketch(current.baseline.data.fit, current.baseline.residual_fit), current.baseline.model
    target = targets(rows)

    def left(couple: Couple) -> float:
        ends = [force_rows(couple.added_to(model, share), rows) - target for share in _WAY]
        return float(np.nan_to_num(min(np.sum(end**2) for end in ends), nan=np.inf))

    return sorted(couples, key=left)


def resembling(current: Round, baseline: Baseline, hypotheses: Sequence[Hypothesis], nearest: float) -> Iterator[str]:
    """Names of effects that leave less than this beside what is in the model, to first order about their starts."""
    for hypothesis in hypotheses:
        if hypothesis.effect.kind != "series":
            fit = linearised(baseline, hypothesis)
            if fit.sizes.any():
                term = _Term(hypothesis, fit, *_bounds(current, hypothesis, fit))
                if _first_order(current, baseline, term)[0] + penalty_of([hypothesis]) < nearest:
                    yield hypothesis.name


def _begun(tried: Sequence[Hypothesis]) -> Iterator[Hypothesis]:
    """Each at its start values; with a single parameter, at all of them: first order does not reach far."""
    for one in tried:
        yield one
        if one.size == 1:
            yield from (replace(one, element=one.element.with_values(start)) for start in one.starts)


def _combined(current: Round, terms: Sequence[_Term]) -> list[Couple]:
    couples = []
    for one, other in combinations(terms, 2):
        effects = one.effect, other.effect
        is_one_spring = {effect.effect.kind for effect in effects} == {"series"}
        if effects[0].phenomenon != effects[1].phenomenon and not is_one_spring:
            left, steps = _first_order(current, current.baseline, one, other)
            couples.append(Couple(left + penalty_of(effects), effects, steps))
    return sorted(couples, key=lambda one: one.left)


def _bounds(current: Round, hypothesis: Hypothesis, fit: TrialFit) -> tuple[np.ndarray, np.ndarray]:
    """(k,) lowest and highest steps of its parameters, in their sizes."""
    model, places = hypothesis.added_to(current.baseline.model)
    slots = within(model, {hypothesis.name: hypothesis.region})
    ends = [
        (slots[place].parameter.lower - slots[place].value, slots[place].parameter.upper - slots[place].value)
        for place in places
    ]
    size = np.where(fit.sizes > 0.0, fit.sizes, 1.0)
    low, high = np.array(ends).T / size
    return np.minimum(low, 0.0), np.maximum(high, 0.0)


def _first_order(current: Round, baseline: Baseline, *terms: _Term) -> tuple[float, tuple[np.ndarray, ...]]:
    """What effects leave, and the steps of their parameters, which end at their bounds."""
    residual, columns = [], []
    for part in ("fit", "unseen"):
        fits = [one.fit for one in terms]
        residual.append(getattr(baseline, f"residual_{part}") + sum(getattr(fit, f"change_{part}") for fit in fits))
        known = (
            getattr(baseline, f"found_{part}"),
            getattr(baseline, f"base_{part}")[:, : None if current.refits else 0],
        )
        columns.append(np.hstack([*(getattr(fit, f"derivatives_{part}") for fit in fits), *known]))
    step = damped_step(columns[0], residual[0], _FAR)
    ends = np.cumsum([0, *(one.fit.sizes.size for one in terms)])
    parts = [slice(*pair) for pair in pairwise(ends)]
    for one, part in zip(terms, parts, strict=True):
        step[part] = np.clip(step[part], one.low, one.high)
    after = [rows + by @ step for rows, by in zip(residual, columns, strict=True)]
    steps = tuple(step[part] * one.fit.sizes for one, part in zip(terms, parts, strict=True))
    return share_left(current, errors(baseline.data.blocks, *after)), steps


def penalty_of(effects: Sequence[Hypothesis]) -> float:
    """For the parameters of effects; a share of the squared error."""
    return limits().penalty * sum(hypothesis.size for hypothesis in effects)


def share_left(current: Round, left: Errors) -> float:
    """What is left of the squared error of a round without any effect; smaller is better."""
    return remaining_of(current.baseline.data, left, current.without).error
