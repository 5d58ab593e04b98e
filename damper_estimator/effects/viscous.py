"""Linear viscous damping with one rate for both directions.

    F = c v

F in N, v in m/s, c in N s/m. No state. Source: the viscous term common to the Kwok, Guo and Cesmeci models
(Lozoya-Santos et al., eqs. (1) to (3)).
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.signals.layout import V


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += c v."""
    for i in range(force.size):
        force[i] += parameters[0] * kinematics[V, i]


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    parameters=(Parameter("rate", "N s/m", 1500.0, 0.0, 2e5, "damping rate", linear=True),),
    shows="a straight line through the origin in F-v, the same in rebound and compression",
)
