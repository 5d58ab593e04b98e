"""Fade with the heat that the damper dissipates, if no temperature is measured.

    d(theta)/dt = (F - F_0) v / C - theta / tau,      F <- F_0 + (F - F_0) (1 - kappa theta)

theta in K above the surroundings, C in J/K and F_0 in N, the force at rest (settings), tau in s, kappa in 1/K;
(F - F_0) v is the dissipated power. The gain stays between 0.1 and 1. One state, theta; first order in the step.
Source: energy balance; Lion and Loose 2002.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.signals.layout import DT, V


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F <- F_0 + (F - F_0) (1 - kappa theta), theta from the past power."""
    still = settings[1]
    for i in range(force.size):
        dt = kinematics[DT, i]
        if dt <= 0.0:
            state[0] = 0.0
        force[i] = still + (force[i] - still) * min(max(1.0 - parameters[0] * state[0], 0.1), 1.0)
        power = max((force[i] - still) * kinematics[V, i], 0.0)
        state[0] = (state[0] + dt * power / settings[0]) / (1.0 + dt / parameters[1])


def trial(ranges: Ranges) -> Trial:
    """Small dampers heat up fast; cooling takes minutes."""
    values = {"capacity": 300.0, "at_rest": ranges.at_rest, "cooling": 300.0}
    return Trial(values, {"cooling": (30.0, 3000.0)}, spread(fade=(5e-4, 1e-2)))


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    phenomenon="temperature_fade",
    tests=("temperature",),
    parameters=(
        Parameter("fade", "1/K", 0.003, 0.0, 0.03, "loss of force per kelvin"),
        Parameter("cooling", "s", 600.0, 10.0, 1e4, "time constant of cooling"),
    ),
    settings=(
        Setting("capacity", "J/K", 800.0, "heat capacity of damper and oil", lower=10.0),
        Setting("at_rest", "N", 0.0, "force at rest, which keeps its value", adds=True),
    ),
    states=1,
    linear=False,
    order=1,
    shows="the force at the same motion falls during hard driving and recovers in pauses",
    separate="a pause of some minutes in the middle of a hard run",
    trial=trial,
)
