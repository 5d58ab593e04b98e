"""Smooth force-velocity curve through given points without overshoot (PCHIP).

    F = cubic Hermite between the knots, slopes: weighted harmonic means of the adjacent secants

Settings: knots in m/s, strictly increasing. Parameters: one force in N per knot; straight beyond the outermost knots.
No state. Source: Fritsch and Carlson 1980, as in ``scipy.interpolate.PchipInterpolator``.
"""

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting, Values
from damper_estimator.effects.viscous_curve import KNOTS
from damper_estimator.signals.layout import V


def slopes(v: np.ndarray, f: np.ndarray) -> np.ndarray:
    """Slopes (n,) at the knots; of the secant at the ends, zero at an extremum."""
    h, secant = np.diff(v), np.diff(f) / np.diff(v)
    inner = np.zeros(max(v.size - 2, 0))
    same = secant[:-1] * secant[1:] > 0.0
    w1, w2 = 2.0 * h[1:] + h[:-1], h[1:] + 2.0 * h[:-1]
    inner[same] = (w1 + w2)[same] / (w1[same] / secant[:-1][same] + w2[same] / secant[1:][same])
    return np.concatenate([secant[:1], inner, secant[-1:]])


def prepare(parameters: Values, settings: Values) -> np.ndarray:
    """Knots, then slopes."""
    knots = np.asarray(settings["velocity"], float)
    return np.concatenate([knots, slopes(knots, np.asarray(parameters["force"], float))])


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += curve(v)."""
    count = parameters.size
    for i in range(force.size):
        v = kinematics[V, i]
        if v <= settings[0]:
            force[i] += parameters[0] + settings[count] * (v - settings[0])
        elif v >= settings[count - 1]:
            force[i] += parameters[count - 1] + settings[2 * count - 1] * (v - settings[count - 1])
        else:
            k = min(np.searchsorted(settings[:count], v, side="right") - 1, count - 2)  # NaN counts as above all knots
            h = settings[k + 1] - settings[k]
            s = (v - settings[k]) / h
            r = 1.0 - s
            force[i] += (
                r * r * (1.0 + 2.0 * s) * parameters[k]
                + s * s * (3.0 - 2.0 * s) * parameters[k + 1]
                + h * s * r * (r * settings[count + k] - s * settings[count + k + 1])
            )


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    parameters=(Parameter("force", "N", 0.0, -50000.0, 50000.0, "force at the knot", size="velocity"),),
    settings=(Setting("velocity", "m/s", KNOTS, "knots of the curve, at least two", increasing=True),),
    prepare=prepare,
    shows="one smooth line in F-v at any frequency and amplitude",
)
