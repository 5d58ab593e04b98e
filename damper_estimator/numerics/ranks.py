"""Correlation of ranks."""

import numpy as np


def rank_correlation(a: np.ndarray, b: np.ndarray) -> float:
    """Spearman's correlation of two series (n,), equal values sharing their mean rank; NaN where one is constant."""
    ranks = [_ranks(values) for values in (a, b)]
    deviations = [rank - rank.mean() for rank in ranks]
    scale = np.sqrt((deviations[0] @ deviations[0]) * (deviations[1] @ deviations[1]))
    return float(deviations[0] @ deviations[1] / scale) if scale > 0.0 else float("nan")


def _ranks(values: np.ndarray) -> np.ndarray:
    """(n,): 1 for the lowest; equal values share the mean of their places."""
    _, place, count = np.unique(values, return_inverse=True, return_counts=True)
    return (np.cumsum(count) - 0.5 * (count - 1))[place.reshape(-1)]
