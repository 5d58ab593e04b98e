"""Yield force that grows with the command up to saturation, elastic before it yields, delayed by the coil's lag.

    F = F_y (exp(-I_0 / I_s) - exp(-|I| / I_s)) z,      dz/dx = (1 - sgn(v) z) / w,      tau dI/dt + I = M

F_y in N (yield force of the saturated field), I_s in A, I_0 in A (setting) the command at which nothing is added, 0 as
a rule, w in m the travel over which it builds up after a reversal, tau in s; M the command in A. The lag is exact for a
command held between samples, z for a step without reversal. Without a command the force is zero. States: z, the last
displacement, I; first order in the step for a changing command. Source: Bingham's yield with elastic pre-yield; the
coil's lag as in Lozoya-Santos et al., section 5.
"""

from math import exp

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.effects.command_lag import lagged
from damper_estimator.effects.contract import Effect, Parameter, Setting
from damper_estimator.effects.slow_channels import moved_command, with_moved_command, zero_command
from damper_estimator.effects.trial import Ranges, Trial, longest_yield, spread
from damper_estimator.signals.layout import COMMAND, DT, X


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += F_y (exp(-I_0 / I_s) - exp(-|I| / I_s)) z."""
    start = exp(-settings[0] / parameters[1])
    for i in range(force.size):
        x, dt, command = kinematics[X, i], kinematics[DT, i], kinematics[COMMAND, i]
        if dt <= 0.0:
            state[0] = 0.0
            state[1] = x
            state[2] = command
        move = x - state[1]
        state[1] = x
        direction = 1.0 if move > 0.0 else -1.0
        state[0] = direction - (direction - state[0]) * exp(-abs(move) / parameters[2])
        state[2] = lagged(state[2], command, dt, parameters[3])
        if np.isfinite(state[2]):
            force[i] += parameters[0] * (start - exp(-abs(state[2]) / parameters[1])) * state[0]


def trial(ranges: Ranges) -> Trial:
    """Needs a command that changed, and a saturation that is not far below its values."""
    most = max(abs(value) for value in moved_command(ranges))
    way, longest = 0.01 * ranges.stroke, longest_yield(ranges)
    limits = {"saturation": (0.4 * most, 20.0 * most), "way": (0.02 * way, longest), "time_constant": (1e-4, 0.1)}
    values = {"reference": zero_command(ranges), "saturation": most, "way": 0.3 * way, "time_constant": 0.01}
    starts = spread(way=(0.1 * way, way, 0.6 * longest), saturation=(0.6 * most, 3.0 * most))
    return with_moved_command(Trial(values, limits, starts), ranges)


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="current",
    tests=("current",),
    parameters=(
        Parameter("force", "N", 500.0, 0.0, 50000.0, "yield force of the saturated field", linear=True),
        Parameter("saturation", "A", 1.0, 1e-3, 100.0, "command at which the force reaches 63 % of it"),
        Parameter("way", "m", 3e-4, 1e-7, 0.05, "travel over which it builds up after a reversal"),
        Parameter("time_constant", "s", 0.015, 1e-4, 0.5, "time constant of the coil"),
    ),
    states=3,
    settings=(Setting("reference", "A", 0.0, "command at which it adds nothing", lower=0.0, upper=1e3),),
    order=1,
    shows="an odd step at each reversal whose height grows with the command and saturates",
    separate="the same motion at several commands",
    trial=trial,
)
