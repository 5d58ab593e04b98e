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

from damper_estimator.diagnosis.accepted import Accepted, accepted_in, positions, settled_together, with_found
from damper_estimator.diagnosis.attempt import Attempt, unfitted
from damper_estimator.diagnosis.candidates import Candidate
from damper_estimator.diagnosis.judge import Errors, Tally, errors
from damper_estimator.diagnosis.null import null
from damper_estimator.diagnosis.pool import attempts
from damper_estimator.diagnosis.ranking import Round, round_of
from damper_estimator.diagnosis.scene import force_rows, targets
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.model import DamperModel
from damper_estimator.model.element import labels
from damper_estimator.numerics import damped_step

_FITTED = 6  # pairs
_FAR = 10.0  # times what explains all of the error: steps are hardly held back

Couple = tuple[tuple[Candidate, Candidate], tuple[np.ndarray, np.ndarray]]  # with steps from the start values


def paired(
    current: Round,
    single: Tally | None,
    tried: Sequence[Candidate],
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
    scene = current.null.scene
    best = min(
        (_fitted(current, couple, names) for couple in _promising(current, tried)), key=lambda one: one[0], default=None
    )
    if best is None or best[0] > most:
        return None
    _, model, (first, second) = best
    other, alone = first, second
    found: list[Accepted] = []
    for _ in range(2):
        judged = _judged(current, tried, model, [*names, other], alone, workers, progress)
        best = judged.best
        if best is None or judged.reason_against(best, scene.force_rms):
            return None
        found.append(accepted_in(judged, best))
        alone, other = other, best.attempt.effect
        model = settled_together(
            with_found(judged.null.model, judged, best), [*names, alone, other], scene, current.refits
        )
    later, earlier = found
    phenomena = [one.element.effect.phenomenon for one in (earlier, later)]
    return [replace(earlier, partner=phenomena[1]), replace(later, partner=phenomena[0])], model


def _promising(current: Round, tried: Sequence[Candidate]) -> list[Couple]:
    """Pairs of different phenomena that leave least to first order, the best one of each two phenomena."""
    terms = [(candidate, unfitted(current.null, candidate)) for candidate in tried if candidate.effect.kind != "series"]
    terms = [(candidate, one) for candidate, one in terms if one.sizes.any()]
    alone = {candidate.effect.name: _first_order(current, one)[0] for candidate, one in terms}
    found: dict[tuple[str, str], tuple[float, Couple]] = {}
    for (a, one), (b, other) in combinations(terms, 2):
        key = a.effect.phenomenon, b.effect.phenomenon
        left, steps = _first_order(current, one, other)
        needed = left < (1.0 - limits().own) * min(alone[a.effect.name], alone[b.effect.name])
        left += _penalty((a, b))
        if key[0] != key[1] and needed and left < found.get(key, (1.0,))[0]:
            found[key] = left, ((a, b), (steps[0], steps[1]))
    return [couple for _, couple in sorted(found.values(), key=lambda one: one[0])[:_FITTED]]


def _first_order(current: Round, *added: Attempt) -> tuple[float, list[np.ndarray]]:
    """What effects leave, and the steps of their parameters from the start values."""
    null, residual, columns = current.null, [], []
    for part in ("fit", "unseen"):
        residual.append(getattr(null, f"residual_{part}") + sum(getattr(one, f"change_{part}") for one in added))
        known = getattr(null, f"found_{part}"), getattr(null, f"base_{part}")[:, : None if current.refits else 0]
        columns.append(np.hstack([*(getattr(one, f"own_{part}") for one in added), *known]))
    step = damped_step(columns[0], residual[0], _FAR)
    after = [rows + by @ step for rows, by in zip(residual, columns, strict=True)]
    ends = np.cumsum([0, *(one.sizes.size for one in added)])
    steps = [step[begin:end] * one.sizes for one, begin, end in zip(added, ends[:-1], ends[1:], strict=True)]
    return _left(current, errors(null.scene.blocks, *after)), steps


def _fitted(current: Round, couple: Couple, names: Collection[str]) -> tuple[float, DamperModel, tuple[str, str]]:
    """What a pair leaves, the model with it, and its names."""
    model, scene = current.null.model, current.null.scene
    added = tuple(candidate.effect.name for candidate in couple[0])
    for candidate, step in zip(*couple, strict=True):
        model, places = candidate.added_to(model)
        vector = np.array([slot.value for slot in model.slots])
        low, high = (np.array([getattr(model.slots[i].parameter, end) for i in places]) for end in ("lower", "upper"))
        vector[list(places)] = np.clip(vector[list(places)] + step, low, high)
        model = model.with_vector(vector)
    model = settled_together(model, [*names, *added], scene, current.refits)
    rows = [force_rows(model, part) - targets(part) for part in (scene.fit, scene.unseen)]
    left = _left(current, errors(scene.blocks, *rows)) + _penalty(couple[0])
    return (left if np.isfinite(left) else np.inf), model, added


def _penalty(couple: Sequence[Candidate]) -> float:
    return limits().penalty * sum(candidate.size for candidate in couple)


def _left(current: Round, left: Errors) -> float:
    fit, unseen = np.sum(left.fit**2) / np.sum(current.without.fit**2), left.square / current.without.square
    return float(np.sqrt(fit * unseen))


def _judged(
    current: Round,
    tried: Sequence[Candidate],
    model: DamperModel,
    others: Collection[str],
    name: str,
    workers: int,
    progress: Callable[[int], None],
) -> Round:
    """A round on the model without its effect ``name``, which competes against all others again."""
    label, element = [(label, one) for label, one in labels(model.effects) if one.effect.name == name][-1]
    less = model.without(label)
    stage = null(less, current.null.scene, positions(less, others), None if current.refits else ())
    rivals = [
        replace(one, element=element) if one.effect.name == name else one
        for one in tried
        if one.effect.name not in others
    ]
    return round_of(stage, rivals, attempts(stage, rivals, 0.0, workers, progress), current.mode)
