"""The values of a channel over all judged samples, as far as knots and regions need them: ranges and counts."""

from collections.abc import Callable, Sequence

import numpy as np

from damper_estimator.signals import Measurement


class Samples:
    """Finite values in order; final. What holds the data elsewhere answers the same questions.

    Attributes:
        size: how many.
        low, high: the smallest and the largest; NaN where there is none.
    """

    def __init__(self, values: np.ndarray):
        """``values`` (n,), those that are not finite are left out."""
        self._ordered = np.sort(values[np.isfinite(values)])
        self.size = self._ordered.size
        self.low, self.high = self._ordered[[0, -1]].tolist() if self.size else (np.nan, np.nan)

    def percentiles(self, shares: Sequence[float]) -> list[float]:
        """Values at so many percent, linear between neighbours."""
        return np.percentile(self._ordered, shares).tolist()

    def below(self, edges: Sequence[float]) -> np.ndarray:
        """(k,) int, how many values are smaller than each edge."""
        return np.searchsorted(self._ordered, edges)


Channels = Callable[[int], Samples]
"""Values by row of the sample block."""


def channels_of(measurements: Sequence[Measurement]) -> Channels:
    """The judged samples of measurements together."""
    return lambda row: Samples(np.concatenate([m.kinematics.block[row, m.judged] for m in measurements]))
