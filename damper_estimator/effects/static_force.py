"""A constant force: the gas force at rest, or the strain gauge's reading at rest.

    F = F_0

F in N. No state. Source: Carrera Akutain et al., section 5: the offset that the user sets to level model and
gauge.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += F_0."""
    for i in range(force.size):
        force[i] += parameters[0]


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    parameters=(Parameter("force", "N", 0.0, -20000.0, 20000.0, "force at rest", linear=True),),
    beside_oil=True,
    shows="the whole F-v diagram is shifted up or down",
)
