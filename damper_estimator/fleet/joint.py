"""Joint identification over recordings that lie on workers: what travels are parameters, and sums over recordings.

A least-squares search needs of its rows only what a QR decomposition keeps of them. So each recording is reduced, where
it lies, to a triangle of its derivatives and residual (Demmel et al. 2012, TSQR), k + 1 numbers square for k
parameters; the triangles of all recordings, one below the other in their order, are a problem of a few rows per
recording with the same solution. Nothing is squared, so it is as exact as the fit in one process.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np
from distributed import Client

from damper_estimator.fleet.held import (
    Chosen,
    Place,
    Source,
    Unknown,
    cycles,
    error_sums,
    excited_errors,
    excited_sizes,
    linear_sums,
    model_of,
    noise_sums,
    point_sums,
)
from damper_estimator.fleet.shares import Shares
from damper_estimator.fleet.task import digest
from damper_estimator.identification import Fit, Point, Wishes, free_slots
from damper_estimator.identification.excitations import filled, split_of
from damper_estimator.identification.fit import identified, parameters_of, warnings_of
from damper_estimator.identification.knots import with_knots_over
from damper_estimator.identification.problem import is_silent, loudly_reduced, without
from damper_estimator.identification.record import record_of, region_of
from damper_estimator.identification.rows import natural_sizes, pooled
from damper_estimator.identification.selection import narrowed
from damper_estimator.identification.unknowns import Unknowns
from damper_estimator.model import DamperModel
from damper_estimator.model.files import model_yaml
from damper_estimator.numerics import bounded_least_squares


@dataclass(frozen=True)
class SpreadLinear:
    """As ``identification.problem.Linearised``, of recordings that lie elsewhere.

    Attributes:
        reduced: triangle over all recordings.
        silent: (q,) bool.
        ask: for the noise in given directions.
    """

    reduced: np.ndarray
    silent: np.ndarray
    ask: Callable[[np.ndarray], list]

    def noise(self, weights: np.ndarray) -> tuple[np.ndarray, float]:
        """As ``Linearised.noise``."""
        told = self.ask(without(self.silent, weights))
        return np.sum([total for total, _ in told], axis=0), float(sum(effective for _, effective in told))


class SpreadProblem(Unknowns):
    """As ``identification.Problem``, of recordings that lie elsewhere; final."""

    def __init__(self, shares: Shares, unknown: Unknown) -> None:
        super().__init__(model_of(unknown.model), unknown.free, slots=unknown.slots)
        self._shares, self._unknown = shares, unknown
        self.evaluations = 0
        self.recordings = tuple(own.recording for own in shares.sources)
        self.size = sum(own.rows for own in shares.summaries)
        self.power = float(sum(own.power for own in shares.summaries))

    def excerpts(self, samples: int) -> "SpreadProblem":
        """As ``Problem.excerpts``."""
        total = self._shares.samples
        if total <= samples:
            return self
        key = digest([self._unknown.key, samples])
        small = SpreadProblem(self._shares, replace(self._unknown, key=key, samples=samples, total=total))
        small.size = max(self.size * samples // total, 1)
        small.power = self.power * small.size / self.size
        return small

    def excited(self, given: Mapping[str, Sequence[str]]) -> "SpreadExcited":
        """As ``Problem.excited``."""
        return SpreadExcited(self._shares, self._unknown, given)

    def natural_sizes(self) -> tuple[float, float, float]:
        """As ``Problem.natural_sizes``."""
        return natural_sizes([part for own in self._shares.summaries for part in own.moments])

    def point(self, searched: np.ndarray, solved: np.ndarray | None = None) -> Point:
        """As ``Problem.point``; its rows are those of the triangles."""
        self.evaluations += 1
        own = self._start[self.solved]
        rows = np.concatenate(self._shares.ask(point_sums, self._unknown, searched, own))
        columns, target = rows[:, :-1], rows[:, -1]
        if not np.isfinite(rows).all():
            return Point(searched, own, -target, columns, float("inf"))
        if solved is None:
            low, high = self.lower[self.solved], self.upper[self.solved]
            solved = bounded_least_squares(columns, target, low, high, np.clip(own, low, high))
        residual = columns @ solved - target
        return Point(searched, solved, residual, columns, 0.5 * float(residual @ residual))

    def linearised(self, point: Point, size: np.ndarray) -> SpreadLinear:
        """As ``Problem.linearised``."""
        self.evaluations += self.searched.size
        asked = (self._unknown, Place(point.searched, point.solved, size))
        rows = np.concatenate(self._shares.ask(linear_sums, *asked))
        silent = is_silent(rows[:, : size.size], size, self.power)
        return SpreadLinear(
            loudly_reduced(rows, silent), silent, lambda weights: self._shares.ask(noise_sums, *asked, weights)
        )


class SpreadExcited:
    """As ``identification.excited.Excited``, of recordings that lie elsewhere; final."""

    def __init__(self, shares: Shares, unknown: Unknown, given: Mapping[str, Sequence[str]]) -> None:
        split = split_of([part for own in shares.ask(cycles) for part in own])
        chosen = Chosen({name: tuple(own) for name, own in given.items()}, split)
        told = shares.ask(excited_sizes, chosen)
        self._shares, self._told = shares, told
        groups = tuple(given) or split.names
        counts = [sum(own[k].size for own, _ in told) for k in range(len(groups))]
        self._kept = filled(counts, groups, given)
        self.groups = tuple(groups[k] for k in self._kept)
        self.sizes = [np.concatenate([own[k] for own, _ in told]) for k in self._kept]
        self._unknown = replace(unknown, key=digest([unknown.key, repr(chosen)]), chosen=chosen)
        self.problem = self._on(self._unknown)

    def _on(self, unknown: Unknown) -> SpreadProblem:
        problem = SpreadProblem(self._shares, unknown)
        problem.size = sum(size for _, size in self._told)
        return problem

    def errors(self, vectors: np.ndarray) -> list[list[np.ndarray]]:
        """As ``Excited.errors``; all vectors are asked for together."""
        told = self._shares.ask(excited_errors, self._unknown, vectors)
        return [[np.concatenate([own[i][k] for own in told]) for k in self._kept] for i in range(len(vectors))]

    def weighted(self, weights: Sequence[np.ndarray]) -> SpreadProblem:
        """As ``Excited.weighted``."""
        ends = [np.cumsum([own[k].size for own, _ in self._told])[:-1] for k in self._kept]
        parts = dict(zip(self._kept, (np.split(own, end) for own, end in zip(weights, ends, strict=True)), strict=True))
        mine = {
            source: [parts[k][i] if k in parts else np.zeros(0) for k in range(len(own))]
            for i, (source, (own, _)) in enumerate(zip(self._shares.sources, self._told, strict=True))
        }
        key = digest([self._unknown.key, *(own.tolist() for own in weights)])
        return self._on(replace(self._unknown, key=key, chosen=replace(self._unknown.chosen, weights=mine)))


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
    text = model_yaml(placed)
    problem = SpreadProblem(shares, Unknown(digest([text, list(chosen), repr(slots)]), text, chosen, slots))
    solution, known = identified(problem, method, starts, wishes)
    fitted = problem.model_at(problem.vector(solution.point.searched, solution.point.solved))
    parameters = parameters_of(problem, solution, known)
    before, after = (_errors(shares, own) for own in (model, fitted))
    filters = [own.filters for own in shares.summaries]
    lost = sum(own.lost for own in shares.summaries)
    bags = list(dict.fromkeys(problem.recordings))
    errors = {p.name: p.standard_error for p in parameters}
    record = record_of(bags, filters[0], region_of(shares.channel), after.rmse_n, errors)
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
