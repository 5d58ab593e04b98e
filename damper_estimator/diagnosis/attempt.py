"""Tries one effect on a model: its parameters are fitted, the error that is left is told for unseen data.

The effect's own parameters are fitted with all others kept. What a common refit would do is told to first order,
from the derivatives of the force by the model's parameters: cheap enough for every candidate.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from damper_estimator.diagnosis.candidates import Candidate
from damper_estimator.diagnosis.frozen import frozen_model, frozen_rows
from damper_estimator.diagnosis.scene import Scene, force_rows, targets
from damper_estimator.identification import LocalRows, Point, Problem
from damper_estimator.identification.methods.least_squares import refine
from damper_estimator.identification.rows import Rows
from damper_estimator.identification.start import candidates as start_sizes
from damper_estimator.model import DamperModel, Element
from damper_estimator.model.element import labels, walk
from damper_estimator.numerics import ROUGH, damped_step, stepped

_ITERATIONS = 10
_GAIN = 1e-3
_FINISHING = 4  # iterations on all of the data, from where excerpts led
_TRIED = 2  # of the starts are gone on with
_SKETCH = 6000  # samples on which starts are compared
_RANGE = 0.05  # of what is physical: the size of a parameter that starts at zero
_HELD = 0.3  # of its size a parameter may move in a first-order refit before it is held back
_SILENT = 1e-9  # of the force's rows
_SILENT_SLOPE = 1e-7  # the same for differences, whose rounding is larger


@dataclass(frozen=True)
class Null:
    """The model as it stands, on both parts of the scene.

    Attributes:
        residual_fit, residual_unseen: (r,) rows, modelled less measured.
        base_fit, base_unseen: (r, p) derivatives by the model's parameters, each times the parameter's size.
        found_fit, found_unseen: (r, f) the same by parameters of effects found before.
    """

    model: DamperModel
    scene: Scene
    residual_fit: np.ndarray
    residual_unseen: np.ndarray
    base_fit: np.ndarray
    base_unseen: np.ndarray
    found_fit: np.ndarray
    found_unseen: np.ndarray

    @cached_property
    def frozen(self) -> tuple[DamperModel, Scene]:
        """The model as one recorded force, with the scene that carries it."""
        rows = {name: frozen_rows(self.model, getattr(self.scene, name)) for name in ("fit", "unseen")}
        return frozen_model(self.model), replace(self.scene, **rows)

    @cached_property
    def yields(self) -> bool:
        """Whether there is a compliance in the model, so that running it is slow."""
        return any(element.effect.kind == "series" for element in walk(self.model.effects))

    def stage(self, kind: str) -> tuple[DamperModel, Scene]:
        """The model and scene on which an effect of a kind is tried: what acts behind the model need not run it."""
        behind = kind in ("modifier", "channel") or (kind == "source" and self.yields)
        return self.frozen if behind else (self.model, self.scene)


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


def null(model: DamperModel, scene: Scene, found: Sequence[int] = (), base: Sequence[int] | None = None) -> Null:
    """The model on the scene.

    Args:
        found: positions in its slots of parameters that are never kept.
        base: positions of those that a refit moves; all others that are free where left out.
    """
    if base is None:
        base = [i for i, slot in enumerate(model.slots) if i not in found and not slot.fixed]
    fit, unseen = force_rows(model, scene.fit), force_rows(model, scene.unseen)
    return Null(
        model,
        scene,
        fit - targets(scene.fit),
        unseen - targets(scene.unseen),
        near_derivatives(model, scene.fit, base, fit),
        near_derivatives(model, scene.unseen, base, unseen),
        derivatives(model, scene.fit, found, fit),
        derivatives(model, scene.unseen, found, unseen),
    )


def derivatives(model: DamperModel, rows: Sequence[Rows], slots: Sequence[int], force: np.ndarray) -> np.ndarray:
    """(r, k) derivatives of the force rows by parameters, times the parameters' sizes."""
    columns = np.zeros((force.size, len(slots)))
    vector = np.array([slot.value for slot in model.slots])
    for k, i in enumerate(slots):
        slot = model.slots[i]
        size = slot_size(slot)
        changed, step = stepped(vector, i, size, slot.parameter.lower, slot.parameter.upper, ROUGH)
        columns[:, k] = np.nan_to_num((force_rows(model.with_vector(changed), rows) - force) * (size / step))
    return columns


def near_derivatives(model: DamperModel, rows: Sequence[Rows], slots: Sequence[int], force: np.ndarray) -> np.ndarray:
    """(r, k) derivatives by parameters times their sizes; those of a compliance's path as if it were rigid."""
    rigid, origin = model, list(range(len(model.slots)))
    while compliances := [label for label, e in labels(rigid.effects) if e.effect.kind == "series"]:
        own = [slot.address.rpartition(".")[0] == compliances[0] for slot in rigid.slots]
        origin = [i for i, inside in zip(origin, own, strict=True) if not inside]
        rigid = rigid.without(compliances[0])
    if rigid is model or not slots:
        return derivatives(model, rows, slots, force)
    columns = np.zeros((force.size, len(slots)))
    stiff = [k for k, i in enumerate(slots) if i not in origin]
    inner = [k for k, i in enumerate(slots) if i in origin]
    columns[:, stiff] = derivatives(model, rows, [slots[k] for k in stiff], force)
    columns[:, inner] = derivatives(rigid, rows, [origin.index(slots[k]) for k in inner], force_rows(rigid, rows))
    return columns


def slot_size(slot) -> float:
    """How much of a parameter is much."""
    declared = slot.parameter
    return max(abs(slot.value), abs(declared.default), 1e-3 * min(declared.upper - declared.lower, 1e3))


def attempt(null: Null, candidate: Candidate, worth: float = 0.0) -> Attempt:
    """Fits the candidate's parameters and tells what it changes on both parts of the scene.

    Args:
        worth: share of the squared error on the fit rows; what explains less gets no derivatives, and counts as it is.
    """
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
    total = sum(len(own.measurement.kinematics) for own in rows)
    if total <= _SKETCH:
        return list(rows)
    return [own for own in LocalRows(rows).excerpts(_SKETCH, total).rows if own.picks.size > 2]


def _at_bound(problem: Problem, vector: np.ndarray) -> tuple[str, ...]:
    names = []
    for i in problem.free:
        low, high = problem.lower[i], problem.upper[i]
        if min(vector[i] - low, high - vector[i]) <= 1e-6 * (high - low):
            names.append(problem.slots[i].address)
    return tuple(names)


def first_order(
    residual: np.ndarray, columns: np.ndarray, residual_unseen: np.ndarray, columns_unseen: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Residuals (r,) of both parts after a linear refit by ``columns`` (r, k), each in sizes of its parameter.

    A parameter that has to move by much more than a share of its size is held back: beyond, derivatives say little.
    """
    if not columns.shape[1]:
        return residual, residual_unseen
    step = damped_step(columns, residual, _HELD)
    return residual + columns @ step, residual_unseen + columns_unseen @ step
