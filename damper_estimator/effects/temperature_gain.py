"""Fade with the measured temperature.

    F <- F_0 + (F - F_0) (1 - kappa (theta - theta_0)) - g (theta - theta_0)

kappa in 1/K, g in N/K, theta in deg C (measured), theta_0 in deg C and F_0 in N, the force at rest (settings): the oil
gets thinner, and warm gas pushes the rod out harder. Without a temperature the force is unchanged; the gain stays
between 0.1 and 3. No state. Source: viscosity of the oil over temperature, linearised; the gas law.
"""

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import KEPT_AT_REST, Effect, Parameter
from damper_estimator.effects.slow_channels import REFERENCE, reference_temperatures, with_moved_temperature
from damper_estimator.effects.trial import Ranges, Trial
from damper_estimator.signals.layout import TEMPERATURE


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F <- F_0 + (F - F_0) (1 - kappa (theta - theta_0)) - g (theta - theta_0)."""
    still = settings[1]
    for i in range(force.size):
        theta = kinematics[TEMPERATURE, i]
        if np.isfinite(theta):
            warmer = theta - settings[0]
            scale = min(max(1.0 - parameters[0] * warmer, 0.1), 3.0)
            force[i] = still + (force[i] - still) * scale - parameters[1] * warmer


def trial(ranges: Ranges) -> Trial:
    """The model holds at one temperature."""
    first, *others = reference_temperatures(ranges)
    conditions = tuple({"reference": at} for at in others)
    values = {"reference": first, "at_rest": ranges.at_rest, "fade": 0.002}
    return with_moved_temperature(Trial(values, conditions=conditions), ranges)


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    phenomenon="temperature_fade",
    tests=("temperature",),
    parameters=(
        Parameter("fade", "1/K", 0.0, 0.0, 0.03, "loss of force per kelvin"),
        Parameter("gas", "N/K", 0.0, 0.0, 50.0, "rise of the gas force per kelvin"),
    ),
    linear=False,
    settings=(
        REFERENCE,
        KEPT_AT_REST,
    ),
    shows="the force at the same motion falls as the damper warms up",
    separate="the same manoeuvre cold and warm",
    trial=trial,
)
