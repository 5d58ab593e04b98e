"""Sigmoid over velocity, shifted by the sign of acceleration.

    F = f s(r v + h sgn(a)),      s(u) = u / (1 + |u|)

f in N, r in s/m, h without unit. No state. Source: Lozoya-Santos et al., eq. (9), f_h,a.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.signals.layout import A, V


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += f s(r v + h sgn(a)),      s(u) = u / (1 + |u|)."""
    for i in range(force.size):
        a = kinematics[A, i]
        shift = parameters[2] if a > 0.0 else -parameters[2] if a < 0.0 else 0.0
        u = parameters[1] * kinematics[V, i] + shift
        force[i] += parameters[0] * u / (1.0 + abs(u))


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="hysteresis",
    parameters=(
        Parameter("force", "N", 100.0, -20000.0, 20000.0, "height f", linear=True),
        Parameter("damping", "s/m", 30.0, -1e6, 1e6, "steepness r over velocity"),
        Parameter("hysteresis", "1", -0.3, -1e3, 1e3, "shift h by the sign of acceleration"),
    ),
    shows="the F-v loop is open near zero velocity",
    separate="the same peak velocity at two frequencies and amplitudes",
    trial=None,
)
