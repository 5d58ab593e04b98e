"""Semi-active force: yield that grows with the command, with pre-yield slopes over velocity and displacement.

    F = M g [ s(r_v v M) + s(r_x x) ],      s(u) = u / (1 + |u|)

M the command (A), g in N/A, r_v in s/(m A), r_x in 1/m. Without a command the force is zero. No state.
Source: Lozoya-Santos et al., eq. (10).
"""

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.effects.slow_channels import changing_command
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.signals.layout import COMMAND, V, X


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += M g [ s(r_v v M) + s(r_x x) ],      s(u) = u / (1 + |u|)."""
    for i in range(force.size):
        command = kinematics[COMMAND, i]
        if np.isfinite(command):
            u = parameters[1] * kinematics[V, i] * command
            w = parameters[2] * kinematics[X, i]
            force[i] += command * parameters[0] * (u / (1.0 + abs(u)) + w / (1.0 + abs(w)))


def trial(ranges: Ranges) -> Trial:
    """Needs a changing command."""
    steep = 20.0 / (ranges.speed * max(abs(value) for value in changing_command(ranges)))
    limits = {"damping": (0.05 * steep, 50.0 * steep), "stiffness": (0.0, 20.0 / ranges.stroke)}
    return Trial({"damping": steep, "stiffness": 0.0}, limits, spread(damping=(0.3 * steep, 3.0 * steep)))


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="current",
    tests=("current",),
    parameters=(
        Parameter("gain", "N/A", 400.0, 0.0, 20000.0, "force per command g", linear=True),
        Parameter("damping", "s/(m A)", 50.0, 0.0, 1e5, "steepness r_v over velocity and command"),
        Parameter("stiffness", "1/m", 0.0, -1e4, 1e4, "steepness r_x over displacement"),
    ),
    shows="the yield level grows with the command",
    separate="the same motion at several commands",
    trial=trial,
)
