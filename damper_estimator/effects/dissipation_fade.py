"""Fade with the heat that the damper dissipates, and that it is given, if no temperature is measured.

    d(theta)/dt = (F - F_0) v / C + h - theta / tau,    theta(0) = theta_0,    F <- F_0 + (F - F_0) (1 - kappa theta)

theta in K above the temperature of the identification, theta_0 that at the start, tau in s, kappa in 1/K; C in J/K and
F_0 in N, the force at rest (settings). (F - F_0) v is the dissipated power, h in K/s the warming by what surrounds the
damper, such as an engine or a climatic chamber. The gain stays between 0.1 and 2. One state, theta; first order in the
step. Source: energy balance; Lion and Loose 2002.
"""

from math import exp

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import KEPT_AT_REST, Effect, Parameter, Setting, Values, number
from damper_estimator.effects.slow_channels import keeps_its_temperature
from damper_estimator.effects.trial import Ranges, Trial, Untestable, spread
from damper_estimator.signals.layout import DT, V

_FASTEST = 20.0  # s, cooling of a small damper in an air stream
_STAYS = 0.7  # share of the start's temperature that is left at the end


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F <- F_0 + (F - F_0) (1 - kappa theta), theta from the past power."""
    still = settings[1]
    for i in range(force.size):
        dt = kinematics[DT, i]
        if dt <= 0.0:
            state[0] = parameters[3]
        force[i] = still + (force[i] - still) * min(max(1.0 - parameters[0] * state[0], 0.1), 2.0)
        power = max((force[i] - still) * kinematics[V, i], 0.0)
        state[0] = (state[0] + dt * (power / settings[0] + parameters[2])) / (1.0 + dt / parameters[1])


def trial(ranges: Ranges) -> Trial:
    """Small dampers heat up fast; cooling takes minutes. One that stays as warm as it starts has another gain.

    Raises:
        Untestable: if a thermometer shows that the temperature stayed: then something else drifts.
    """
    if keeps_its_temperature(ranges):
        raise Untestable("the thermometer shows that the damper did not warm up")
    values = {"capacity": 300.0, "at_rest": ranges.at_rest, "cooling": 300.0}
    starts = spread(fade=(5e-4, 1e-2), warming=(0.0, 0.3), start=(0.0, 20.0))

    def exclusion(fitted: Values) -> str:
        start, cooling, warming = (number(fitted, name) for name in ("start", "cooling", "warming"))
        stays = exp(-ranges.seconds / cooling) > _STAYS and abs(start) > abs(warming) * ranges.seconds
        return "is as warm at the end as at the start: another gain" if stays else ""

    return Trial(values, {"cooling": (_FASTEST, 3000.0)}, starts, exclusion)


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    phenomenon="temperature_fade",
    tests=("temperature",),
    parameters=(
        Parameter("fade", "1/K", 0.003, 0.0, 0.03, "loss of force per kelvin"),
        Parameter("cooling", "s", 600.0, 10.0, 1e4, "time constant of cooling"),
        Parameter("warming", "K/s", 0.0, -1.0, 1.0, "warming by the surroundings"),
        Parameter("start", "K", 0.0, -100.0, 100.0, "temperature at the start"),
    ),
    settings=(
        Setting("capacity", "J/K", 800.0, "heat capacity of damper and oil", lower=10.0),
        KEPT_AT_REST,
    ),
    states=1,
    linear=False,
    order=1,
    shows="the force at the same motion falls during hard driving and recovers in pauses",
    separate="a pause of some minutes in the middle of a hard run",
    trial=trial,
)
