"""Change of the force-velocity curve with the measured temperature, of any form.

    F = (theta - theta_0) / d (f_0 + f(v))

f in N is the change at theta_0 + d, with its curves for rebound and compression: zero at rest, straight between their
knots, held beyond the last; f_0 in N is that of the gas. theta in deg C (measured), theta_0 and d in deg C and K
(settings). Without a temperature the force is unchanged. No state. Source: form-free counterpart of
``temperature_gain`` and ``viscosity_gain``: thin oil lowers the laminar part of the force, and hardly that of orifices
(Dixon 2008).
"""

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting
from damper_estimator.effects.direction_curve import over_speed
from damper_estimator.effects.slow_channels import (
    REFERENCE,
    changing_temperature,
    reference_temperatures,
    with_moved_temperature,
)
from damper_estimator.effects.trial import Number, Ranges, Trial
from damper_estimator.signals.layout import TEMPERATURE, V


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += (theta - theta_0) / d (f_0 + f(v))."""
    count = settings.size - 2
    reference, span = settings[count], settings[count + 1]
    for i in range(force.size):
        v, theta = kinematics[V, i], kinematics[TEMPERATURE, i]
        if np.isfinite(theta):
            first = 1 if v > 0.0 else 1 + count
            change = parameters[0] + over_speed(
                settings, parameters[first : first + count], min(abs(v), settings[count - 1])
            )
            force[i] += (theta - reference) / span * change


def trial(ranges: Ranges) -> Trial:
    """Knots over the recorded speeds; the model holds at one temperature."""
    low, high = changing_temperature(ranges)
    first, *others = reference_temperatures(ranges)
    knots = tuple(share * ranges.speed for share in (0.12, 0.4, 1.0))
    values: dict[str, Number] = {"speed": knots, "reference": first, "span": high - low}
    return with_moved_temperature(Trial(values, conditions=tuple({"reference": at} for at in others)), ranges)


_TABLE = ("N", 0.0, -50000.0, 50000.0)

EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="temperature_fade",
    tests=("temperature",),
    parameters=(
        Parameter("gas", *_TABLE, "change at rest", linear=True),
        Parameter("rebound", *_TABLE, "change in rebound", linear=True, size="speed"),
        Parameter("compression", *_TABLE, "change in compression", linear=True, size="speed"),
    ),
    settings=(
        Setting("speed", "m/s", (0.05, 0.2, 0.5), "knots over the speed", lower=1e-6, increasing=True),
        REFERENCE,
        Setting("span", "K", 20.0, "change of temperature that the parameters refer to", lower=0.1),
    ),
    shows="the force at the same motion changes as the damper warms up, at some velocities more than at others",
    separate="the same manoeuvre cold and warm",
    trial=trial,
    general=True,
)
