"""Bypass groove: around a stroke position part of the oil flows past the piston.

    v <- v (1 - s (1 + d sgn v) h(x) / sqrt(1 + |v| / v_o)),      h(x) = 1 / (1 + ((x - x_0) / w)^4)

s without unit is the share of the oil that flows through the groove at low speed at its middle; d without unit is 0 for
a groove, 1 or -1 for ports with a check valve that pass oil in rebound or in compression only; x_0 in m its middle, w
in m half its length; v_o in m/s the speed at which the valves open and the groove's share begins to fall. The valves
pass the remaining oil, so the velocity is rewritten and not the force. No state. Source: parallel orifices, as in
position-sensitive dampers, e.g. Lee and Moon 2005.
"""

from math import sqrt

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Values, number
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.signals.layout import V, X

_LONGEST = 0.4  # of the stroke, half the length of a groove


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """v *= 1 - s h(x) / sqrt(1 + |v| / v_o), in this path's copy."""
    for i in range(force.size):
        away = (kinematics[X, i] - parameters[1]) / parameters[2]
        square = away * away
        opened = sqrt(1.0 + abs(kinematics[V, i]) / parameters[3])
        way = 1.0 + parameters[4] if kinematics[V, i] > 0.0 else 1.0 - parameters[4]
        kinematics[V, i] *= 1.0 - min(parameters[0] * way, 0.99) / ((1.0 + square * square) * opened)


def trial(ranges: Ranges) -> Trial:
    """The groove lies within the recorded stroke and is shorter than the stroke. One that would be as long acts alike
    at every position: it changes the curve, with ports that of one direction, unless it explains clearly more.
    """
    stroke, middle = ranges.stroke, ranges.middle
    limits = {
        "share": (0.0, 0.95),
        "middle": (ranges.compression, ranges.extension),
        "half_length": (0.02 * stroke, _LONGEST * stroke),
        "opening": (0.01 * ranges.speed, 2.0 * ranges.speed),
    }
    values = {"share": 0.3, "middle": middle, "half_length": 0.1 * stroke, "opening": 0.2 * ranges.speed}
    places = (middle - 0.25 * stroke, middle + 0.25 * stroke, middle)
    starts = spread(middle=places, half_length=(0.06 * stroke, 0.2 * stroke))
    ports = spread(middle=places, half_length=(0.2 * stroke,), check=(-0.9, 0.9))

    def exclusion(values: Values) -> str:
        is_long = number(values, "half_length") > 0.95 * _LONGEST * stroke
        return "as long as the stroke: a change of the curve" if is_long else ""

    return Trial(values, limits, (*starts, *ports), exclusion, imitates="curve")


EFFECT = Effect(
    kernel=kernel,
    kind="input",
    phenomenon="position_dependence",
    tests=("position",),
    parameters=(
        Parameter("share", "1", 0.2, 0.0, 0.99, "share of the oil that flows through the groove"),
        Parameter("middle", "m", 0.0, -0.5, 0.5, "stroke position of the groove's middle"),
        Parameter("half_length", "m", 0.01, 1e-4, 0.5, "half the groove's length"),
        Parameter("opening", "m/s", 0.1, 1e-3, 5.0, "speed at which the valves open"),
        Parameter("check", "1", 0.0, -1.0, 1.0, "1: passes oil in rebound only, -1: in compression only, 0: in both"),
    ),
    of_oil=True,
    shows="at the same velocity the damper is softer in one part of the stroke",
    separate="the same velocities at several mean positions",
    trial=trial,
)
