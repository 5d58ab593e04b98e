"""Bracket that decays with acceleration, in the units of its source.

    F <- F (p + q exp(-|b|)),      b = 1000 a

b in mm/s^2. The scale is redundant with the preceding effects: models fix the constant. No state. Source:
black-box models (10), (11).
"""

from math import exp

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.signals.layout import A


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F *= bracket."""
    for i in range(force.size):
        force[i] *= parameters[0] + parameters[1] * exp(-abs(1000.0 * kinematics[A, i]))


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    parameters=(
        Parameter("constant", "1", 1.0, -5000.0, 5100.0, "p"),
        Parameter("decay", "1", 0.0, -5000.0, 5100.0, "q"),
    ),
    shows="the force differs where the acceleration is nearly zero",
)
