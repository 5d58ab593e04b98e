"""Bracket that saturates over acceleration, in the units of its source.

    F <- F (p + q tanh(b / (3 sigma))),      b = 1000 a

b in mm/s^2, sigma the standard deviation of b, a setting. The scale is redundant with the preceding effects: models fix
the constant. No state. Source: black-box model (12).
"""

from math import tanh

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting
from damper_estimator.signals.layout import A


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F *= bracket."""
    for i in range(force.size):
        force[i] *= parameters[0] + parameters[1] * tanh(1000.0 * kinematics[A, i] / (3.0 * settings[0]))


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    phenomenon="hysteresis",
    parameters=(
        Parameter("constant", "1", 1.0, -5000.0, 5100.0, "p"),
        Parameter("saturation", "1", 0.0, -5000.0, 5100.0, "q"),
    ),
    settings=(Setting("deviation", "mm/s^2", 20000.0, "standard deviation of the acceleration", lower=1e-3),),
    shows="the F-v loop opens in proportion to the force",
    separate="the same peak velocity at two frequencies",
    trial=None,
)
