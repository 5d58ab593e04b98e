"""Eddy currents in the magnetic circuit: a share of the field follows the current late.

    M = (1 - e) I + e I_s,      tau dI_s/dt + I_s = I

I the command in A, M in A the command that has the same field; e without unit the share of the field that eddy
currents hold back, tau in s the time in which they decay. The lag is exact for a command that is held between samples.
The coil's lag is ``command_lag``. One state; exact. Source: the slowest mode of the field's diffusion into a conducting
core; what is faster follows at once.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.command_lag import lagged
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.effects.slow_channels import changing_command
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.signals.layout import COMMAND, DT


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """I <- M, in this path's copy."""
    for i in range(force.size):
        command = kinematics[COMMAND, i]
        state[0] = lagged(state[0], command, kinematics[DT, i], parameters[1])
        kinematics[COMMAND, i] = command + parameters[0] * (state[0] - command)


def trial(ranges: Ranges) -> Trial:
    """Only a changing command can show it; below 20 ms it is the coil's lag."""
    changing_command(ranges)
    limits = {"share": (0.0, 0.9), "time_constant": (0.02, 1.0)}
    return Trial({"share": 0.3, "time_constant": 0.1}, limits, spread(share=(0.2, 0.5), time_constant=(0.04, 0.2)))


EFFECT = Effect(
    kernel=kernel,
    kind="input",
    phenomenon="current",
    tests=("current", "earlier commands"),
    parameters=(
        Parameter("share", "1", 0.3, 0.0, 0.95, "of the field, late"),
        Parameter("time_constant", "s", 0.1, 0.005, 5.0, "time in which the eddy currents decay"),
    ),
    states=1,
    order=1,
    shows="after a step of the command the force reaches its value in two stages, one of them slow",
    separate="steps of the command at constant velocity, held for a second",
    trial=trial,
)
