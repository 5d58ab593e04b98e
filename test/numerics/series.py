"""Series with known memory."""

import numpy as np
from scipy.signal import lfilter


def autoregressive(random: np.random.Generator, count: int, memory: float, shape: tuple[int, ...] = ()) -> np.ndarray:
    """(*shape, count) e(i) = memory e(i - 1) + white noise of unit variance, from its stationary state."""
    lead = 200
    white = random.standard_normal((*shape, count + lead))
    return lfilter([1.0], [1.0, -memory], white, axis=-1)[..., lead:]
