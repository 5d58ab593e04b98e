"""Bracket over displacement, in the units of its source.

    F <- F (p + q d + r d^2 sgn(d)),      d = 1000 x

d in mm. The scale is redundant with the preceding effects: models fix the constant. No state. Source: black-box
models (4), (6), (7), second bracket.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.signals.layout import X


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F *= bracket."""
    for i in range(force.size):
        d = 1000.0 * kinematics[X, i]
        force[i] *= parameters[0] + d * (parameters[1] + parameters[2] * abs(d))


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    phenomenon="position_dependence",
    tests=("position",),
    parameters=(
        Parameter("constant", "1", 1.0, -5000.0, 5100.0, "p"),
        Parameter("linear", "1/mm", 0.0, -5000.0, 5100.0, "q"),
        Parameter("square", "1/mm^2", 0.0, -5000.0, 5100.0, "r"),
    ),
    shows="at the same velocity the force differs over the stroke",
    separate="the same velocities at several mean positions",
    trial=None,
)
