"""Bracket that saturates over displacement, in the units of its source.

    F <- F (p + q tanh(d / (3 sigma))),      d = 1000 x

d in mm, sigma the standard deviation of d (the source says variance, which has the wrong dimension), a
setting. The scale is redundant with the preceding effects: models fix the constant. No state. Source: black-box
model (12).
"""

from math import tanh

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting
from damper_estimator.signals.layout import X


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F *= bracket."""
    for i in range(force.size):
        force[i] *= parameters[0] + parameters[1] * tanh(1000.0 * kinematics[X, i] / (3.0 * settings[0]))


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    phenomenon="position_dependence",
    tests=("position",),
    parameters=(
        Parameter("constant", "1", 1.0, -5000.0, 5100.0, "p"),
        Parameter("saturation", "1", 0.0, -5000.0, 5100.0, "q"),
    ),
    settings=(Setting("deviation", "mm", 7.5, "standard deviation of the displacement", lower=1e-3),),
    shows="at the same velocity the force differs over the stroke",
    separate="the same velocities at several mean positions",
    trial=None,
)
