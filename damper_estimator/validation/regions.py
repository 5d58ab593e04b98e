"""Where a model fails: regions of operation that carry more of the squared error than of the time, in words."""

from dataclasses import dataclass

import numpy as np

from damper_estimator.validation.bands import Bands, all_bands
from damper_estimator.validation.trace import Pool

LEAST_CONCENTRATION = 1.25  # share of the squared error over share of the samples
LEAST_SHARE = 0.05  # of the squared error
_CERTAINTY = 3.0  # standard deviations of a mean square of so many independent samples


@dataclass(frozen=True)
class Region:
    """A region of operation in which the error is concentrated.

    Attributes:
        where: in words.
        what: the error in words, such as ``model 120 N too soft``.
        axis, direction, low, high: the same for programs, SI.
        rmse_n, bias_n: N, in the region.
        share_of_squared_error, share_of_samples: 0 to 1.
        recording, time: index of the recording and s since its first sample of the largest error in the region.
    """

    where: str
    what: str
    axis: str
    direction: str
    low: float
    high: float
    rmse_n: float
    bias_n: float
    share_of_squared_error: float
    share_of_samples: float
    recording: int
    time: float

    @property
    def excess(self) -> float:
        """Share of the squared error beyond the region's share of the samples: what makes it worse than another."""
        return self.share_of_squared_error - self.share_of_samples

    @property
    def sentence(self) -> str:
        """All of it in words."""
        error, samples = 100.0 * self.share_of_squared_error, 100.0 * self.share_of_samples
        return f"{self.where}: {error:.0f} % of the squared error in {samples:.0f} % of the time, {self.what}"

    def record(self) -> dict[str, object]:
        """For JSON."""
        names = ("where", "rmse_n", "bias_n", "share_of_squared_error", "share_of_samples", "what", "axis", "direction")
        ends = {name: value if np.isfinite(value) else None for name, value in (("low", self.low), ("high", self.high))}
        return {name: getattr(self, name) for name in names} | ends | {"recording": self.recording, "time_s": self.time}


def find_regions(pool: Pool) -> tuple[Region, ...]:
    """Regions whose error is concentrated beyond chance, worst (largest excess) first.

    Neighbouring bands that are both concentrated are one region. A band counts where its mean square exceeds the
    whole's by more than what independent samples of its number would scatter (2 band independent samples a second),
    so noise alone gives none. A passage after reversals must stand out within its own direction, too.
    """
    square = pool.residual**2
    total = float(square.sum())
    if total <= 0.0:
        return ()
    found = [region for cut in all_bands(pool) for region in _regions(cut, pool, square / total)]
    return tuple(sorted(found, key=lambda region: -region.excess))


def _regions(cut: Bands, pool: Pool, share: np.ndarray) -> list[Region]:
    known = cut.inside & np.isfinite(cut.value)
    band = np.where(known, np.searchsorted(cut.edges, np.where(known, cut.value, 0.0), side="right") - 1, -1)
    count = cut.edges.size - 1
    errors = np.bincount(band[known], share[known], count)
    samples = np.bincount(band[known], minlength=count) / share.size
    seconds = np.bincount(band[known], pool.dt[known], count)
    independent = np.maximum(2.0 * pool.band * seconds if pool.band > 0.0 else samples * share.size, 1.0)
    least = LEAST_CONCENTRATION * (1.0 + _CERTAINTY * np.sqrt(2.0 / independent))
    level = float(share[cut.inside].sum() / cut.inside.mean()) if cut.within else 1.0
    worse = errors > least * samples * max(level, 1.0)
    regions = []
    for first, last in _runs(worse):
        if errors[first:last].sum() >= LEAST_SHARE:
            inside = (band >= first) & (band < last)
            regions.append(_region(cut, float(cut.edges[first]), float(cut.edges[last]), inside, pool, share))
    return regions


def _runs(flags: np.ndarray) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(flags.astype(np.int8), prepend=0, append=0))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def _region(cut: Bands, low: float, high: float, inside: np.ndarray, pool: Pool, share: np.ndarray) -> Region:
    residual = pool.residual[inside]
    rmse, bias = float(np.sqrt(np.mean(residual**2))), float(residual.mean())
    worst = int(np.flatnonzero(inside)[np.argmax(np.abs(residual))])
    return Region(
        where=cut.words(low, high),
        what=_error_in_words(residual, pool.velocity[inside], rmse),
        axis=cut.axis,
        direction=cut.direction,
        low=low,
        high=high,
        rmse_n=rmse,
        bias_n=bias,
        share_of_squared_error=float(share[inside].sum()),
        share_of_samples=float(inside.mean()),
        recording=int(pool.recording[worst]),
        time=float(pool.elapsed[worst]),
    )


def _error_in_words(residual: np.ndarray, velocity: np.ndarray, rmse: float) -> str:
    """Too soft or stiff where the error follows the motion, too high or low where it has one sign, else scatter."""
    bias, along = float(residual.mean()), float(np.mean(residual * np.sign(velocity)))
    if max(abs(bias), abs(along)) < 0.4 * rmse:
        return f"error of {rmse:.3g} N without a steady sign"
    if abs(along) >= 0.999 * abs(bias):
        return f"model {abs(along):.3g} N too {'stiff' if along > 0.0 else 'soft'}"
    return f"model {abs(bias):.3g} N too {'high' if bias > 0.0 else 'low'}"
