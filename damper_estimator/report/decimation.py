"""Thinning long signals so that no peak is lost."""

from collections.abc import Sequence

import numpy as np


def min_max_rows(signals: Sequence[np.ndarray], most: int) -> np.ndarray:
    """Indices of at most ``most`` samples that hold the smallest and largest value of each signal in each of even
    buckets.

    Args:
        signals: arrays (n,) over the same samples; NaN counts as no value.
        most: at least 2 per signal, and more than 2 besides.

    Returns:
        Rising indices; all of them where n <= most. The first and last sample are always there.
    """
    size = signals[0].size
    if size <= most:
        return np.arange(size)
    buckets = max((most - 2) // (2 * len(signals)), 1)
    width = -(-size // buckets)
    rows = [np.array([0, size - 1])]
    for values in signals:
        padded = np.full(width * -(-size // width), np.nan)
        padded[:size] = values
        table = padded.reshape(-1, width)
        first = np.arange(table.shape[0]) * width
        rows.append(first + np.argmin(np.where(np.isnan(table), np.inf, table), axis=1))
        rows.append(first + np.argmax(np.where(np.isnan(table), -np.inf, table), axis=1))
    return np.unique(np.minimum(np.concatenate(rows), size - 1))
