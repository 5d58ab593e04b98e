"""Scale that grows with the command and saturates: a yield force, a damping rate or a series element under current.

    F <- F_0 + (F - F_0) (r + (1 - r) s),      s = (1 - exp(-b |I|)) / (1 - exp(-b I_r))

r without unit is the share without command; I the command in A, I_r in A (setting) the command at which the scale is 1;
F_0 in N (setting) is the force at rest, which is not scaled; b in 1/A bends s down towards saturation, b < 0 bends it
upwards, b = 0 leaves it straight. Without a command the force is unchanged. The coil's lag is ``command_lag``, placed
before it in the path. The scale never falls below a thousandth. No state. Source: saturation as in ``command_yield``;
Spencer et al. 1997, eqs. (17) to (19), for b = 0.
"""

from math import expm1

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import KEPT_AT_REST, Effect, Parameter, Setting
from damper_estimator.effects.slow_channels import moved_command, reference_commands, with_moved_command
from damper_estimator.effects.trial import Ranges, Trial, Untestable, spread
from damper_estimator.signals.layout import COMMAND

_LEAST = 1e-3  # of the scale: no element vanishes


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F <- F_0 + (F - F_0) (r + (1 - r) s)."""
    bend, reference, still = parameters[1], settings[0], settings[1]
    for i in range(force.size):
        command = abs(kinematics[COMMAND, i])
        if np.isfinite(command):
            share = command / reference if bend == 0.0 else expm1(-bend * command) / expm1(-bend * reference)
            scale = max(parameters[0] + (1.0 - parameters[0]) * share, _LEAST)
            force[i] = still + (force[i] - still) * scale


def trial(ranges: Ranges) -> Trial:
    """The model holds at one command; one that has never changed scales nothing."""
    most = max(abs(value) for value in moved_command(ranges))
    limits = {"rest": (0.0, 3.0), "bend": (-1.0 / most, 10.0 / most)}
    first, *others = reference_commands(ranges)
    if first < 1e-3:
        raise Untestable("the model was identified without a command, of which its force is no multiple")
    values = {"reference": first, "at_rest": ranges.at_rest, "rest": 0.5, "bend": 1.0 / most}
    conditions = tuple({"reference": at} for at in others)
    return with_moved_command(Trial(values, limits, spread(rest=(0.1, 0.5, 1.5)), conditions=conditions), ranges)


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    phenomenon="current",
    tests=("current",),
    parameters=(
        Parameter("rest", "1", 0.3, 0.0, 5.0, "share without command"),
        Parameter("bend", "1/A", 1.0, -5.0, 50.0, "how fast it saturates; 0 is straight"),
    ),
    settings=(
        Setting("reference", "A", 1.0, "command at which the scale is 1", lower=1e-3, upper=1e3),
        KEPT_AT_REST,
    ),
    shows="the force at the same motion grows with the command and saturates",
    separate="the same motion at several commands",
    trial=trial,
)
