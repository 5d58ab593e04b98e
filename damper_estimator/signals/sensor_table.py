"""The table of a sensor whose characteristic is no straight line."""

import numpy as np

_SLACK = 0.02  # of the range: noise at its ends


def looked_up(raw: np.ndarray, table: tuple[tuple[float, ...], tuple[float, ...]]) -> np.ndarray:
    """Values of raw ones, any shape, between the points (raw, value) of a table whose raw values rise; NaN beyond its
    ends, where a raw value has no meaning, as that of a broken wire.
    """
    low, high = table[0][0], table[0][-1]
    slack = _SLACK * (high - low)
    return np.where((raw >= low - slack) & (raw <= high + slack), np.interp(raw, *table), np.nan)
