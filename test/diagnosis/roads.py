"""Road-like motions of dampers that are made in memory."""

import numpy as np


def road(
    random: np.random.Generator, time: np.ndarray, highest: float, size: float = 3e-3, slope: float = 1.7
) -> np.ndarray:
    """(n,) m at times (n,) s: harmonics of random phase from 0.3 to below ``highest`` Hz, of ``size`` m where they are
    slow, falling with the power ``slope`` of the frequency beyond 1.5 Hz.
    """
    seconds = time.size * time[1]
    frequencies = np.arange(0.3, highest, 1.0 / seconds)
    sizes = size / (1.0 + (frequencies / 1.5) ** slope)
    phases = random.uniform(0.0, 2.0 * np.pi, frequencies.size)
    return (sizes * np.cos(2.0 * np.pi * frequencies * time[:, None] + phases)).sum(axis=1)
