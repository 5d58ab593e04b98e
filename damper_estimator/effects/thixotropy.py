"""Fluid whose structure breaks down in motion and grows again at rest: the force depends on how much it moved lately.

    db/dt = (1 - b) |v| / l - b / tau,      F <- F_0 + (F - F_0) (1 + a (n - b))

b is the broken share of the structure, a the force that the whole structure carries as a share of the force, n the
broken share at which the model holds, l in m the travel that breaks it down, tau in s the time in which it grows again;
F_0 in N is the force at rest (a setting). The factor is at least 0.1. One state, b; first order in the step. Source:
Moore 1959, "The rheology of ceramic slips and bodies", Trans. Brit. Ceram. Soc. 58; Barnes 1997, "Thixotropy - a
review", J. Non-Newtonian Fluid Mech. 70.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import KEPT_AT_REST, Effect, Parameter, Values, number
from damper_estimator.effects.trial import Ranges, Trial
from damper_estimator.signals.layout import DT, V

_SLOW = 0.1  # of the recorded speed
_LEAST_CHANGE = 0.15  # of the structure, between slow and fast motion
_FASTEST = 0.15  # s, within which the structure follows ordinary motion


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F <- F_0 + (F - F_0) (1 + a (n - b))."""
    still = settings[0]
    for i in range(force.size):
        dt = kinematics[DT, i]
        breaking = abs(kinematics[V, i]) / parameters[2]
        if dt <= 0.0:
            state[0] = parameters[1]
        else:
            state[0] = (state[0] + dt * breaking) / (1.0 + dt * (breaking + 1.0 / parameters[3]))
        factor = max(1.0 + parameters[0] * (parameters[1] - state[0]), 0.1)
        force[i] = still + (force[i] - still) * factor


def trial(ranges: Ranges) -> Trial:
    """Structure that follows every stroke makes a curve, over minutes it is warming; one that is always broken, or
    never, makes a gain.
    """
    slowest = min(0.2 * ranges.seconds, 10.0)
    mean = 0.3 * ranges.speed
    limits = {"recovery": (min(0.2, 0.5 * slowest), slowest), "travel": (0.05 * mean, 10.0 * mean)}
    starts = tuple({"recovery": time, "travel": mean * time} for time in (0.1 * slowest, 0.4 * slowest))
    values = {"strength": 0.3, "neutral": 0.5, "at_rest": ranges.at_rest, "travel": mean, "recovery": 0.2 * slowest}

    def exclusion(fitted: Values) -> str:
        travel, recovery = number(fitted, "travel"), number(fitted, "recovery")
        slow, fast = (share * ranges.speed * recovery / travel for share in (_SLOW, 1.0))
        if 1.0 / (1.0 / recovery + mean / travel) < _FASTEST:
            return "its structure follows every stroke: a curve"
        change = fast / (1.0 + fast) - slow / (1.0 + slow)
        return "its structure hardly changes: a gain" if change < _LEAST_CHANGE else ""

    return Trial(values, limits, starts, exclusion)


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    phenomenon="hysteresis",
    parameters=(
        Parameter("strength", "1", 0.3, 0.0, 3.0, "force of the whole structure, as a share of the force"),
        Parameter("neutral", "1", 0.5, 0.0, 1.0, "broken share at which the model holds"),
        Parameter("travel", "m", 0.3, 1e-3, 30.0, "travel that breaks the structure down"),
        Parameter("recovery", "s", 2.0, 0.05, 60.0, "time in which it grows again"),
    ),
    settings=(KEPT_AT_REST,),
    states=1,
    linear=False,
    order=1,
    shows="the force is larger after a pause or slow motion than after fast motion, and falls within seconds",
    separate="the same sine after a pause of half a minute and after fast motion",
    trial=trial,
    general=True,
)
