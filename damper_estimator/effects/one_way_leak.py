"""Leak that passes oil in one direction: a check valve that does not close, or a passage with one.

    v <- v (1 - s / sqrt(1 + |v| / v_o))  for w v > 0,      v elsewhere

s without unit is the share of the oil that flows through the leak at low speed, negative where a leak was closed; v_o
in m/s is the speed at which the valves open and the leak's share begins to fall; w (setting) is 1 for rebound, -1 for
compression. The valves pass the remaining oil, so the velocity is rewritten and not the force. No state. Source:
parallel orifices, Dixon 2008.
"""

from math import sqrt

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.signals.layout import V


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """v *= 1 - s / sqrt(1 + |v| / v_o) in one direction, in this path's copy."""
    for i in range(force.size):
        v = kinematics[V, i]
        if settings[0] * v > 0.0:
            kinematics[V, i] = v * (1.0 - parameters[0] / sqrt(1.0 + abs(v) / parameters[1]))


def trial(ranges: Ranges) -> Trial:
    """Either direction; valves open within the recorded speeds."""
    limits = {"share": (-1.0, 0.98), "opening": (0.003 * ranges.speed, 2.0 * ranges.speed)}
    values = {"share": 0.2, "opening": 0.2 * ranges.speed, "side": 1.0}
    return Trial(values, limits, spread(opening=(0.05 * ranges.speed, ranges.speed)), conditions=({"side": -1.0},))


EFFECT = Effect(
    kernel=kernel,
    kind="input",
    phenomenon="asymmetry",
    tests=("even", "rebound", "compression"),
    parameters=(
        Parameter("share", "1", 0.2, -2.0, 0.99, "share of the oil that flows through the leak"),
        Parameter("opening", "m/s", 0.1, 1e-3, 5.0, "speed at which the valves open"),
    ),
    settings=(Setting("side", "1", 1.0, "1: passes oil in rebound, -1: in compression", lower=-1.0, upper=1.0),),
    of_oil=True,
    shows="the damper is softer in one direction, above all at low speed, wherever the piston is",
    separate="slow triangles: the force of one direction is lower, that of the other one stays",
    trial=trial,
)
