"""Sigmoid over velocity and displacement.

    F = f s(r v + h x),      s(u) = u / (1 + |u|)

f in N, r in s/m, h in 1/m. No state. Source: Lozoya-Santos et al., eq. (9), f_s.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.signals.layout import V, X


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += f s(r v + h x),      s(u) = u / (1 + |u|)."""
    for i in range(force.size):
        u = parameters[1] * kinematics[V, i] + parameters[2] * kinematics[X, i]
        force[i] += parameters[0] * u / (1.0 + abs(u))


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="hysteresis",
    parameters=(
        Parameter("force", "N", 300.0, -20000.0, 20000.0, "height f", linear=True),
        Parameter("damping", "s/m", 30.0, -1e4, 1e4, "steepness r over velocity"),
        Parameter("stiffness", "1/m", 0.0, -1e4, 1e4, "shift h over displacement"),
    ),
    shows="the F-v loop is open near zero velocity",
    separate="the same peak velocity at two frequencies and amplitudes",
    trial=None,
)
