"""Damping that grows or fades with the stroke position: bypass grooves, position-sensitive valves.

    F <- F_0 + (F - F_0) (1 + g (x - x_0)^2 / s^2)

g without unit (gain at s from the middle), x_0 in m (middle), s in m (setting), F_0 in N (setting) the force at rest.
It scales the preceding effects of its path; the scale never falls below zero. No state. Source: position-sensitive
dampers, e.g. Lee and Moon 2005.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import KEPT_AT_REST, Effect, Parameter, Setting
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.signals.layout import X


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F <- F_0 + (F - F_0) max(0, 1 + g ((x - x_0) / s)^2)."""
    still = settings[1]
    for i in range(force.size):
        away = (kinematics[X, i] - parameters[1]) / settings[0]
        force[i] = still + (force[i] - still) * max(0.0, 1.0 + parameters[0] * away * away)


def trial(ranges: Ranges) -> Trial:
    """Gains refer to half the recorded stroke."""
    scale = max(0.5 * ranges.stroke, 1e-3)
    limits = {"gain": (-0.8, 3.0), "middle": (ranges.middle - 2.0 * scale, ranges.middle + 2.0 * scale)}
    values = {"scale": scale, "at_rest": ranges.at_rest, "gain": 0.3, "middle": ranges.middle}
    return Trial(values, limits, spread(gain=(-0.2, 0.3), middle=(ranges.middle - scale, ranges.middle + scale)))


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    phenomenon="position_dependence",
    tests=("position",),
    parameters=(
        Parameter("gain", "1", 0.0, -1.0, 5.0, "change of the force at one scale from the middle"),
        Parameter("middle", "m", 0.0, -0.5, 0.5, "stroke position of the groove's middle"),
    ),
    settings=(
        Setting("scale", "m", 0.05, "stroke from the middle to which the gain refers", lower=1e-4),
        KEPT_AT_REST,
    ),
    shows="at the same velocity the force differs between the middle and the ends of the stroke",
    separate="the same velocities at several mean positions",
    trial=trial,
)
