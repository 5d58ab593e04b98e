"""Two effects at once: the best pair competes with the best single effect.

The largest single effect takes what it can of both, with values, or a name, that are right for neither; and of two that
act against each other, as m a and tau dF/dt where the curve is straight, neither explains much alone. All pairs are
compared to first order, about the values that each effect has alone,

    residual + change_1 + change_2 + C_1 s_1 + C_2 s_2 -> min,

the best of them are fitted, and then each place of the best one that the data support goes to what explains most with
the other one there.
"""

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise

import numpy as np

from damper_estimator.diagnosis.accepted import Accepted, accepted_in, fitted_together, positions
from damper_estimator.diagnosis.baseline import Baseline, baseline_of
from damper_estimator.diagnosis.diagnosis_data import force_rows, targets
from damper_estimator.diagnosis.evaluation import Errors, errors, remaining_of, rmse
from damper_estimator.diagnosis.hypotheses import Hypothesis
from damper_estimator.diagnosis.parallel_fits import all_fitted
from damper_estimator.diagnosis.ranking import Round, round_of
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.diagnosis.trial_fit import TrialFit, linearised
from damper_estimator.model import DamperModel, Element
from damper_estimator.model.element import labels
from damper_estimator.numerics import damped_step

_FITTED = 4  # pairs of each kind
_INEXACT = 1.3  # times what a pair may leave: to first order it may leave so much
_RIVALS = 1.5  # times what the pair leaves: what leaves more in a place of it cannot be tied
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


@dataclass(frozen=True)
class _Term:
    """An effect to first order, with the lowest and highest steps (k,) of its parameters, in their sizes.

    About its start values steps are long, and end at bounds; those about its fit need none.
    """

    effect: Hypothesis
    fit: TrialFit
    low: np.ndarray | float
    high: np.ndarray | float


@dataclass(frozen=True)
class _Pair:
    """Two effects fitted together: what they leave, their names, and the model with them."""

    left: float
    names: tuple[str, str]
    model: DamperModel


def paired(
    current: Round,
    tried: Sequence[Hypothesis],
    names: Collection[str],
    workers: int,
    progress: Callable[[int], None],
) -> tuple[list[Accepted], DamperModel] | None:
    """Two effects that the data support together, and the model with them; None where there are none.

    Args:
        names: of effects that were found before.
    """
    most = _most(current, names)
    if most <= 0.0:
        return None
    about_fits, about_starts = _couples(current, most)
    promising = [*_promising(about_fits, most), *_promising(about_starts, most)]
    for pair in sorted((_fitted(current, one, names) for one in promising), key=lambda pair: pair.left):
        if pair.left > most:
            break
        within = max(_RIVALS * pair.left, _INEXACT * most)
        near = [one.names for one in (*about_fits, *about_starts) if one.left < within]
        found = _in_their_places(current, pair, tried, near, within, names, workers, progress)
        if found is not None:
            return found
    return None


def _in_their_places(
    current: Round,
    pair: _Pair,
    tried: Sequence[Hypothesis],
    near: Sequence[tuple[str, str]],
    within: float,
    names: Collection[str],
    workers: int,
    progress: Callable[[int], None],
) -> tuple[list[Accepted], DamperModel] | None:
    """What explains most in each place of a pair with the other one there, and the model with both; None where the data
    do not support it.

    Args:
        near: pairs whose effects compete where they have one effect in common with this one.
        within: what else leaves less than this, to first order, beside the other one competes as well.
        names: of effects that were found before.
    """
    data, model, found = current.baseline.data, pair.model, []
    other, alone = pair.names
    for _ in range(2):
        less, element = _without(model, alone)
        base = None if current.refits else ()
        baseline = baseline_of(less, data, positions(less, [*names, other]), base)
        free = [h for h in tried if h.name not in {*names, other}]
        rivals = {alone, *(name for both in near if other in both for name in both)}
        rivals |= set(_resembling(current, baseline, [h for h in free if h.name not in rivals], within))
        among = [replace(h, element=element) if h.name == alone else h for h in free if h.name in rivals]
        again = round_of(baseline, all_fitted(baseline, among, 0.0, workers, progress), current.mode)
        best = again.best
        if best is None or again.reason_against(best, data.force_rms):
            return None
        found.append(accepted_in(again, best))
        alone, other = other, best.name
        changed = best.fitted_into(again.baseline.model)
        model = fitted_together(changed, [*names, alone, other], data, current.refits)
    both = _share(current, model)
    least = limits().second * (1.0 - both)
    if any(_share(current, _without(model, name)[0]) - both < least for name in (alone, other)):
        return None  # fitted together, one has taken the part of the other
    return _in_order(current, found), model


def _in_order(current: Round, found: Sequence[Accepted]) -> list[Accepted]:
    """First the one without which more is left, with what it takes away by itself, if that is much."""
    whole = rmse(current.baseline, current.without)
    first, second = sorted(found, key=lambda one: -one.before_n)
    names = [one.element.effect.phenomenon for one in (first, second)]
    needs = second.before_n**2 > (1.0 - limits().gain) * whole**2
    first, second = replace(first, partner=names[1], needs=needs), replace(second, partner=names[0], needs=needs)
    return [first, second] if needs else [replace(first, before_n=whole, after_n=second.before_n), second]


def _most(current: Round, names: Collection[str]) -> float:
    """What a pair may leave: clearly less than the best single effect, both beside what a wrong form leaves.

    If the data support no single effect, and none was found before, a pair need not be better than one that is refused:
    it must explain what two effects do that each explain just enough.
    """
    if not names and not current.supported(current.baseline.data.force_rms):
        return (1.0 - limits().gain) ** 2
    single = min((one.score for one in current.hypotheses if not one.exclusion), default=1.0)
    return limits().pair * (single + limits().second) - limits().second


def _couples(current: Round, most: float) -> tuple[list[Couple], list[Couple]]:
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
            couples.append(Couple(left + _penalty(effects), effects, steps))
    return sorted(couples, key=lambda one: one.left)


def _bounds(current: Round, hypothesis: Hypothesis, fit: TrialFit) -> tuple[np.ndarray, np.ndarray]:
    """(k,) lowest and highest steps of its parameters, in their sizes."""
    model, places = hypothesis.added_to(current.baseline.model)
    ends = []
    for place in places:
        slot = model.slots[place]
        low, high = hypothesis.limits.get(slot.parameter.name, (slot.parameter.lower, slot.parameter.upper))
        ends.append((low - slot.value, high - slot.value))
    size = np.where(fit.sizes > 0.0, fit.sizes, 1.0)
    low, high = np.array(ends).T / size
    return np.minimum(low, 0.0), np.maximum(high, 0.0)


def _promising(couples: Sequence[Couple], most: float) -> list[Couple]:
    """The first of each two phenomena, with every effect in two at most: some are good to first order only."""
    found: list[Couple] = []
    for one in couples:
        if one.left >= _INEXACT * most or len(found) == _FITTED:
            break
        phenomena = {effect.phenomenon for effect in one.effects}
        is_new = all({effect.phenomenon for effect in other.effects} != phenomena for other in found)
        if is_new and all(sum(name in other.names for other in found) < 2 for name in one.names):
            found.append(one)
    return found


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
    return _left(current, errors(baseline.data.blocks, *after)), steps


def _fitted(current: Round, couple: Couple, names: Collection[str]) -> _Pair:
    model, data = current.baseline.model, current.baseline.data
    added = couple.names
    for hypothesis, step in zip(couple.effects, couple.steps, strict=True):
        model, places = hypothesis.added_to(model)
        vector = np.array([slot.value for slot in model.slots])
        low, high = (np.array([getattr(model.slots[i].parameter, end) for i in places]) for end in ("lower", "upper"))
        vector[list(places)] = np.clip(vector[list(places)] + step, low, high)
        model = model.with_vector(vector)
    model = fitted_together(model, [*names, *added], data, current.refits)
    left = _share(current, model) + _penalty(couple.effects)
    return _Pair(left if np.isfinite(left) else np.inf, added, model)


def _share(current: Round, model: DamperModel) -> float:
    """What a model leaves, with its parameters as they are; a share of what is left without any effect."""
    data = current.baseline.data
    rows = [force_rows(model, part) - targets(part) for part in (data.fit, data.unseen)]
    return _left(current, errors(data.blocks, *rows))


def _penalty(effects: Sequence[Hypothesis]) -> float:
    return limits().penalty * sum(hypothesis.size for hypothesis in effects)


def _left(current: Round, left: Errors) -> float:
    return remaining_of(current.baseline.data, left, current.without).error


def _resembling(current: Round, baseline: Baseline, hypotheses: Sequence[Hypothesis], within: float) -> Iterator[str]:
    """Names of effects that leave less than this beside what is in the model, to first order about their starts."""
    for hypothesis in hypotheses:
        if hypothesis.effect.kind != "series":
            fit = linearised(baseline, hypothesis)
            if fit.sizes.any():
                term = _Term(hypothesis, fit, *_bounds(current, hypothesis, fit))
                if _first_order(current, baseline, term)[0] + _penalty([hypothesis]) < within:
                    yield hypothesis.name


def _without(model: DamperModel, name: str) -> tuple[DamperModel, Element]:
    """The model without an effect, and the effect's entry."""
    label, element = [(label, one) for label, one in labels(model.effects) if one.effect.name == name][-1]
    return model.without(label), element
