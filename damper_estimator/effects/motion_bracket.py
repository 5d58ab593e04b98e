"""Bracket with displacement and the square of acceleration, in the units of its source.

    F <- F (p + q d + r b^2 sgn(b)),      d = 1000 x,      b = 1000 a

d in mm, b in mm/s^2. The scale is redundant with the preceding effects: models fix the constant. No state.
Source: black-box model (8), second bracket.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.signals.layout import A, X


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F *= bracket."""
    for i in range(force.size):
        b = 1000.0 * kinematics[A, i]
        force[i] *= parameters[0] + 1000.0 * parameters[1] * kinematics[X, i] + parameters[2] * b * abs(b)


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    parameters=(
        Parameter("constant", "1", 1.0, -5000.0, 5100.0, "p"),
        Parameter("displacement", "1/mm", 0.0, -5000.0, 5100.0, "q"),
        Parameter("square", "s^4/mm^2", 0.0, -5000.0, 5100.0, "r"),
    ),
    shows="the F-v loop opens in proportion to the force",
)
