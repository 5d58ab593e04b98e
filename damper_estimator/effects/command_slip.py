"""Yield that the command raises up to saturation, of many small parts that slip after different travels and creep.

    F = F_y (exp(-I_0 / I_s) - exp(-|I| / I_s)) s,      s = mean_k s_k,      tau dI/dt + I = M,
    ds_k = du / w_k  while |s_k| < 1,     w_k = w exp(g n_k),      n_k = -1 ... 1,      du/dt = v - v_c s

F_y in N (yield force of the saturated field), I_s in A, I_0 in A (setting) the command at which nothing is added, 0 as
a rule, w in m the median travel before a part slips, g without unit the spread of the travels, tau in s, v_c in m/s the
creep; M the command in A. Below the creep's speed the parts yield before they slip, F grows with the velocity: the
force of a magneto-rheological damper rolls off there. The lag is exact for a command held between samples, s_k for a
step without reversal and creep, which is implicit. Without a command the force is zero. States: s_k, the last
displacement, I; first order in the step. Source: Iwan 1966 as in ``elastic_slip``, saturation and lag as in
``command_yield``; the creep is the dashpot c_1 in series with the hysteresis of Spencer et al. 1997, eq. (12), with a
rate that follows the yield force.
"""

from math import exp

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.effects.command_lag import lagged
from damper_estimator.effects.contract import Effect, Parameter, Setting
from damper_estimator.effects.elastic_slip import PARTS, first_and_ratio, held
from damper_estimator.effects.slow_channels import moved_command, with_moved_command, zero_command
from damper_estimator.effects.trial import Ranges, Trial, longest_yield, spread
from damper_estimator.signals.layout import COMMAND, DT, X

_CURRENT = PARTS + 1  # position in the state


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += F_y (exp(-I_0 / I_s) - exp(-|I| / I_s)) mean s_k."""
    start = exp(-settings[0] / parameters[1])
    first, ratio = first_and_ratio(parameters[2], parameters[3])
    for i in range(force.size):
        dt, command = kinematics[DT, i], kinematics[COMMAND, i]
        if dt <= 0.0:
            state[_CURRENT] = command
        share = held(state, kinematics[X, i], dt, parameters[2], first, ratio, parameters[5])
        state[_CURRENT] = lagged(state[_CURRENT], command, dt, parameters[4])
        if np.isfinite(state[_CURRENT]):
            field = start - exp(-abs(state[_CURRENT]) / parameters[1])
            force[i] += parameters[0] * field * share


def trial(ranges: Ranges) -> Trial:
    """Needs a command that changed, and a saturation that is not far below its values. Below some hundredths of the
    speed the yield force of known dampers rolls off.
    """
    most = max(abs(value) for value in moved_command(ranges))
    way, longest = 0.01 * ranges.stroke, longest_yield(ranges)
    limits = {
        "saturation": (0.4 * most, 20.0 * most),
        "way": (0.02 * way, longest),
        "spread": (0.1, 2.5),
        "time_constant": (1e-4, 0.1),
        "creep": (0.0, 0.3 * ranges.speed),
    }
    values = {
        "reference": zero_command(ranges),
        "saturation": most,
        "way": 0.3 * way,
        "spread": 1.0,
        "time_constant": 0.01,
        "creep": 0.02 * ranges.speed,
    }
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
        Parameter("way", "m", 3e-4, 1e-6, 0.05, "median travel before a part slips"),
        Parameter("spread", "1", 1.0, 0.1, 4.0, "spread of the travels; 0.1: nearly all parts slip at once"),
        Parameter("time_constant", "s", 0.015, 1e-4, 0.5, "time constant of the coil"),
        Parameter("creep", "m/s", 0.0, 0.0, 1.0, "speed at which the parts give way while they hold the whole force"),
    ),
    states=PARTS + 2,
    settings=(Setting("reference", "A", 0.0, "command at which it adds nothing", lower=0.0, upper=1e3),),
    order=1,
    shows="an odd step at each reversal whose height grows with the command; small loops lie inside large ones",
    separate="the same motion at several commands, with small reversals inside large ones",
    trial=trial,
)
