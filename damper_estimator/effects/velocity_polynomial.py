"""Polynomial over velocity, in the units of its source.

    F = x_1 + x_2 w + x_3 w^2 + x_4 w^3,      w = 1000 v

F in N, w in mm/s. No state. Source: black-box models (1) and (2).
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.signals.layout import V


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += polynomial(w)."""
    for i in range(force.size):
        w = 1000.0 * kinematics[V, i]
        force[i] += parameters[0] + w * (parameters[1] + w * (parameters[2] + w * parameters[3]))


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    parameters=(
        Parameter("constant", "N", 0.0, -5000.0, 5100.0, "x_1", linear=True),
        Parameter("linear", "N s/mm", 1.0, -5000.0, 5100.0, "x_2", linear=True),
        Parameter("square", "N s^2/mm^2", 0.0, -5000.0, 5100.0, "x_3", linear=True),
        Parameter("cubic", "N s^3/mm^3", 0.0, -5000.0, 5100.0, "x_4", linear=True),
    ),
    shows="one line in F-v at any frequency and amplitude",
)
