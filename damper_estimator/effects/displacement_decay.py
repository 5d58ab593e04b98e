"""Bracket that decays away from the middle of the stroke, in the units of its source.

    F <- F (p + q exp(-|d|)),      d = 1000 x

d in mm. The scale is redundant with the preceding effects: models fix the constant. No state. Source: black-box
models (9) to (11).
"""

from math import exp

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.signals.layout import X


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F *= bracket."""
    for i in range(force.size):
        force[i] *= parameters[0] + parameters[1] * exp(-abs(1000.0 * kinematics[X, i]))


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    phenomenon="position_dependence",
    tests=("position",),
    parameters=(
        Parameter("constant", "1", 1.0, -5000.0, 5100.0, "p"),
        Parameter("decay", "1", 0.0, -5000.0, 5100.0, "q"),
    ),
    shows="a narrow dent or bump of the force in the middle of the stroke",
    separate="slow passages through the middle",
    trial=None,
)
