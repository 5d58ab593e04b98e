"""Change of the force-velocity curve with the command, of any form.

    F = (|I| - I_0) / d f(v)

f in N is the change at I_0 + d, with its curves for rebound and compression: zero at rest, straight between their
knots, held beyond the last. I the command in A, I_0 and d in A (settings). Without a command the force is zero. No
state. Source: form-free counterpart of ``command_yield`` and ``command_gain``: the field of force over velocity and
current that makers of semi-active dampers publish (Savaresi et al. 2010).
"""

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting
from damper_estimator.effects.direction_curve import over_speed
from damper_estimator.effects.slow_channels import command_moved, moved_command, reference_commands, with_moved_command
from damper_estimator.effects.trial import Number, Ranges, Trial
from damper_estimator.signals.layout import COMMAND, V


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += (|I| - I_0) / d f(v)."""
    count = settings.size - 2
    reference, span = settings[count], settings[count + 1]
    for i in range(force.size):
        v, command = kinematics[V, i], abs(kinematics[COMMAND, i])
        if np.isfinite(command):
            first = 0 if v > 0.0 else count
            change = over_speed(settings, parameters[first : first + count], min(abs(v), settings[count - 1]))
            force[i] += (command - reference) / span * change


def trial(ranges: Ranges) -> Trial:
    """Knots over the recorded speeds, close to rest as well, where a yield force turns round."""
    most = max(abs(value) for value in moved_command(ranges))
    first, *others = reference_commands(ranges)
    knots = tuple(share * ranges.speed for share in (0.03, 0.12, 0.4, 1.0))
    values: dict[str, Number] = {"speed": knots, "reference": first, "span": most}
    conditions = () if command_moved(ranges) else tuple({"reference": at} for at in (*others, 0.0))
    return with_moved_command(Trial(values, conditions=conditions), ranges)


_TABLE = ("N", 0.0, -50000.0, 50000.0)

EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="current",
    tests=("current",),
    parameters=(
        Parameter("rebound", *_TABLE, "change in rebound", linear=True, size="speed"),
        Parameter("compression", *_TABLE, "change in compression", linear=True, size="speed"),
    ),
    settings=(
        Setting("speed", "m/s", (0.02, 0.05, 0.2, 0.5), "knots over the speed", lower=1e-6, increasing=True),
        Setting("reference", "A", 0.0, "command at which the model holds", lower=0.0, upper=1e3),
        Setting("span", "A", 1.0, "change of the command that the parameters refer to", lower=1e-3),
    ),
    shows="the force at the same motion changes with the command, at some velocities more than at others",
    separate="the same motion at several commands",
    trial=trial,
    general=True,
)
