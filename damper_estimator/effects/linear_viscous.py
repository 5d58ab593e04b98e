"""Linear viscous damping, with separate rates in rebound and compression.

    F = c_r v  for v > 0,      F = c_c v  for v <= 0

F in N, v in m/s, c in N s/m. No state. Source: any textbook on vibration; the baseline of all comparisons.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.signals.layout import V


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += c v."""
    for i in range(force.size):
        v = kinematics[V, i]
        force[i] += (parameters[0] if v > 0.0 else parameters[1]) * v


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    parameters=(
        Parameter("rebound", "N s/m", 2000.0, 0.0, 2e5, "damping rate in rebound", linear=True),
        Parameter("compression", "N s/m", 1000.0, 0.0, 2e5, "damping rate in compression", linear=True),
    ),
    shows="a straight line through the origin in F-v",
)
