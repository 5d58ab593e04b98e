"""The values of a channel over all judged samples, reduced to the ranges and counts that knots and regions need."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.signals import Measurement


@dataclass(frozen=True)
class Samples:
    """Finite values in order, in this process or elsewhere.

    Attributes:
        size: how many.
        low, high: the smallest and the largest; NaN without values.
        below: edges (k,) to (k,) int, how many values are smaller than each.
        smallest: ranks to the values that have them, 0 for the smallest.
    """

    size: int
    low: float
    high: float
    below: Callable[[Sequence[float]], np.ndarray]
    smallest: Callable[[Sequence[int]], list[float]]

    def percentiles(self, shares: Sequence[float]) -> list[float]:
        """Values at so many percent, linear between neighbours."""
        places = [(self.size - 1) * (share / 100.0) for share in shares]
        ranks = sorted({min(int(p) + k, self.size - 1) for p in places for k in (0, 1)})
        found = dict(zip(ranks, self.smallest(ranks), strict=True))
        pairs = [(found[int(p)], found[min(int(p) + 1, self.size - 1)], p - int(p)) for p in places]
        # As NumPy does, from whichever neighbour is nearer.
        return [b - (b - a) * (1.0 - t) if t >= 0.5 else a + (b - a) * t for a, b, t in pairs]


Channels = Callable[[int], Samples]
"""Values by row of the sample block."""


def samples_of(values: np.ndarray) -> Samples:
    """The finite ones of values (n,)."""
    ordered = np.sort(values[np.isfinite(values)])
    low, high = ordered[[0, -1]].tolist() if ordered.size else (np.nan, np.nan)
    return Samples(
        ordered.size,
        low,
        high,
        lambda edges: np.searchsorted(ordered, edges),
        lambda ranks: ordered[list(ranks)].tolist(),
    )


def channels_of(measurements: Sequence[Measurement]) -> Channels:
    """The judged samples of all measurements."""
    return lambda row: samples_of(np.concatenate([m.kinematics.block[row, m.judged] for m in measurements]))
