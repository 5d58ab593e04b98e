"""The linear part of a general damper: offset, damping, stiffness and virtual mass.

    F = f_0 + c v + k x + m a

f_0 in N, c in N s/m, k in N/m, m in kg; of either sign, like the fitted values of the source. No state. Source:
Lozoya-Santos et al., eq. (9), first four terms.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.signals.layout import A, V, X


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += f_0 + c v + k x + m a."""
    for i in range(force.size):
        force[i] += (
            parameters[0]
            + parameters[1] * kinematics[V, i]
            + parameters[2] * kinematics[X, i]
            + parameters[3] * kinematics[A, i]
        )


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    parameters=(
        Parameter("offset", "N", 0.0, -20000.0, 20000.0, "offset f_0", linear=True),
        Parameter("damping", "N s/m", 500.0, -1e5, 1e5, "damping c", linear=True),
        Parameter("stiffness", "N/m", 0.0, -2e5, 2e5, "stiffness k", linear=True),
        Parameter("mass", "kg", 0.0, -50.0, 50.0, "virtual mass m", linear=True),
    ),
    shows="straight lines in F-v, F-x and F-a",
)
