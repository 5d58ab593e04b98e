"""Bootstrap of blocks: other possible outcomes of a measurement whose neighbouring samples are not independent."""

import numpy as np

REPLICATES = 500


def block_draws(count: int, replicates: int = REPLICATES, seed: int = 0) -> np.ndarray:
    """(replicates, count) int, the number of times each of ``count`` blocks is drawn with replacement.

    A statistic of sums over blocks (count,) has the replicates ``draws @ sums``; using the same draws for all compared
    statistics pairs them. Blocks must be longer than the memory of the summed series. Source: Kuensch 1989.
    """
    picks = np.random.default_rng(seed).integers(0, count, (replicates, count))
    return np.stack([np.bincount(row, minlength=count) for row in picks])
