"""One direction of the damper is stronger or weaker by a factor.

    F <- F_0 + (F - F_0) (1 + g)  where s (F - F_0) > 0,      F elsewhere

g without unit; s (setting) is 1 for the force in rebound, -1 for that in compression; F_0 in N (setting), the force at
rest. The valves of one direction see the pressure of that direction, so it is the sign of the force that decides, also
where the force lags behind the velocity. No state. Source: Dixon 2008, bump-to-rebound ratio.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import KEPT_AT_REST, Effect, Parameter, Setting
from damper_estimator.effects.trial import Ranges, Trial


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F <- F_0 + (F - F_0) (1 + g) in one direction."""
    side, still = settings[0], settings[1]
    for i in range(force.size):
        over = force[i] - still
        if side * over > 0.0:
            force[i] = still + over * (1.0 + parameters[0])


def trial(ranges: Ranges) -> Trial:
    """Either direction."""
    return Trial({"side": 1.0, "at_rest": ranges.at_rest}, conditions=({"side": -1.0},))


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    phenomenon="asymmetry",
    tests=("even", "rebound", "compression"),
    parameters=(Parameter("gain", "1", 0.0, -0.9, 3.0, "relative change of the force in that direction"),),
    settings=(
        Setting("side", "1", 1.0, "1: the force in rebound changes, -1: that in compression", lower=-1.0, upper=1.0),
        KEPT_AT_REST,
    ),
    linear=False,
    shows="the error is a fixed share of the force in one direction, and nothing in the other one",
    separate="constant speeds in both directions",
    trial=trial,
)
