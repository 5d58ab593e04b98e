"""Current that is not the command: a driver with another gain or a dead band, a coil with shorted turns.

    I = sgn(I_c) max((1 + g) |I_c| - o, 0)

I_c in A is the command, I in A the current that the model is to use instead; g without unit is its relative error, o
in A a dead band, or if it is negative a current that remains. A model that does not follow the command stays as it is.
No state. Source: characteristic of a current driver.
"""

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.effects.slow_channels import changing_command
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.signals.layout import COMMAND


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """I <- sgn(I) max((1 + g) |I| - o, 0), in this path's copy."""
    for i in range(force.size):
        command = kinematics[COMMAND, i]
        if np.isfinite(command):
            size = max((1.0 + parameters[0]) * abs(command) - parameters[1], 0.0)
            kinematics[COMMAND, i] = size if command >= 0.0 else -size


def trial(ranges: Ranges) -> Trial:
    """Only a changing command shows that it is another one; a dead band is a part of it."""
    most = max(abs(end) for end in changing_command(ranges))
    starts = (*spread(gain=(-0.3, 0.3)), *spread(offset=(-0.2 * most, 0.2 * most)))
    return Trial({}, {"gain": (-0.8, 1.0), "offset": (-0.5 * most, 0.5 * most)}, starts)


EFFECT = Effect(
    kernel=kernel,
    kind="input",
    phenomenon="current",
    tests=("current",),
    parameters=(
        Parameter("gain", "1", 0.0, -0.95, 3.0, "relative error of the current"),
        Parameter("offset", "A", 0.0, -5.0, 5.0, "dead band; negative for a current that remains"),
    ),
    shows="the force is that of another command, at all velocities",
    separate="the current in the coil, measured beside its command",
    trial=trial,
)
