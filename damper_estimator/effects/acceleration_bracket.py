"""Bracket over acceleration, in the units of its source.

    F <- F (p + q b),      b = 1000 a

b in mm/s^2. The scale is redundant with the preceding effects: models fix the constant. No state. Source:
black-box models (5), (6).
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.signals.layout import A


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F *= bracket."""
    for i in range(force.size):
        force[i] *= parameters[0] + 1000.0 * parameters[1] * kinematics[A, i]


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    phenomenon="hysteresis",
    parameters=(
        Parameter("constant", "1", 1.0, -5000.0, 5100.0, "p"),
        Parameter("linear", "s^2/mm", 0.0, -5000.0, 5100.0, "q"),
    ),
    shows="the F-v loop opens in proportion to the force",
    separate="the same peak velocity at two frequencies",
    trial=None,
)
