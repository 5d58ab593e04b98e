"""Joint identification over recordings that are distributed over workers."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np
from distributed import Client

from damper_estimator.fleet.distributed_recordings import DistributedRecordings
from damper_estimator.fleet.remote_rows import RemoteRows
from damper_estimator.fleet.worker_recordings import Source, error_sums, largest_errors
from damper_estimator.identification import Fit, MethodOptions, Problem, free_slots
from damper_estimator.identification.error_bound import force_stddev
from damper_estimator.identification.fit import identified, parameters_of, warnings_of
from damper_estimator.identification.fit_record import record_of, region_of
from damper_estimator.identification.knots import with_knots_over
from damper_estimator.identification.rows import pooled
from damper_estimator.identification.selection import narrowed
from damper_estimator.model import DamperModel
from damper_estimator.model.model_files import model_yaml


def fit_distributed(
    client: Client,
    model: DamperModel,
    sources: Iterable[Source],
    free: Iterable[str] = (),
    fix: Iterable[str] = (),
    method: str = "least_squares",
    method_options: MethodOptions = MethodOptions(),
    limits: Mapping[str, tuple[float, float]] | None = None,
    starts: int | None = None,
) -> tuple[Fit, dict[Source, str]]:
    """Identifies a model on all sources together, as ``identification.fit`` does in one process.

    Returns:
        the fit, and the reason for each source that could not be used.

    Raises:
        InputError: as ``identification.fit``.
    """
    began = perf_counter()
    recordings = DistributedRecordings(client, sources, model)
    placed = with_knots_over(model, recordings.channel)
    chosen, slots = free_slots(placed, free, fix), narrowed(placed, limits or {})
    problem = Problem(placed, RemoteRows(recordings), chosen, slots=slots)
    solution, known = identified(problem, method, starts, method_options)
    fitted = problem.model_at(problem.vector(solution.point.searched, solution.point.solved))
    parameters = parameters_of(problem, solution, known)
    before, after = (_errors(recordings, each) for each in (model, fitted))
    filters = [summary.filters for summary in recordings.summaries]
    lost = sum(summary.lost for summary in recordings.summaries)
    bags = list(dict.fromkeys(problem.recordings))
    errors = {p.name: p.standard_error for p in parameters}
    bound = force_stddev(np.concatenate(recordings.ask(largest_errors, model_yaml(fitted))))
    record = record_of(
        bags, filters[0], region_of(recordings.channel), (after.rmse_n, bound), after.force_rms_n, errors
    )
    fit = Fit(
        model=replace(fitted, fit=record),
        parameters=parameters,
        rmse_n=after.rmse_n,
        esr=after.esr,
        rmse_before_n=before.rmse_n,
        esr_before=before.esr,
        samples=after.samples,
        seconds=perf_counter() - began,
        evaluations=solution.evaluations,
        converged=solution.converged,
        undetermined=known.undetermined,
        warnings=warnings_of(problem, model, solution, known, lost, set(filters)),
        front=solution.front,
    )
    return fit, recordings.refused


@dataclass(frozen=True)
class _Errors:
    rmse_n: float
    esr: float
    samples: int
    force_rms_n: float


def _errors(recordings: DistributedRecordings, model: DamperModel) -> _Errors:
    answers: Sequence[np.ndarray] = recordings.ask(error_sums, model_yaml(model))
    (count, mean, deviations), (_, _, force) = (pooled(np.array([sums[i] for sums in answers])) for i in range(2))
    rmse = float(np.sqrt(deviations / count + mean**2))
    esr = deviations / force if force > 0.0 else float("nan")
    return _Errors(rmse, esr, int(count), float(np.sqrt(force / count)))
