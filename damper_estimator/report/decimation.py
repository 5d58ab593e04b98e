"""Decimation of long signals that loses no peak."""

from collections.abc import Sequence

import numpy as np

_COARSEST = 2000  # samples of the coarsest level of detail


def min_max_rows(signals: Sequence[np.ndarray], most: int) -> np.ndarray:
    """Indices of at most ``most`` samples that hold the smallest and largest value of each signal in each of even
    buckets.

    Args:
        signals: arrays (n,) over the same samples; NaN counts as no value.
        most: at least 2 per signal, plus 2.

    Returns:
        Rising indices with the first and last sample; all of them where n <= most.
    """
    size = signals[0].size
    if size <= most:
        return np.arange(size)
    buckets = max((most - 2) // (2 * len(signals)), 1)
    width = -(-size // buckets)
    rows = [np.array([0, size - 1])]
    for values in signals:
        rows += _extremes(values, width)
    return np.unique(np.concatenate(rows))


def detail_levels(signals: Sequence[np.ndarray], coarsest: int = _COARSEST) -> np.ndarray:
    """(n,) uint8: the coarsest level of detail at which a sample is drawn.

    Level k has at least the ``min_max_rows`` of ``coarsest`` * 2**k samples, and all samples of the levels below k.
    """
    size = signals[0].size
    finest = max(int(np.ceil(np.log2(max(size, 1) / coarsest))), 0)
    levels = np.full(size, finest, np.uint8)
    for level in range(finest - 1, -1, -1):
        levels[min_max_rows(signals, coarsest * 2**level)] = level
    return levels


def _extremes(values: np.ndarray, width: int) -> list[np.ndarray]:
    """Indices of the smallest and the largest value in each bucket of ``width`` samples; the last may be shorter."""
    unknown = np.isnan(values)
    low = high = values
    if unknown.any():
        low, high = np.where(unknown, np.inf, values), np.where(unknown, -np.inf, values)
    whole = values.size // width * width
    first = np.arange(0, whole, width)
    lowest, highest = low[:whole].reshape(-1, width).argmin(axis=1), high[:whole].reshape(-1, width).argmax(axis=1)
    rows = [first + lowest, first + highest]
    if whole < values.size:
        rows.append(whole + np.array([low[whole:].argmin(), high[whole:].argmax()]))
    return rows
