"""Correlation of ranks."""

import numpy as np


def rank_correlation(a: np.ndarray, b: np.ndarray) -> float:
    """Spearman's correlation of two series (n,), equal values sharing their mean rank; NaN where one is constant."""
    # Imported when needed: it takes a second, and most of what uses this package never comes here.
    from scipy.stats import spearmanr

    if a.size < 2 or np.ptp(a) == 0.0 or np.ptp(b) == 0.0:
        return float("nan")
    return float(spearmanr(a, b).statistic)
