"""First-order lag of the coil's current behind the command.

    tau dI/dt + I = I_command

tau in s, 20 to 30 ms for a magneto-rheological coil. The current enters the force non-linearly, so the current is
lagged and not the force. The lag is exact for a command that is held between samples. One state; exact. Source:
Lozoya-Santos et al., section 5.
"""

from math import exp

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.effects.slow_channels import changing_command
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.signals.layout import COMMAND, DT


@compiled
def lagged(before, command, dt, constant):
    """The current after a step of ``dt`` with a held command; the command itself where there was none before."""
    if dt > 0.0 and np.isfinite(before):
        return command + (before - command) * exp(-dt / constant)
    return command


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """I <- lag(I), in this path's copy."""
    for i in range(force.size):
        state[0] = lagged(state[0], kinematics[COMMAND, i], kinematics[DT, i], parameters[0])
        kinematics[COMMAND, i] = state[0]


def trial(ranges: Ranges) -> Trial:
    """Only a changing command can show a lag."""
    changing_command(ranges)
    return Trial({"time_constant": 0.01}, {"time_constant": (1e-4, 0.2)}, spread(time_constant=(0.003, 0.03)))


EFFECT = Effect(
    kernel=kernel,
    kind="input",
    phenomenon="current",
    tests=("current", "earlier commands"),
    parameters=(Parameter("time_constant", "s", 0.025, 1e-4, 0.5, "time constant of the coil"),),
    states=1,
    order=1,
    shows="the force follows a step of the command with a delay",
    separate="steps of the command at constant velocity",
    trial=trial,
)
