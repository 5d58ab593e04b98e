"""Joint identification over recordings that lie on workers."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np
from distributed import Client

from damper_estimator.fleet.held import Source, error_bound, error_sums
from damper_estimator.fleet.remote import RemoteRows
from damper_estimator.fleet.shares import Shares
from damper_estimator.identification import Fit, Problem, Wishes, free_slots
from damper_estimator.identification.fit import identified, parameters_of, warnings_of
from damper_estimator.identification.knots import with_knots_over
from damper_estimator.identification.record import record_of, region_of
from damper_estimator.identification.rows import pooled
from damper_estimator.identification.selection import narrowed
from damper_estimator.model import DamperModel
from damper_estimator.model.model_files import model_yaml


def fit_spread(
    client: Client,
    model: DamperModel,
    sources: Iterable[Source],
    free: Iterable[str] = (),
    fix: Iterable[str] = (),
    method: str = "least_squares",
    wishes: Wishes = Wishes(),
    limits: Mapping[str, tuple[float, float]] | None = None,
    starts: int | None = None,
) -> tuple[Fit, dict[Source, str]]:
    """Identifies a model on all sources together, as ``identification.fit`` would with all of them here.

    Returns:
        the fit, and why a source could not be used, for those that could not.

    Raises:
        InputError: as ``identification.fit``.
    """
    began = perf_counter()
    shares = Shares(client, sources, model)
    placed = with_knots_over(model, shares.channel)
    chosen, slots = free_slots(placed, free, fix), narrowed(placed, limits or {})
    problem = Problem(placed, RemoteRows(shares), chosen, slots=slots)
    solution, known = identified(problem, method, starts, wishes)
    fitted = problem.model_at(problem.vector(solution.point.searched, solution.point.solved))
    parameters = parameters_of(problem, solution, known)
    before, after = (_errors(shares, own) for own in (model, fitted))
    filters = [own.filters for own in shares.summaries]
    lost = sum(own.lost for own in shares.summaries)
    bags = list(dict.fromkeys(problem.recordings))
    errors = {p.name: p.standard_error for p in parameters}
    # The largest of the parts covers at least what that of all together would.
    bound = max(float(own[0]) for own in shares.ask(error_bound, model_yaml(fitted)))
    record = record_of(bags, filters[0], region_of(shares.channel), (after.rmse_n, bound), errors)
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
    return fit, shares.refused


@dataclass(frozen=True)
class _Errors:
    rmse_n: float
    esr: float
    samples: int


def _errors(shares: Shares, model: DamperModel) -> _Errors:
    told: Sequence[np.ndarray] = shares.ask(error_sums, model_yaml(model))
    (count, mean, deviations), (_, _, force) = (pooled(np.array([own[i] for own in told])) for i in range(2))
    rmse = float(np.sqrt(deviations / count + mean**2))
    return _Errors(rmse, deviations / force if force > 0.0 else float("nan"), int(count))
