"""Exact order statistics of values that are spread over several places, found by counting the values below a number.

The r-th smallest value is the smallest number that at least r + 1 values do not exceed. Its bits are found by counting,
round after round, the values below 1023 numbers between one that is too small and one that is large enough.
"""

import struct
from collections.abc import Callable, Sequence

import numpy as np

_PROBES = 1023
_SIGN = 1 << 63


def order_statistics(
    below: Callable[[np.ndarray], np.ndarray], low: float, high: float, ranks: Sequence[int]
) -> list[float]:
    """The values of these ranks, 0 for the smallest.

    Args:
        below: edges (k,) to the number of values below each (k,).
        low, high: the smallest and the largest value.
    """
    lowest, highest = [_ordinal(low)] * len(ranks), [_ordinal(high)] * len(ranks)
    while any(a < b for a, b in zip(lowest, highest, strict=True)):
        probes = [
            sorted({a + (b - a) * k // (_PROBES + 1) for k in range(_PROBES + 1)}) if a < b else []
            for a, b in zip(lowest, highest, strict=True)
        ]
        edges = sorted({probe for candidates in probes for probe in candidates})
        counts = dict(zip(edges, below(np.array([_number(edge + 1) for edge in edges])).tolist(), strict=True))
        for i, (rank, candidates) in enumerate(zip(ranks, probes, strict=True)):
            enough = [probe for probe in candidates if counts[probe] > rank]
            short = [probe for probe in candidates if counts[probe] <= rank]
            highest[i] = min(enough, default=highest[i])
            lowest[i] = max(short, default=lowest[i] - 1) + 1
    return [_number(ordinal) for ordinal in highest]


def _ordinal(value: float) -> int:
    """Integers in the order of the floating-point numbers."""
    bits = struct.unpack("<Q", struct.pack("<d", value))[0]
    return bits if bits < _SIGN else _SIGN - bits


def _number(ordinal: int) -> float:
    bits = ordinal if ordinal >= 0 else _SIGN - ordinal
    return struct.unpack("<d", struct.pack("<Q", bits))[0]
