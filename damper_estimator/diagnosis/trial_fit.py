"""Fits the parameters of one hypothesis to what the model leaves, all other parameters kept."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from damper_estimator.diagnosis.baseline import Baseline, derivatives, slot_size
from damper_estimator.diagnosis.diagnosis_data import DiagnosisData, force_rows, targets
from damper_estimator.diagnosis.hypotheses import Hypothesis
from damper_estimator.identification import LocalRows, Point, Problem
from damper_estimator.identification.methods.least_squares import refine
from damper_estimator.identification.rows import Rows, excerpts, split
from damper_estimator.identification.start_points import candidates as start_sizes
from damper_estimator.model import DamperModel
from damper_estimator.model.element import walk

_ITERATIONS = 10  # on excerpts
_GAIN = 1e-3
_FINISHING = 4  # iterations on all of the data, from where excerpts led
_LITTLE = 0.02  # of the squared error: what explains less on excerpts stays as it is there
_HOPELESS = 2.0  # times what may be left: the first start that leads to more is the last
_BEGINNING = 4  # iterations from each start, before only the best one goes on
_TRIED = 2  # starts that are continued from
_SKETCH = 6000  # samples on which starts are compared
_RANGE = 0.05  # of what is physical: the size of a parameter that starts at zero
_NEAR = 0.01  # of a limit: as good as at it
_ROUNDING = 1e-6  # of the range
_SILENT = 1e-9  # of the force's rows
_SILENT_SLOPE = 1e-7  # the same for differences, whose rounding is larger


@dataclass(frozen=True)
class TrialFit:
    """The fitted parameters of a hypothesis, and what they change.

    Attributes:
        values, settings: of its parameters and settings by name.
        at_bound: addresses of those that stopped at a physical limit.
        derivatives_fit, derivatives_unseen: (r, k) derivatives by its parameters, each times the parameter's size; k is
            0 where it explains too little to need them.
        sizes: (k,) of its parameters.
        change_fit, change_unseen: (r,) what it adds to the force.
        hidden: whether the freed zero of the gauge hides all that it does.
        tried: whether it was fitted at all.
    """

    values: dict[str, float | tuple[float, ...]]
    settings: dict[str, float | tuple[float, ...]]
    at_bound: tuple[str, ...]
    derivatives_fit: np.ndarray
    derivatives_unseen: np.ndarray
    sizes: np.ndarray
    change_fit: np.ndarray
    change_unseen: np.ndarray
    hidden: bool
    tried: bool = True


def trial_fit(
    baseline: Baseline, hypothesis: Hypothesis, worth: float = 0.0, in_any_case: bool = False, most: float = 1.0
) -> TrialFit:
    """Fits the parameters of a hypothesis, and computes what they change on both parts of the data.

    Args:
        worth: share of the squared error on the fit rows; what explains less gets no derivatives, and counts as it is.
        in_any_case: also a hypothesis that the form-free tests rule out.
        most: share of the squared error; what leaves more on excerpts stays as it is there, without derivatives.
    """
    if not (in_any_case or baseline.suggests(hypothesis)):
        return _untried(baseline, hypothesis)
    if hypothesis.conditions:
        each = [hypothesis.under({}), *(hypothesis.under(settings) for settings in hypothesis.conditions)]
        fits = [trial_fit(baseline, one, worth, in_any_case, most) for one in each]
        return min(fits, key=lambda fit: float(np.sum((baseline.residual_fit + fit.change_fit) ** 2)))
    given, data = baseline.for_effect(hypothesis.effect)
    problem = hypothesis.problem(given, data.fit)
    vector = _fitted(problem, hypothesis, baseline.residual_fit, given, data, most)
    model = problem.model_at(vector)
    force_fit, force_unseen = force_rows(model, data.fit), force_rows(model, data.unseen)
    change_fit = np.nan_to_num(force_fit - baseline.residual_fit - targets(data.fit))
    change_unseen = np.nan_to_num(force_unseen - baseline.residual_unseen - targets(data.unseen))
    free = list(problem.free)
    sizes = np.array([slot_size(model.slots[i]) for i in free])
    before, after = (
        float(np.sum(residual**2)) for residual in (baseline.residual_fit, baseline.residual_fit + change_fit)
    )
    explained = 1.0 - after / max(before, 1e-300)
    silent = _is_silent(change_fit, data)
    if explained >= max(worth, 1.0 - most) or silent:
        derivatives_fit = derivatives(model, data.fit, free, force_fit)
        derivatives_unseen = derivatives(model, data.unseen, free, force_unseen)
    else:
        derivatives_fit, derivatives_unseen = np.zeros((change_fit.size, 0)), np.zeros((change_unseen.size, 0))
    return TrialFit(
        values=dict(list(walk(model.effects))[model.slots[free[0]].entry].parameters),
        settings=dict(hypothesis.element.settings),
        at_bound=at_bound(problem, vector, problem.free),
        derivatives_fit=derivatives_fit,
        derivatives_unseen=derivatives_unseen,
        sizes=sizes,
        change_fit=change_fit,
        change_unseen=change_unseen,
        hidden=silent and _is_silent(derivatives_fit, data, _SILENT_SLOPE),
    )


def linearised(baseline: Baseline, hypothesis: Hypothesis) -> TrialFit:
    """The hypothesis at its start values: what it changes, and its derivatives there, each as large as the residual."""
    given, data = baseline.for_effect(hypothesis.effect)
    problem = hypothesis.problem(given, data.fit)
    model, free = problem.model_at(np.array([slot.value for slot in problem.slots])), list(problem.free)
    force_fit, force_unseen = force_rows(model, data.fit), force_rows(model, data.unseen)
    derivatives_fit = derivatives(model, data.fit, free, force_fit)
    size = np.sqrt(np.sum(derivatives_fit**2, axis=0))
    felt = size > _SILENT * np.sqrt(np.sum(targets(data.fit) ** 2))
    scale = np.where(felt, np.sqrt(np.sum(baseline.residual_fit**2)) / np.where(felt, size, 1.0), 0.0)
    return replace(
        _untried(baseline, hypothesis),
        derivatives_fit=derivatives_fit * scale,
        derivatives_unseen=derivatives(model, data.unseen, free, force_unseen) * scale,
        sizes=scale * [slot_size(model.slots[i]) for i in free],
        change_fit=np.nan_to_num(force_fit - baseline.residual_fit - targets(data.fit)),
        change_unseen=np.nan_to_num(force_unseen - baseline.residual_unseen - targets(data.unseen)),
    )


def _untried(baseline: Baseline, hypothesis: Hypothesis) -> TrialFit:
    """Of a hypothesis that the form-free tests rule out: it changes nothing."""
    fit, unseen = baseline.residual_fit.size, baseline.residual_unseen.size
    return TrialFit(
        values=dict(hypothesis.element.parameters),
        settings=dict(hypothesis.element.settings),
        at_bound=(),
        derivatives_fit=np.zeros((fit, 0)),
        derivatives_unseen=np.zeros((unseen, 0)),
        sizes=np.ones(hypothesis.size),
        change_fit=np.zeros(fit),
        change_unseen=np.zeros(unseen),
        hidden=False,
        tried=False,
    )


def _is_silent(rows: np.ndarray, data: DiagnosisData, share: float = _SILENT) -> bool:
    """Whether rows are mere rounding errors of the force's."""
    return bool(np.abs(rows).max(initial=0.0) <= share * np.abs(targets(data.fit)).max())


def _fitted(
    problem: Problem,
    hypothesis: Hypothesis,
    residual: np.ndarray,
    given: DamperModel,
    data: DiagnosisData,
    most: float,
) -> np.ndarray:
    """(slots,) values after the search from the best starts: on excerpts, and on all rows if they explain something."""
    if not problem.searched.size:
        point = problem.point(problem.start)
        return problem.vector(point.searched, point.solved)
    few = sketch(data.fit, residual)
    whole = 0.5 * float(np.sum((force_rows(given, few) - targets(few)) ** 2))
    point = sketched(problem.on(LocalRows(few)), hypothesis, _HOPELESS * most * whole if most < 1.0 else np.inf)
    if point is None:
        return problem.vector(problem.start, np.array([problem.slots[i].value for i in problem.solved]))
    if point.cost <= min(1.0 - _LITTLE, most) * whole:
        point, _ = refine(problem, point.searched, sizes_of(problem), _FINISHING, _GAIN)
    return problem.vector(point.searched, point.solved)


def sketched(problem: Problem, hypothesis: Hypothesis, hopeless: float = np.inf) -> Point | None:
    """Where the best of the hypothesis's starts lead, on a problem with few rows; None where none can be computed.

    Args:
        hopeless: cost; if the best start leads to more, no other is tried.
    """
    if not problem.searched.size:
        return problem.point(problem.start)
    starts = hypothesis.start_points(problem)
    costs = np.array([problem.point(start).cost for start in starts])
    size, begun, moved = sizes_of(problem), [], 0
    for i in np.argsort(costs, kind="stable")[: np.count_nonzero(np.isfinite(costs))]:
        begun.append(refine(problem, starts[i], size, _BEGINNING, _GAIN))
        moved += begun[-1][0].cost < (1.0 - _GAIN) * costs[i]  # what does nothing at a start has no way on from there
        if moved == _TRIED or (moved and begun[-1][0].cost > hopeless):
            break
    end, is_minimum = min(begun, key=lambda one: one[0].cost, default=(None, True))
    return end if is_minimum else refine(problem, end.searched, size, _ITERATIONS - _BEGINNING, _GAIN)[0]


def sizes_of(problem: Problem) -> np.ndarray:
    """(q,) magnitudes of the searched parameters; one that starts at zero has a share of its range."""
    _, size = start_sizes(problem, 0, 0)
    span = problem.upper[problem.searched] - problem.lower[problem.searched]
    return np.where(problem.start == 0.0, np.maximum(size, _RANGE * span), size)


def sketch(rows: Sequence[Rows], residual: np.ndarray | None = None) -> list[Rows]:
    """Excerpts of the recordings, on which starts are compared.

    Args:
        residual: (r,) what is to be explained; where it is large, starts are compared rather than elsewhere: a stop
            that is hit twice is not in most excerpts.
    """
    total = sum(len(part.measurement.kinematics) for part in rows)
    if total <= _SKETCH:
        return list(rows)
    few = []
    errors = [None] * len(rows) if residual is None else split(rows, residual)
    for part, error in zip(rows, errors, strict=True):
        size = len(part.measurement.kinematics)
        square = None if error is None else np.bincount(part.picks, error**2, minlength=size)
        few += [part.part(cut) for cut in excerpts(part.measurement, _SKETCH * size // total, interest=square)]
    return [part for part in few if part.picks.size > 2]


def at_bound(problem: Problem, vector: np.ndarray, slots: Sequence[int]) -> tuple[str, ...]:
    """Addresses of the parameters among ``slots`` that are at a limit of the problem."""
    names = []
    for i in slots:
        if is_at_end(vector[i], problem.lower[i], problem.upper[i]):
            names.append(problem.slots[i].address)
    return tuple(names)


def is_at_end(value: float, low: float, high: float) -> bool:
    """Whether a value stopped at a limit, or so near that only the search ended before it."""
    least = _ROUNDING * (high - low)
    return bool(value - low <= max(_NEAR * abs(low), least) or high - value <= max(_NEAR * abs(high), least))
