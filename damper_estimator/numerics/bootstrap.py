"""Bootstrap of blocks: what else could have been measured, where neighbouring samples are no independent witnesses."""

import numpy as np

REPLICATES = 500


def block_draws(count: int, replicates: int = REPLICATES, seed: int = 0) -> np.ndarray:
    """(replicates, count) int, how often each of ``count`` blocks is drawn with replacement.

    A statistic of sums over blocks (count,) has the replicates ``draws @ sums``; the same draws for everything that is
    compared pair it. Blocks must be longer than the memory of what is summed. Source: Kuensch 1989.
    """
    picks = np.random.default_rng(seed).integers(0, count, (replicates, count))
    return np.stack([np.bincount(row, minlength=count) for row in picks])
