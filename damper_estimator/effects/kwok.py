"""Hysteresis of Kwok: a tanh step over velocity, shifted by the side of the stroke.

    F = f_c tanh(r v + h sgn(x - x_0))

f_c in N, r in s/m, h without unit, x_0 in m. The published form is dimensionless; f_c makes it a force. No
state. Source: Lozoya-Santos et al., eq. (1); Kwok et al. 2006.
"""

from math import tanh

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.signals.layout import V, X


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += f_c tanh(r v + h sgn(x - x_0))."""
    for i in range(force.size):
        side = kinematics[X, i] - parameters[3]
        shift = parameters[2] if side > 0.0 else -parameters[2] if side < 0.0 else 0.0
        force[i] += parameters[0] * tanh(parameters[1] * kinematics[V, i] + shift)


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="hysteresis",
    parameters=(
        Parameter("force", "N", 300.0, -10000.0, 10000.0, "height of the step", linear=True),
        Parameter("damping", "s/m", 30.0, 0.1, 5000.0, "steepness r over velocity"),
        Parameter("hysteresis", "1", 0.3, -20.0, 20.0, "shift h by the side of the stroke"),
        Parameter("middle", "m", 0.0, -0.5, 0.5, "middle of the stroke x_0"),
    ),
    shows="the F-v loop is open near zero velocity",
    separate="the same peak velocity at two frequencies and amplitudes",
    trial=None,
)
