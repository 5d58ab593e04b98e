"""Fade with the measured temperature.

    F <- F (1 - kappa (theta - theta_0))

kappa in 1/K, theta in deg C (measured), theta_0 in deg C (setting). Without a temperature the force is left
as it is; the gain stays between 0.1 and 3. No state. Source: viscosity of the oil over temperature,
linearised.
"""

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting
from damper_estimator.signals.layout import TEMPERATURE


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F *= 1 - kappa (theta - theta_0)."""
    for i in range(force.size):
        theta = kinematics[TEMPERATURE, i]
        if np.isfinite(theta):
            force[i] *= min(max(1.0 - parameters[0] * (theta - settings[0]), 0.1), 3.0)


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    phenomenon="temperature_fade",
    parameters=(Parameter("fade", "1/K", 0.0, 0.0, 0.03, "loss of force per kelvin"),),
    settings=(Setting("reference", "deg C", 40.0, "temperature at which the model holds", lower=-60.0, upper=200.0),),
    shows="the force at the same motion falls as the damper warms up",
    separate="the same manoeuvre cold and warm",
)
