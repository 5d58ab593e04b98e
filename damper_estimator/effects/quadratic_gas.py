"""Gas force as a parabola over displacement.

    F = A x^2 + B x + C

A in N/m^2, B in N/m, C in N, x in m. The source counts x positive in compression and in mm: its B = -0.25
N/mm is +250 N/m here. No state. Source: Gao et al., eq. (6).
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Values, number
from damper_estimator.effects.trial import Ranges, Trial
from damper_estimator.signals.layout import X


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += A x^2 + B x + C."""
    for i in range(force.size):
        x = kinematics[X, i]
        force[i] += (parameters[0] * x + parameters[1]) * x + parameters[2]


_STRAIGHT = 0.05  # change of the slope over the stroke, share of the slope


def trial(ranges: Ranges) -> Trial:
    """Gas resists compression progressively: the force rises with extension and bends down."""
    bend = 5.0 * ranges.force / ranges.stroke**2
    limits = {"square": (-bend, 0.0), "slope": (0.0, 5e4), "constant": (-1e-6, 1e-6)}

    def exclusion(values: Values) -> str:
        square, slope = (number(values, name) for name in ("square", "slope"))
        straight = abs(square) * ranges.stroke < _STRAIGHT * slope
        return "is straight over displacement: a spring, no gas" if straight else ""

    return Trial({"constant": 0.0}, limits, exclusion=exclusion)


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="gas_spring",
    tests=(
        "travel",
        "spring",
    ),
    parameters=(
        Parameter("square", "N/m^2", 0.0, -1e6, 1e6, "A", linear=True),
        Parameter("slope", "N/m", 250.0, -5e4, 5e4, "B", linear=True),
        Parameter("constant", "N", -150.0, -20000.0, 20000.0, "C, the preload", linear=True),
    ),
    beside_oil=True,
    shows="the force changes over displacement, at any velocity",
    separate="a slow stroke over the whole travel",
    trial=trial,
)
