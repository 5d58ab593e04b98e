"""Where a model fails: regions of operation that carry more of the squared error than of the time, in words."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.numbers import number
from damper_estimator.validation.bands import Bands, all_bands, directions
from damper_estimator.validation.trace import Pool

LEAST_CONCENTRATION = 1.25  # share of the squared error over share of the samples
LEAST_SHARE = 0.05  # of the squared error
MOST = 6  # regions reported
_CERTAINTY = 3.0  # standard deviations of a mean square of so many independent samples
_NEW = 0.5  # share of a region's error that no worse region contains
_KEPT, _NARROWER = 0.75, 0.6  # share of the error kept, and of the samples, where a region is narrowed down
_NARROWINGS = 2


@dataclass(frozen=True)
class Region:
    """A region of operation in which the error is concentrated; the gauge's zero and drift are left out of shares.

    Attributes:
        where: in words.
        what: the error in words, such as ``model 120 N too soft``.
        axis, direction, low, high: the cut that found it, for programs, in SI.
        narrowed: (axis, direction, low, high) of the cuts that narrow it down.
        rmse_n, bias_n: N, of the whole error in the region.
        drift_n: N rms of the gauge's zero and drift in it.
        scatter_n: N rms of the remainder about its mean.
        share_of_squared_error, share_of_samples: 0 to 1.
        recording, time: index of the recording and s since its first sample of the largest error in the region.
    """

    where: str
    what: str
    axis: str
    direction: str
    low: float
    high: float
    narrowed: tuple[tuple[str, str, float, float], ...]
    rmse_n: float
    bias_n: float
    drift_n: float
    scatter_n: float
    share_of_squared_error: float
    share_of_samples: float
    recording: int
    time: float

    @property
    def excess(self) -> float:
        """Share of the squared error beyond the region's share of the samples: the larger, the worse the region."""
        return self.share_of_squared_error - self.share_of_samples

    @property
    def sentence(self) -> str:
        """The whole region in words."""
        error, samples = 100.0 * self.share_of_squared_error, 100.0 * self.share_of_samples
        return f"{self.where}: {error:.0f} % of the squared error in {_percent(samples)} of the time, {self.what}"

    def record(self) -> dict[str, object]:
        """For JSON."""
        names = ("where", "rmse_n", "bias_n", "drift_n", "scatter_n", "share_of_squared_error", "share_of_samples")
        more = {
            "what": self.what, "recording": self.recording, "time_s": self.time,
            "narrowed": [_cut_record(*cut) for cut in self.narrowed],
        }  # fmt: skip
        cut = _cut_record(self.axis, self.direction, self.low, self.high)
        return {name: getattr(self, name) for name in names} | cut | more


def _percent(share: float) -> str:
    return f"{share:.0f} %" if share >= 1.0 else f"{share:.1g} %"


def _cut_record(axis: str, direction: str, low: float, high: float) -> dict[str, object]:
    ends = {name: value if np.isfinite(value) else None for name, value in (("low", low), ("high", high))}
    return {"axis": axis, "direction": direction} | ends


@dataclass(frozen=True)
class _Run:
    """Neighbouring bands of one cut, (first, last) of its edges, and the samples (n,) bool in them."""

    cut: Bands
    low: float
    high: float
    inside: np.ndarray

    @property
    def words(self) -> str:
        return self.cut.words(self.low, self.high)


def find_regions(pool: Pool) -> tuple[Region, ...]:
    """Regions whose error is concentrated beyond chance, worst (largest excess) first.

    Neighbouring bands that are both concentrated are one region. A band counts where its mean square exceeds the
    whole's by more than the scatter of as many independent samples (2 band independent samples a second), so noise
    alone has no regions. A passage after reversals must stand out within its direction, too. The worst region
    is narrowed down by other quantities where most of its error is in few of its samples; the next one is searched
    among the remaining samples: the same samples under another name are not reported again. An error that consists of
    zero and drift alone has no regions.
    """
    square = pool.structure**2
    total = float(square.sum())
    if total <= LEAST_SHARE * float(np.sum(pool.residual**2)):
        return ()
    share = square / total
    cuts = all_bands(pool)
    everywhere = np.ones(share.size, bool)
    found: list[Region] = []
    free = everywhere.copy()
    runs = [run for cut in cuts for run in _concentrated(cut, pool, share, everywhere)]
    while runs and len(found) < MOST:
        runs = [run for run in runs if _is_new(run, pool, share, free)]
        if not runs:
            break
        worst = max(runs, key=lambda run: _excess(run.inside & free, share, free))
        region, inside = _narrowed(worst, [*cuts, directions(pool)], pool, share)
        found.append(region)
        free &= ~inside
        runs = [run for run in runs if run is not worst]
    return tuple(sorted(found, key=lambda region: -region.excess))


def _concentrated(cut: Bands, pool: Pool, share: np.ndarray, among: np.ndarray) -> Iterator[_Run]:
    """Runs of bands that stand out ``among`` (n,) bool samples."""
    known = cut.inside & among & np.isfinite(cut.value)
    if not known.any():
        return
    band = np.where(known, np.searchsorted(cut.edges, np.where(known, cut.value, 0.0), side="right") - 1, -1)
    count = cut.edges.size - 1
    errors = np.bincount(band[known], share[known], count)
    samples = np.bincount(band[known], minlength=count)
    seconds = np.bincount(band[known], pool.dt[known], count)
    level = _level(share, among)
    if cut.within:
        level = max(level, _level(share, among & cut.inside))
    worse = errors > level * samples * _least(samples, seconds, pool.band)
    for first, last in _runs(worse):
        if errors[first:last].sum() >= LEAST_SHARE:
            inside = (band >= first) & (band < last)
            yield _Run(cut, float(cut.edges[first]), float(cut.edges[last]), inside)


def _level(share: np.ndarray, among: np.ndarray) -> float:
    """Mean share of a sample."""
    return float(share[among].mean()) if among.any() else 0.0


def _least(samples: np.ndarray, seconds: np.ndarray, band: float) -> np.ndarray:
    """Times the mean level that bands of so many samples and seconds must exceed."""
    independent = np.maximum(2.0 * band * seconds if band > 0.0 else samples, 1.0)
    return LEAST_CONCENTRATION * (1.0 + _CERTAINTY * np.sqrt(2.0 / independent))


def _is_new(run: _Run, pool: Pool, share: np.ndarray, free: np.ndarray) -> bool:
    """Whether enough of a run's error is still free, and stands out among the free samples."""
    inside = run.inside & free
    error = float(share[inside].sum())
    if error < max(LEAST_SHARE, _NEW * float(share[run.inside].sum())):
        return False
    least = float(_least(np.array(inside.sum()), np.array(pool.dt[inside].sum()), pool.band))
    return error > least * _level(share, free) * float(inside.sum())


def _excess(inside: np.ndarray, share: np.ndarray, free: np.ndarray) -> float:
    return float(share[inside].sum()) - _level(share, free) * float(inside.sum())


def _narrowed(run: _Run, cuts: Sequence[Bands], pool: Pool, share: np.ndarray) -> tuple[Region, np.ndarray]:
    """The region of a run, narrowed down to the bands with most of its error in few of its samples."""
    # An event that happens once has a time, but the time explains nothing.
    inside, used = run.inside, {run.cut.axis, "time"} | ({"direction"} if run.cut.direction else set())
    narrowings: list[_Run] = []
    for _ in range(_NARROWINGS):
        candidates = [
            candidate
            for cut in cuts
            if cut.axis not in used and not (cut.direction and "direction" in used)
            for candidate in _concentrated(cut, pool, share, inside)
            if share[candidate.inside].sum() >= _KEPT * share[inside].sum()
            and np.count_nonzero(candidate.inside) <= _NARROWER * np.count_nonzero(inside)
        ]
        if not candidates:
            break
        best = max(candidates, key=lambda candidate: _excess(candidate.inside, share, inside))
        inside = best.inside
        used |= {best.cut.axis} | ({"direction"} if best.cut.direction else set())
        narrowings.append(best)
    return _region(run, narrowings, inside, pool, share), inside


def _runs(flags: np.ndarray) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(flags.astype(np.int8), prepend=0, append=0))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def _region(run: _Run, more: Sequence[_Run], inside: np.ndarray, pool: Pool, share: np.ndarray) -> Region:
    residual, structure = pool.residual[inside], pool.structure[inside]
    worst = int(np.flatnonzero(inside)[np.argmax(np.abs(structure))])
    return Region(
        where=", ".join([run.words, *(narrowing.words for narrowing in more)]),
        what=_error_in_words(structure, pool.velocity[inside], pool.acceleration[inside]),
        axis=run.cut.axis,
        direction=run.cut.direction,
        low=run.low,
        high=run.high,
        narrowed=tuple(
            (narrowing.cut.axis, narrowing.cut.direction, narrowing.low, narrowing.high) for narrowing in more
        ),
        rmse_n=float(np.sqrt(np.mean(residual**2))),
        bias_n=float(residual.mean()),
        drift_n=float(np.sqrt(np.mean(pool.slow[inside] ** 2))),
        scatter_n=float(structure.std()),
        share_of_squared_error=float(share[inside].sum()),
        share_of_samples=float(inside.mean()),
        recording=int(pool.recording[worst]),
        time=float(pool.elapsed[worst]),
    )


def _error_in_words(error: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray) -> str:
    """Too soft or stiff where the error follows the motion, too high or low where it has one sign, with acceleration
    where it follows that, else scatter.
    """
    bias, along = float(error.mean()), float(np.mean(error * np.sign(velocity)))
    rmse = float(np.sqrt(np.mean(error**2)))
    if max(abs(bias), abs(along)) >= 0.4 * rmse:
        if abs(along) >= 0.999 * abs(bias):
            return f"model {number(abs(along))} N too {'stiff' if along > 0.0 else 'soft'}"
        return f"model {number(abs(bias))} N too {'high' if bias > 0.0 else 'low'}"
    with_acceleration = float(np.mean(error * np.sign(acceleration)))
    if abs(with_acceleration) >= 0.4 * rmse:
        first, then = ("high", "low") if with_acceleration > 0.0 else ("low", "high")
        return f"model {number(abs(with_acceleration))} N too {first} at positive acceleration, too {then} at negative"
    return f"error of {number(rmse)} N without a steady sign"
