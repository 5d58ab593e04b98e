"""Columns of form-free regressions: hat functions of a variable, and its memory of a way or a time."""

from collections.abc import Sequence
from math import exp

import numpy as np

from damper_estimator.compiled import compiled

FINE_SHARES = (0.02, 0.05, 0.1, 0.18, 0.3, 0.5, 1.0)
"""Of the highest speed: knots of a curve over velocity."""

COARSE_SHARES = (0.1, 0.4, 1.0)
"""The same where the curve is multiplied by another variable."""


def speed_knots(highest: float, shares: Sequence[float]) -> np.ndarray:
    """Knots over velocity, rising: 0 and shares of the highest speed (m/s) in both directions."""
    above = highest * np.array(shares)
    return np.concatenate([-above[::-1], [0.0], above])


def hats(values: np.ndarray, knots: np.ndarray) -> list[np.ndarray]:
    """Piecewise linear functions, each one at its knot and zero at the others; constant beyond the ends."""
    return [np.interp(values, knots, row) for row in np.eye(knots.size)]


@compiled
def _play_kernel(x, dt, width, out):
    z = 0.0
    for i in range(x.size):
        if dt[i] <= 0.0 or i == 0:
            z = 0.0
        else:
            z = min(max(z + x[i] - x[i - 1], -width), width)
        out[i] = z / width


def play(x: np.ndarray, dt: np.ndarray, width: float) -> np.ndarray:
    """(n,) share -1 to 1 of the force that an elastic, perfectly plastic element of half width (as ``x``) has reached.

    Source: Jenkin's element of the Prandtl-Ishlinskii model.
    """
    out = np.empty(x.size)
    _play_kernel(np.ascontiguousarray(x), np.ascontiguousarray(dt), width, out)
    return out


@compiled
def _lagging_kernel(values, dt, constant, out):
    for i in range(values.size):
        if dt[i] <= 0.0 or i == 0:
            out[i] = values[i]
        else:
            out[i] = values[i] + (out[i - 1] - values[i]) * exp(-dt[i] / constant)


def lagging(values: np.ndarray, dt: np.ndarray, constant: float) -> np.ndarray:
    """(n,) a variable behind a first-order lag of ``constant`` in s, exact for values held between samples."""
    out = np.empty(values.size)
    _lagging_kernel(np.ascontiguousarray(values), np.ascontiguousarray(dt), constant, out)
    return out
