"""Two effects that act against each other: alone neither explains much, together they do.

Mass and skew are an example: m a and tau dF/dt cancel where the curve is straight. A pair is looked for where a
form-free test leaves far less of the error than every single effect does. All pairs are compared to first order,

    residual + C_1 s_1 + C_2 s_2 -> min,

the best of them are fitted, and then each place of the best pair goes to what explains most with the other one there.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from damper_estimator.diagnosis.accepted import Accepted, accepted_in, fitted_together, positions
from damper_estimator.diagnosis.baseline import baseline_of
from damper_estimator.diagnosis.diagnosis_data import force_rows, targets
from damper_estimator.diagnosis.evaluation import Errors, errors
from damper_estimator.diagnosis.hypotheses import Hypothesis
from damper_estimator.diagnosis.parallel_fits import all_fitted
from damper_estimator.diagnosis.ranking import Round, round_of
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.diagnosis.trial_fit import TrialFit, linearised
from damper_estimator.model import DamperModel
from damper_estimator.model.element import labels
from damper_estimator.numerics import damped_step

_FITTED = 6  # pairs
_FAR = 10.0  # times what explains all of the error: steps are hardly damped

Couple = tuple[tuple[Hypothesis, Hypothesis], tuple[np.ndarray, np.ndarray]]  # with steps from the start values


def paired(
    current: Round,
    single: Hypothesis | None,
    tried: Sequence[Hypothesis],
    names: Collection[str],
    workers: int,
    progress: Callable[[int], None],
) -> tuple[list[Accepted], DamperModel] | None:
    """Two effects that the data support together, and the model with them; None where there are none.

    Args:
        single: the effect that the data support by itself, if any.
        names: of effects that were found before.
    """
    most = limits().pair * single.score if single is not None else 1.0 - limits().gain
    if min((test.error for test in current.tests), default=1.0) > most:
        return None
    data = current.baseline.data
    best = min(
        (_fitted(current, couple, names) for couple in _promising(current, tried)), key=lambda one: one[0], default=None
    )
    if best is None or best[0] > most:
        return None
    _, model, (first, second) = best
    other, alone = first, second
    found: list[Accepted] = []
    for _ in range(2):
        again = _round_without(current, tried, model, [*names, other], alone, workers, progress)
        best = again.best
        if best is None or again.reason_against(best, data.force_rms):
            return None
        found.append(accepted_in(again, best))
        alone, other = other, best.name
        changed = best.fitted_into(again.baseline.model)
        model = fitted_together(changed, [*names, alone, other], data, current.refits)
    later, earlier = found
    phenomena = [one.element.effect.phenomenon for one in (earlier, later)]
    return [replace(earlier, partner=phenomena[1]), replace(later, partner=phenomena[0])], model


def _promising(current: Round, tried: Sequence[Hypothesis]) -> list[Couple]:
    """Pairs of different phenomena that leave least to first order, the best one of each two phenomena."""
    terms = [(h, linearised(current.baseline, h)) for h in tried if h.effect.kind != "series"]
    terms = [(hypothesis, one) for hypothesis, one in terms if one.sizes.any()]
    alone = {hypothesis.name: _first_order(current, one)[0] for hypothesis, one in terms}
    found: dict[tuple[str, str], tuple[float, Couple]] = {}
    for (a, one), (b, other) in combinations(terms, 2):
        key = a.phenomenon, b.phenomenon
        left, steps = _first_order(current, one, other)
        needed = left < (1.0 - limits().beyond) * min(alone[a.name], alone[b.name])
        left += _penalty((a, b))
        if key[0] != key[1] and needed and left < found.get(key, (1.0,))[0]:
            found[key] = left, ((a, b), (steps[0], steps[1]))
    return [couple for _, couple in sorted(found.values(), key=lambda one: one[0])[:_FITTED]]


def _first_order(current: Round, *added: TrialFit) -> tuple[float, list[np.ndarray]]:
    """What effects leave, and the steps of their parameters from the start values."""
    baseline, residual, columns = current.baseline, [], []
    for part in ("fit", "unseen"):
        residual.append(getattr(baseline, f"residual_{part}") + sum(getattr(one, f"change_{part}") for one in added))
        known = (
            getattr(baseline, f"found_{part}"),
            getattr(baseline, f"base_{part}")[:, : None if current.refits else 0],
        )
        columns.append(np.hstack([*(getattr(one, f"derivatives_{part}") for one in added), *known]))
    step = damped_step(columns[0], residual[0], _FAR)
    after = [rows + by @ step for rows, by in zip(residual, columns, strict=True)]
    ends = np.cumsum([0, *(one.sizes.size for one in added)])
    steps = [step[begin:end] * one.sizes for one, begin, end in zip(added, ends[:-1], ends[1:], strict=True)]
    return _left(current, errors(baseline.data.blocks, *after)), steps


def _fitted(current: Round, couple: Couple, names: Collection[str]) -> tuple[float, DamperModel, tuple[str, str]]:
    """What a pair leaves, the model with it, and its names."""
    model, data = current.baseline.model, current.baseline.data
    added = tuple(hypothesis.name for hypothesis in couple[0])
    for hypothesis, step in zip(*couple, strict=True):
        model, places = hypothesis.added_to(model)
        vector = np.array([slot.value for slot in model.slots])
        low, high = (np.array([getattr(model.slots[i].parameter, end) for i in places]) for end in ("lower", "upper"))
        vector[list(places)] = np.clip(vector[list(places)] + step, low, high)
        model = model.with_vector(vector)
    model = fitted_together(model, [*names, *added], data, current.refits)
    rows = [force_rows(model, part) - targets(part) for part in (data.fit, data.unseen)]
    left = _left(current, errors(data.blocks, *rows)) + _penalty(couple[0])
    return (left if np.isfinite(left) else np.inf), model, added


def _penalty(couple: Sequence[Hypothesis]) -> float:
    return limits().penalty * sum(hypothesis.size for hypothesis in couple)


def _left(current: Round, left: Errors) -> float:
    fit, unseen = np.sum(left.fit**2) / np.sum(current.without.fit**2), left.square / current.without.square
    return float(np.sqrt(fit * unseen))


def _round_without(
    current: Round,
    tried: Sequence[Hypothesis],
    model: DamperModel,
    others: Collection[str],
    name: str,
    workers: int,
    progress: Callable[[int], None],
) -> Round:
    """A round on the model without its effect ``name``, which competes against all others again."""
    label, element = [(label, one) for label, one in labels(model.effects) if one.effect.name == name][-1]
    less = model.without(label)
    base = None if current.refits else ()
    baseline = baseline_of(less, current.baseline.data, positions(less, others), base)
    rivals = [replace(h, element=element) if h.name == name else h for h in tried if h.name not in others]
    return round_of(baseline, all_fitted(baseline, rivals, 0.0, workers, progress), current.mode)
