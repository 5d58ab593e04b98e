"""Places of parameters on sliders.

Declared bounds span decades while a parameter is looked for near where it stands. Its value at the last identification
is in the middle; from there the place runs to either bound by equal steps, or by equal ratios where the bound is far.
"""

import numpy as np

STEPS = 400
_FAR = 4.0  # times the value


def to_place(value: float, centre: float, low: float, high: float) -> float:
    """The place 0 to 1 of a value between its bounds."""
    return float(np.interp(value, _values(centre, low, high), np.linspace(0.0, 1.0, STEPS + 1)))


def from_place(place: float, centre: float, low: float, high: float) -> float:
    """The value at a place 0 to 1; the middle is the centre itself."""
    if place == 0.5 and low < centre < high:
        return centre
    return float(np.interp(place, np.linspace(0.0, 1.0, STEPS + 1), _values(centre, low, high)))


def _values(centre: float, low: float, high: float) -> np.ndarray:
    """(STEPS + 1,) rising values at even places."""
    if not low < centre < high:
        return np.linspace(low, high, STEPS + 1)
    half = STEPS // 2 + 1
    below, above = _side(centre, low, half), _side(centre, high, half)
    return np.concatenate([below[:0:-1], above])


def _side(centre: float, end: float, count: int) -> np.ndarray:
    """(count,) values from the centre to an end."""
    way = end - centre
    size = abs(centre) or abs(way)
    if abs(way) <= _FAR * size:
        return np.linspace(centre, end, count)
    # Steps that grow by equal ratios; the first is about half a percent of the centre's size.
    first = 0.2 * size
    growth = np.geomspace(first, first + abs(way), count) - first
    return centre + np.sign(way) * growth
