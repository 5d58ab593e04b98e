"""Completes a table at unknown points: linearly between known points, outside them from the nearest known ones.

Along the velocity a damper's force continues with the slope of the last known interval, or constant if the force falls
there: a force that resists the motion then keeps resisting it at any velocity. Along every other axis it keeps its
value at the nearest known point. Benchmark of both rules against others on simulated dampers:
``benchmarks/bench_extrapolation.py``.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Axis:
    """One axis of a table.

    Attributes:
        knots: (k,) rising.
        straight: whether the table continues linearly along it; else constant.
    """

    knots: np.ndarray
    straight: bool


def continuation(axes: Sequence[Axis], known: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Weights that compute all points of a table from the known ones.

    Constant axes come first, so the corner of a surface has the value of the nearest known point at its velocity before
    any slope continues. Without known points every point keeps its value.

    Args:
        axes: in the order of the table's dimensions.
        known: (k_1, ..) bool, of the table's shape.
        values: of the same shape; unknown values have no effect.

    Returns:
        (n, n) for the flat table: all points = weights @ values. Rows of known points are rows of the unit matrix.
    """
    weights = np.eye(known.size)
    if not known.any():
        return weights
    known = known.copy()
    places = np.arange(known.size).reshape(known.shape)
    for k in sorted(range(len(axes)), key=lambda k: axes[k].straight):
        lines = np.moveaxis(places, k, -1).reshape(-1, axes[k].knots.size)
        for line in lines[known.ravel()[lines].any(axis=1)]:
            line_weights = _along(axes[k], known.ravel()[line], weights[line] @ values.ravel())
            weights[line] = line_weights @ weights[line]
            known.ravel()[line] = True
    return weights


def _along(axis: Axis, known: np.ndarray, values: np.ndarray) -> np.ndarray:
    """(k, k) the same for one line of a table with at least one known point."""
    weights, known_places = np.eye(known.size), np.flatnonzero(known)
    for i in np.flatnonzero(~known):
        weights[i] = 0.0
        after = int(np.searchsorted(known_places, i))
        if 0 < after < known_places.size:
            a, b = known_places[after - 1], known_places[after]
        else:
            nearest = known_places[[0, -1][after > 0]]
            weights[i, nearest] = 1.0
            inner = known_places[[1, -2][after > 0]] if known_places.size > 1 else nearest
            # The slope has the same sign from either end.
            if not axis.straight or (values[nearest] - values[inner]) * (nearest - inner) <= 0.0:
                continue
            a, b = sorted((nearest, inner))
        share = (axis.knots[i] - axis.knots[a]) / (axis.knots[b] - axis.knots[a])
        weights[i, [a, b]] = 1.0 - share, share
    return weights
