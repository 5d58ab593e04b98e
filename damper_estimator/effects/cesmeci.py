"""Hysteresis of Cesmeci and Engin: an arctan step over velocity, shifted by the sign of acceleration.

    F = f_c arctan(r v + h sgn(a))

f_c in N, r in s/m, h without unit. The published form is dimensionless; f_c makes it a force. No state.
Source: Lozoya-Santos et al., eq. (3); Cesmeci and Engin 2010.
"""

from math import atan

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.signals.layout import A, V


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += f_c arctan(r v + h sgn(a))."""
    for i in range(force.size):
        a = kinematics[A, i]
        shift = parameters[2] if a > 0.0 else -parameters[2] if a < 0.0 else 0.0
        force[i] += parameters[0] * atan(parameters[1] * kinematics[V, i] + shift)


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="hysteresis",
    parameters=(
        Parameter("force", "N", 200.0, -10000.0, 10000.0, "height of the step", linear=True),
        Parameter("damping", "s/m", 30.0, 0.1, 5000.0, "steepness r over velocity"),
        Parameter("hysteresis", "1", -0.3, -20.0, 20.0, "shift h by the sign of acceleration"),
    ),
    shows="the F-v loop is open near zero velocity",
    separate="the same peak velocity at two frequencies and amplitudes",
    trial=None,
)
