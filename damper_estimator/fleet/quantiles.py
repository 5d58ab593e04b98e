"""Exact percentiles of values that lie elsewhere: only counts travel.

The r-th smallest value is the smallest number that at least r + 1 values do not exceed. Its bits are found by asking,
round after round, how many values lie below 1023 numbers between what is too small and what is large enough.
"""

import struct
from collections.abc import Callable, Sequence

import numpy as np

from damper_estimator.fleet.held import channel_below, channel_range

_PROBES = 1023
_SIGN = 1 << 63


class SpreadSamples:
    """As ``identification.samples.Samples``, of recordings that lie elsewhere; final."""

    def __init__(self, ask: Callable[..., list], row: int) -> None:
        """``ask`` as ``Shares.ask``; ``row`` of the sample block."""
        self._ask, self._row = ask, row
        counts, lows, highs = zip(*ask(channel_range, row), strict=True)
        self.size = int(sum(counts))
        self.low, self.high = (min(lows), max(highs)) if self.size else (np.nan, np.nan)

    def below(self, edges: Sequence[float]) -> np.ndarray:
        """As ``Samples.below``."""
        return np.sum(self._ask(channel_below, self._row, np.asarray(edges, float)), axis=0)

    def percentiles(self, shares: Sequence[float]) -> list[float]:
        """As ``Samples.percentiles``."""
        places = [(self.size - 1) * (share / 100.0) for share in shares]
        ranks = sorted({min(int(p) + k, self.size - 1) for p in places for k in (0, 1)})
        found = dict(zip(ranks, self._smallest(ranks), strict=True))
        pairs = [(found[int(p)], found[min(int(p) + 1, self.size - 1)], p - int(p)) for p in places]
        # As NumPy does, from whichever neighbour is nearer.
        return [b - (b - a) * (1.0 - t) if t >= 0.5 else a + (b - a) * t for a, b, t in pairs]

    def _smallest(self, ranks: Sequence[int]) -> list[float]:
        """The values of these ranks, 0 for the smallest."""
        low = [_ordinal(self.low)] * len(ranks)
        high = [_ordinal(self.high)] * len(ranks)
        while any(a < b for a, b in zip(low, high, strict=True)):
            probes = [
                sorted({a + (b - a) * k // (_PROBES + 1) for k in range(_PROBES + 1)}) if a < b else []
                for a, b in zip(low, high, strict=True)
            ]
            edges = sorted({probe for own in probes for probe in own})
            counts = dict(zip(edges, self.below([_number(edge + 1) for edge in edges]).tolist(), strict=True))
            for i, (rank, own) in enumerate(zip(ranks, probes, strict=True)):
                enough = [probe for probe in own if counts[probe] > rank]
                short = [probe for probe in own if counts[probe] <= rank]
                high[i] = min(enough, default=high[i])
                low[i] = max(short, default=low[i] - 1) + 1
        return [_number(own) for own in high]


def _ordinal(value: float) -> int:
    """Integers in the order of the floating-point numbers."""
    bits = struct.unpack("<Q", struct.pack("<d", value))[0]
    return bits if bits < _SIGN else _SIGN - bits


def _number(ordinal: int) -> float:
    bits = ordinal if ordinal >= 0 else _SIGN - ordinal
    return struct.unpack("<d", struct.pack("<Q", bits))[0]
