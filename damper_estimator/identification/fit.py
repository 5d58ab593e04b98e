"""Identification: the parameters with which a model agrees best with what was measured."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import NoReturn

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.identification.fit_record import fit_record
from damper_estimator.identification.knots import moved_knots, with_placed_knots
from damper_estimator.identification.local_rows import LocalRows
from damper_estimator.identification.methods.contract import MethodOptions, Solution, find_method
from damper_estimator.identification.methods.least_squares import best_start
from damper_estimator.identification.pareto_front import Front
from damper_estimator.identification.problem import Problem
from damper_estimator.identification.rigid import with_rigid_starts
from damper_estimator.identification.rows import COMPARED, Rows, check_motion, pooled_error, rows_of, usable
from damper_estimator.identification.selection import free_slots, narrowed
from damper_estimator.identification.start_points import candidates
from damper_estimator.identification.ties import tied, with_inert_at_start, with_ties_applied
from damper_estimator.identification.uncertainty import Uncertainty, uncertainty
from damper_estimator.identification.unknowns import Unknowns
from damper_estimator.model import DamperModel
from damper_estimator.signals import Measurement

SKETCH_SAMPLES = 8000  # about so many are used to compare the starts
_ROWS_PER_PARAMETER = 3
_FEWEST_ROWS = 20


@dataclass(frozen=True)
class FittedParameter:
    """One identified number.

    Attributes:
        name: address, such as ``coulomb.force``.
        value: in ``unit``.
        standard_error: of the value; NaN at a bound, and where the data do not determine it.
        at_bound: the fit stopped at the declared bound.
    """

    name: str
    value: float
    standard_error: float
    unit: str
    at_bound: bool


@dataclass(frozen=True)
class Fit:
    """An identified model, and how far it can be trusted.

    Attributes:
        model: with the new values and its ``fit`` record.
        parameters: those that were identified.
        rmse_n, esr: error in band over all judged samples of all recordings, N and 1.
        rmse_before_n, esr_before: the same of the model as it was given.
        samples: judged samples.
        seconds: time taken.
        evaluations: runs of the model, or a part of it, over all data.
        converged: whether the search met its criterion.
        undetermined: groups of addresses that these data cannot separate; a group of one has no influence on the
            force.
        warnings: for the user, one sentence each.
        front: of a method with several objectives.
    """

    model: DamperModel
    parameters: tuple[FittedParameter, ...]
    rmse_n: float
    esr: float
    rmse_before_n: float
    esr_before: float
    samples: int
    seconds: float
    evaluations: int
    converged: bool
    undetermined: tuple[tuple[str, ...], ...]
    warnings: tuple[str, ...]
    front: Front | None = None


def fit(
    model: DamperModel,
    measurements: Sequence[Measurement],
    free: Iterable[str] = (),
    fix: Iterable[str] = (),
    method: str = "least_squares",
    seed: int = 0,
    weights: Sequence[float | np.ndarray] | None = None,
    starts: int | None = None,
    method_options: MethodOptions = MethodOptions(),
    limits: Mapping[str, tuple[float, float]] | None = None,
    zero: int = COMPARED,
    thinned: bool = False,
) -> Fit:
    """Identifies a model's free parameters on all measurements together.

    Args:
        free, fix: see ``selection.free_slots``.
        seed: of random draws; equal seeds return equal results.
        weights: of the squared error, per measurement a number or (n,); equal for all samples where left out.
        starts: start points spread around the model's values; 0 to begin at these alone.
        method_options: further settings of the method; its seed is ``seed``.
        limits: lowest and highest value by name, narrower than the declared bounds.
        zero: of the gauge in each recording, see ``rows``.
        thinned: search at the rate that the band asks for only; the errors are those over all samples.

    Raises:
        InputError: no parameters or too few samples to fit, no force, a channel that the model needs and no
            recording has.
    """
    began = perf_counter()
    given = list(measurements) or _refuse("there are no recordings to fit to")
    rows = judged_rows(model, given, [1.0] * len(given) if weights is None else weights, zero=zero)
    placed = with_placed_knots(model, [recording.measurement for recording in rows])
    problem = Problem(placed, LocalRows(rows), free_slots(placed, free, fix), slots=narrowed(placed, limits or {}))
    problem = problem.thinned() if thinned else problem
    solution, known = identified(problem, method, starts, replace(method_options, seed=seed))
    warnings = warnings_of(problem, model, solution, known, *lost_and_filters(rows, given))
    return result(model, problem, rows, solution, known, perf_counter() - began, warnings)


def identified(
    problem: Problem, method: str, starts: int | None, method_options: MethodOptions
) -> tuple[Solution, Uncertainty]:
    """The method's solution of the problem, and its uncertainty.

    Raises:
        InputError: unknown method, too few samples, no finite force.
    """
    chosen = find_method(method)
    _check_enough(problem)
    starts_at, size = candidates(problem, method_options.seed, starts)
    sketch = problem.thinned().excerpts(SKETCH_SAMPLES)
    starts_at = with_rigid_starts(problem, sketch, starts_at, method_options.seed, best_start)
    solution = chosen.search(problem, sketch, starts_at, size, method_options)
    if not np.isfinite(solution.point.cost):
        name = problem.model.name
        raise InputError(
            f"model {name}: returns no finite force from any start value; correct its values or fix some parameters"
        )
    return _tied(problem, solution, np.maximum(np.abs(solution.point.searched), 0.1 * size), chosen.several)


def _tied(problem: Problem, solution: Solution, size: np.ndarray, several: bool) -> tuple[Solution, Uncertainty]:
    """The solution with the points of tables that the data leave open tied to the others.

    With ``several`` objectives the others stay, as they reflect the user's choice between the objectives.
    """
    near = problem.linearised(solution.point, size)
    point = with_inert_at_start(problem, solution.point, near)
    ties = tied(problem, point, near)
    if ties.tied:
        point = with_ties_applied(problem, point, near, ties, None if several else size)
        near = problem.linearised(point, size)
    return replace(solution, point=point), uncertainty(problem, point, near, ties)


def _refuse(reason: str) -> NoReturn:
    raise InputError(reason)


def judged_rows(
    model: DamperModel,
    given: Sequence[Measurement],
    weights: Sequence[float | np.ndarray],
    settings: Sequence[int] | None = None,
    zero: int = COMPARED,
) -> list[Rows]:
    """The rows of the usable parts of all measurements; ``settings`` of a joint fit, one for each measurement."""
    check_motion(given)
    rows = []
    for measurement, weight, setting in zip(given, weights, settings or [0] * len(given), strict=True):
        parts = usable(model, measurement)
        whole = rows_of(measurement, weight, setting, zero)
        rows += [whole] if parts == [slice(0, whole.weight.size)] else [whole.part(part) for part in parts]
    rows = [recording for recording in rows if recording.picks.size]
    if not rows:
        _refuse(
            f"{', '.join(m.recording for m in given)}: too short, no sample can be judged; "
            "record longer or widen the window"
        )
    return rows


def _check_enough(problem: Problem) -> None:
    count, free = problem.size, len(problem.free)
    needed = max(_FEWEST_ROWS, _ROWS_PER_PARAMETER * free)
    if count < needed:
        _refuse(
            f"{', '.join(problem.recordings)}: only {count} independent samples for {free} parameters, {needed} are "
            "needed; record longer or fix some parameters"
        )


def parameters_of(problem: Unknowns, solution: Solution, known: Uncertainty) -> tuple[FittedParameter, ...]:
    """The identified parameters, in order of ``problem.free``."""
    vector = problem.vector(solution.point.searched, solution.point.solved)
    rows = zip(problem.free, known.standard_error, known.at_bound, strict=True)
    return tuple(
        FittedParameter(slot.address, float(vector[i]), float(error), slot.parameter.unit, bool(bound))
        for i, error, bound in rows
        for slot in [problem.slots[i]]
    )


def result(
    model: DamperModel,
    problem: Unknowns,
    rows: Sequence[Rows],
    solution: Solution,
    known: Uncertainty,
    seconds: float,
    warnings: tuple[str, ...],
    setting: int = 0,
) -> Fit:
    """The fit of one setting, with the errors over its recordings; ``model`` is the one before the fit."""
    began = perf_counter()
    used = [recording.measurement for recording in rows if recording.setting == setting]
    fitted = problem.model_at(problem.vector(solution.point.searched, solution.point.solved), setting)
    every = zip(problem.free, parameters_of(problem, solution, known), strict=True)
    parameters = [replace(p, name=p.name.partition("@")[0]) for i, p in every if i in problem.places[setting]]
    rmse_before, esr_before, _ = pooled_error(model, used)
    rmse, esr, samples = pooled_error(fitted, used)
    record = fit_record(fitted, used, rmse, {p.name: p.standard_error for p in parameters})
    return Fit(
        model=replace(fitted, fit=record),
        parameters=tuple(parameters),
        rmse_n=rmse,
        esr=esr,
        rmse_before_n=rmse_before,
        esr_before=esr_before,
        samples=samples,
        seconds=seconds + perf_counter() - began,
        evaluations=solution.evaluations,
        converged=solution.converged,
        undetermined=known.undetermined,
        warnings=warnings,
        front=solution.front,
    )


def lost_and_filters(rows: Sequence[Rows], given: Sequence[Measurement]) -> tuple[int, set[tuple[float, float]]]:
    """Number of judged samples that are not used, and the filters of the used recordings: cutoff and band, Hz."""
    used = [recording.measurement for recording in rows]
    lost = sum(int(m.judged.sum()) for m in given) - sum(int(m.judged.sum()) for m in used)
    return lost, {(m.cutoff, m.band) for m in used}


def warnings_of(
    problem: Unknowns,
    model: DamperModel,
    solution: Solution,
    known: Uncertainty,
    lost: int,
    filters: Collection[tuple[float, float]],
) -> tuple[str, ...]:
    """Warnings for the user about an identification; ``model`` is the one before it."""
    parameters, moved = parameters_of(problem, solution, known), moved_knots(model, problem.model)
    warnings = [solution.remark] if solution.remark else []
    warnings += [f"the knots of {label} were placed again over the recordings" for label in moved]
    if not solution.converged:
        warnings.append("the search did not converge; the values are the best found")
    bounded = [p.name for p in parameters if p.at_bound]
    if bounded:
        warnings.append(f"at a bound: {', '.join(bounded)}; they have no standard error")
    silent = [group[0] for group in known.undetermined if len(group) == 1 and group[0] not in known.tied]
    if silent:
        warnings.append(
            f"{', '.join(silent)} cannot be determined from these data; "
            "fix them, or record an excitation that shows them"
        )
    if known.tied:
        warnings.append(
            f"{', '.join(known.tied)}: these data do not reach there; set to continue the values that they determine"
        )
    for group in known.undetermined:
        if len(group) > 1:
            warnings.append(
                f"{', '.join(group[:-1])} and {group[-1]} trade off: these data cannot separate them; "
                f"fix {'one' if len(group) == 2 else 'some'} of them"
            )
    if lost:
        warnings.append(f"{lost} samples were left out, where a channel that the model needs was not recorded yet")
    if len(filters) > 1:
        warnings.append("the recordings were filtered differently; the file records the first one's cutoff")
    return tuple(warnings)
