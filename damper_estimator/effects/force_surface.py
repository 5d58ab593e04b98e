"""Nonparametric surface of force over velocity and acceleration.

    F = bilinear between the points of a grid (v_k, a_l), constant beyond its edge

Settings: v in m/s and a in m/s^2, strictly increasing. Parameters: one force in N per point, row by row (first all
accelerations of the first velocity). No state. Source: HIS paper, section 5.3; Duym 1997.
"""

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting, Values, numbers
from damper_estimator.signals.layout import A, V


@compiled
def cell(knots, value):
    """Index of the knot below and the fractional position towards the next one."""
    last = knots.size - 2
    k = 0
    while k < last and value >= knots[k + 1]:
        k += 1
    share = (value - knots[k]) / (knots[k + 1] - knots[k])
    return k, min(max(share, 0.0), 1.0)


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += surface(v, a)."""
    count = int(settings[0])
    velocity, acceleration = settings[1 : 1 + count], settings[1 + count :]
    width = acceleration.size
    for i in range(force.size):
        k, s = cell(velocity, kinematics[V, i])
        m, r = cell(acceleration, kinematics[A, i])
        j = k * width + m
        force[i] += (1.0 - s) * ((1.0 - r) * parameters[j] + r * parameters[j + 1]) + s * (
            (1.0 - r) * parameters[j + width] + r * parameters[j + width + 1]
        )


def prepare(parameters: Values, settings: Values) -> np.ndarray:
    """Number of velocities, velocities, accelerations."""
    velocity, acceleration = numbers(settings, "velocity"), numbers(settings, "acceleration")
    return np.concatenate([[len(velocity)], velocity, acceleration])


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    parameters=(
        Parameter(
            "force", "N", 0.0, -50000.0, 50000.0, "force at the point", linear=True, size=("velocity", "acceleration")
        ),
    ),
    settings=(
        Setting("velocity", "m/s", (-0.5, -0.2, -0.05, 0.0, 0.05, 0.2, 0.5), "grid over velocity", increasing=True),
        Setting("acceleration", "m/s^2", (-20.0, -5.0, 0.0, 5.0, 20.0), "grid over acceleration", increasing=True),
    ),
    prepare=prepare,
    shows="any loop in F-v that depends on velocity and acceleration alone",
)
