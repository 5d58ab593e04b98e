"""How a table goes on where nothing is known of it: between known points straight, outside as the nearest tell.

Along the velocity a damper's force goes on with the slope of the last known interval, and level where the force falls
there: a force that resists the motion then keeps resisting it, however far the table goes on, and never falls. Along
every other axis it stays what it was at the nearest known point. Both were compared with other rules on simulated
dampers, see ``benchmarks/bench_extrapolation.py``.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Axis:
    """One axis of a table.

    Attributes:
        knots: (k,) rising.
        straight: whether the table goes on straight along it; else level.
    """

    knots: np.ndarray
    straight: bool


def continuation(axes: Sequence[Axis], known: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Weights with which the known points of a table give all of them.

    The axes that go on level come first, so the corner of a surface takes the value of the nearest known point at its
    velocity before any slope is continued. Where nothing is known at all, every point keeps its value.

    Args:
        axes: in the order of the table's dimensions.
        known: (k_1, ..) bool, of the table's shape.
        values: of the same shape; what is not known plays no part.

    Returns:
        (n, n) for the flat table: all points = weights @ values. Rows of known points are those of the unit matrix.
    """
    weights = np.eye(known.size)
    if not known.any():
        return weights
    known = known.copy()
    places = np.arange(known.size).reshape(known.shape)
    for k in sorted(range(len(axes)), key=lambda k: axes[k].straight):
        lines = np.moveaxis(places, k, -1).reshape(-1, axes[k].knots.size)
        for line in lines[known.ravel()[lines].any(axis=1)]:
            own = _along(axes[k], known.ravel()[line], weights[line] @ values.ravel())
            weights[line] = own @ weights[line]
            known.ravel()[line] = True
    return weights


def _along(axis: Axis, known: np.ndarray, values: np.ndarray) -> np.ndarray:
    """(k, k) the same for one line of a table with at least one known point."""
    weights, told = np.eye(known.size), np.flatnonzero(known)
    for i in np.flatnonzero(~known):
        weights[i] = 0.0
        after = int(np.searchsorted(told, i))
        if 0 < after < told.size:
            a, b = told[after - 1], told[after]
        else:
            nearest = told[[0, -1][after > 0]]
            weights[i, nearest] = 1.0
            inner = told[[1, -2][after > 0]] if told.size > 1 else nearest
            # The slope has the same sign from either end.
            if not axis.straight or (values[nearest] - values[inner]) * (nearest - inner) <= 0.0:
                continue
            a, b = sorted((nearest, inner))
        share = (axis.knots[i] - axis.knots[a]) / (axis.knots[b] - axis.knots[a])
        weights[i, [a, b]] = 1.0 - share, share
    return weights
