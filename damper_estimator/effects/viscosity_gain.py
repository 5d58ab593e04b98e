"""Scale that follows the oil's viscosity with the measured temperature.

    F <- F_0 + (F - F_0) exp(-b (theta - theta_0))

b in 1/K, theta in deg C (measured), theta_0 in deg C (setting); F_0 in N (setting) is the force at rest. It scales the
preceding effects of its path: a viscous force, or a series element. Without a temperature the force is unchanged; the
scale stays between 0.05 and 20. No state. Source: viscosity of oils over temperature, Reynolds' equation.
"""

from math import exp

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import KEPT_AT_REST, Effect, Parameter, Setting
from damper_estimator.effects.slow_channels import reference_temperatures, with_moved_temperature
from damper_estimator.effects.trial import Ranges, Trial
from damper_estimator.signals.layout import TEMPERATURE


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F <- F_0 + (F - F_0) exp(-b (theta - theta_0))."""
    still = settings[1]
    for i in range(force.size):
        theta = kinematics[TEMPERATURE, i]
        if np.isfinite(theta):
            scale = min(max(exp(-parameters[0] * (theta - settings[0])), 0.05), 20.0)
            force[i] = still + (force[i] - still) * scale


def trial(ranges: Ranges) -> Trial:
    """The model holds at one temperature; oils lose 1 to 4 % per kelvin."""
    first, *others = reference_temperatures(ranges)
    conditions = tuple({"reference": at} for at in others)
    values = {"reference": first, "at_rest": ranges.at_rest, "rate": 0.005}
    return with_moved_temperature(Trial(values, {"rate": (0.0, 0.06)}, conditions=conditions), ranges)


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    phenomenon="temperature_fade",
    tests=("temperature",),
    parameters=(Parameter("rate", "1/K", 0.01, -0.01, 0.1, "relative loss per kelvin"),),
    settings=(
        Setting("reference", "deg C", 40.0, "temperature at which the scale is 1", lower=-60.0, upper=200.0),
        KEPT_AT_REST,
    ),
    shows="the damping falls as the damper warms up; friction and gas force do not",
    separate="the same manoeuvre cold and warm",
    trial=trial,
)
