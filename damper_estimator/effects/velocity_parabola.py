"""Parabola over velocity with separate coefficients per direction, in the units of its source.

    F = x_1 + x_2r w + x_3r w^2  for w > 0,      F = x_1 + x_2c w - x_3c w^2  for w <= 0,      w = 1000 v

F in N, w in mm/s; the square carries sgn(w). No state. Source: first bracket of the black-box models (3) to
(12).
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.signals.layout import V


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += parabola(w)."""
    for i in range(force.size):
        w = 1000.0 * kinematics[V, i]
        if w > 0.0:
            force[i] += parameters[0] + w * (parameters[1] + w * parameters[3])
        else:
            force[i] += parameters[0] + w * (parameters[2] - w * parameters[4])


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="asymmetry",
    tests=("even",),
    parameters=(
        Parameter("constant", "N", 0.0, -5000.0, 5100.0, "x_1", linear=True),
        Parameter("linear_rebound", "N s/mm", 1.0, -5000.0, 5100.0, "x_2 for w > 0", linear=True),
        Parameter("linear_compression", "N s/mm", 1.0, -5000.0, 5100.0, "x_2 for w <= 0", linear=True),
        Parameter("square_rebound", "N s^2/mm^2", 0.0, -5000.0, 5100.0, "x_3 for w > 0", linear=True),
        Parameter("square_compression", "N s^2/mm^2", 0.0, -5000.0, 5100.0, "x_4 for w <= 0", linear=True),
    ),
    shows="F-v is curved, differently in rebound and compression",
    separate="speeds over the whole range in both directions",
    trial=None,
)
