"""Tries one effect on a model: its parameters are fitted, the error that is left is told for unseen data.

The effect's own parameters are fitted with all others kept.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from damper_estimator.diagnosis.candidates import Candidate
from damper_estimator.diagnosis.null import Null, derivatives, slot_size
from damper_estimator.diagnosis.scene import Scene, force_rows, targets
from damper_estimator.identification import LocalRows, Point, Problem
from damper_estimator.identification.methods.least_squares import refine
from damper_estimator.identification.rows import Rows
from damper_estimator.identification.start_points import candidates as start_sizes
from damper_estimator.model import Element
from damper_estimator.model.element import walk

_ITERATIONS = 10
_GAIN = 1e-3
_FINISHING = 4  # iterations on all of the data, from where excerpts led
_TRIED = 2  # of the starts are gone on with
_SKETCH = 6000  # samples on which starts are compared
_RANGE = 0.05  # of what is physical: the size of a parameter that starts at zero
_SILENT = 1e-9  # of the force's rows
_SILENT_SLOPE = 1e-7  # the same for differences, whose rounding is larger


@dataclass(frozen=True)
class Attempt:
    """A candidate with fitted parameters.

    Attributes:
        effect, phenomenon, size: of the candidate; ``size`` counts its parameters.
        values: of its parameters by name.
        at_bound: addresses of those that stopped at a physical limit.
        own_fit, own_unseen: (r, k) derivatives by its parameters, each times the parameter's size; k is 0 where the
            attempt explains too little to need them.
        sizes: (k,) of its parameters.
        change_fit, change_unseen: (r,) what it adds to the force.
        hidden: whether the freed zero of the gauge hides all that it does.
    """

    effect: str
    phenomenon: str
    size: int
    values: dict[str, float | tuple[float, ...]]
    at_bound: tuple[str, ...]
    own_fit: np.ndarray
    own_unseen: np.ndarray
    sizes: np.ndarray
    change_fit: np.ndarray
    change_unseen: np.ndarray
    hidden: bool

    def element(self, candidate: Candidate) -> Element:
        """The entry with the fitted values."""
        return candidate.element.with_values(self.values)


def attempt(null: Null, candidate: Candidate, worth: float = 0.0) -> Attempt:
    """Fits the candidate's parameters and tells what it changes on both parts of the scene.

    Args:
        worth: share of the squared error on the fit rows; what explains less gets no derivatives, and counts as it is.
    """
    if not null.speaks_for(candidate):
        return _untried(null, candidate)
    given, scene = null.stage(candidate.effect.kind)
    problem = candidate.problem(given, scene.fit)
    vector = _fitted(problem, candidate, scene)
    model = problem.model_at(vector)
    force_fit, force_unseen = force_rows(model, scene.fit), force_rows(model, scene.unseen)
    change_fit = np.nan_to_num(force_fit - null.residual_fit - targets(scene.fit))
    change_unseen = np.nan_to_num(force_unseen - null.residual_unseen - targets(scene.unseen))
    free = list(problem.free)
    sizes = np.array([slot_size(model.slots[i]) for i in free])
    explained = 1.0 - float(np.sum((null.residual_fit + change_fit) ** 2) / max(np.sum(null.residual_fit**2), 1e-300))
    silent = _is_silent(change_fit, scene)
    if explained >= worth or silent:
        own_fit = derivatives(model, scene.fit, free, force_fit)
        own_unseen = derivatives(model, scene.unseen, free, force_unseen)
    else:
        own_fit, own_unseen = np.zeros((change_fit.size, 0)), np.zeros((change_unseen.size, 0))
    return Attempt(
        effect=candidate.effect.name,
        phenomenon=candidate.effect.phenomenon,
        size=candidate.size,
        values=dict(list(walk(model.effects))[model.slots[free[0]].entry].parameters),
        at_bound=_at_bound(problem, vector),
        own_fit=own_fit,
        own_unseen=own_unseen,
        sizes=sizes,
        change_fit=change_fit,
        change_unseen=change_unseen,
        hidden=silent and _is_silent(own_fit, scene, _SILENT_SLOPE),
    )


def unfitted(null: Null, candidate: Candidate) -> Attempt:
    """The candidate at its start values: what it changes, and its derivatives there, each as large as the residual."""
    given, scene = null.stage(candidate.effect.kind)
    problem = candidate.problem(given, scene.fit)
    model, free = problem.model_at(np.array([slot.value for slot in problem.slots])), list(problem.free)
    force_fit, force_unseen = force_rows(model, scene.fit), force_rows(model, scene.unseen)
    own_fit = derivatives(model, scene.fit, free, force_fit)
    size = np.sqrt(np.sum(own_fit**2, axis=0))
    felt = size > _SILENT * np.sqrt(np.sum(targets(scene.fit) ** 2))
    scale = np.where(felt, np.sqrt(np.sum(null.residual_fit**2)) / np.where(felt, size, 1.0), 0.0)
    return replace(
        _untried(null, candidate),
        own_fit=own_fit * scale,
        own_unseen=derivatives(model, scene.unseen, free, force_unseen) * scale,
        sizes=scale * [slot_size(model.slots[i]) for i in free],
        change_fit=np.nan_to_num(force_fit - null.residual_fit - targets(scene.fit)),
        change_unseen=np.nan_to_num(force_unseen - null.residual_unseen - targets(scene.unseen)),
    )


def _untried(null: Null, candidate: Candidate) -> Attempt:
    """A candidate that the form-free tests rule out: it changes nothing."""
    fit, unseen = null.residual_fit.size, null.residual_unseen.size
    return Attempt(
        effect=candidate.effect.name,
        phenomenon=candidate.effect.phenomenon,
        size=candidate.size,
        values=dict(candidate.element.parameters),
        at_bound=(),
        own_fit=np.zeros((fit, 0)),
        own_unseen=np.zeros((unseen, 0)),
        sizes=np.ones(candidate.size),
        change_fit=np.zeros(fit),
        change_unseen=np.zeros(unseen),
        hidden=False,
    )


def _is_silent(rows: np.ndarray, scene: Scene, share: float = _SILENT) -> bool:
    """Whether rows are rounding beside the force's."""
    return bool(np.abs(rows).max(initial=0.0) <= share * np.abs(targets(scene.fit)).max())


def _fitted(problem: Problem, candidate: Candidate, scene: Scene) -> np.ndarray:
    """(slots,) values after the search from the best starts."""
    start, iterations = problem.start, _ITERATIONS
    if candidate.starts and problem.searched.size:
        found = sketched(problem.on(LocalRows(sketch(scene.fit))), candidate)
        if found is None:
            return problem.vector(start, np.array([problem.slots[i].value for i in problem.solved]))
        start, iterations = found.searched, _FINISHING
    if not problem.searched.size:
        point = problem.point(start)
    else:
        point, _ = refine(problem, start, _sizes(problem), iterations, _GAIN)
    return problem.vector(point.searched, point.solved)


def sketched(problem: Problem, candidate: Candidate) -> Point | None:
    """Where the best of the candidate's starts lead, on a problem with few rows; None where none can be computed."""
    if not problem.searched.size:
        return problem.point(problem.start)
    starts = candidate.start_points(problem)
    costs = np.array([problem.point(start).cost for start in starts])
    best = np.argsort(costs, kind="stable")[:_TRIED]
    size = _sizes(problem)
    ends = [refine(problem, starts[i], size, _ITERATIONS, _GAIN)[0] for i in best if np.isfinite(costs[i])]
    return min(ends, key=lambda end: end.cost, default=None)


def _sizes(problem: Problem) -> np.ndarray:
    """(q,) magnitudes of the searched parameters; one that starts at zero has a share of its range."""
    _, size = start_sizes(problem, 0, 0)
    span = problem.upper[problem.searched] - problem.lower[problem.searched]
    return np.where(problem.start == 0.0, np.maximum(size, _RANGE * span), size)


def sketch(rows: Sequence[Rows]) -> list[Rows]:
    """Excerpts of the recordings, on which starts are compared."""
    total = sum(len(part.measurement.kinematics) for part in rows)
    if total <= _SKETCH:
        return list(rows)
    return [part for part in LocalRows(rows).excerpts(_SKETCH, total).rows if part.picks.size > 2]


def _at_bound(problem: Problem, vector: np.ndarray) -> tuple[str, ...]:
    names = []
    for i in problem.free:
        low, high = problem.lower[i], problem.upper[i]
        if min(vector[i] - low, high - vector[i]) <= 1e-6 * (high - low):
            names.append(problem.slots[i].address)
    return tuple(names)
