"""Magnetic hysteresis: the field lags behind the current by a way of the current, not by a time.

    M = I - mean_k z_k,      dz_k = dI  while |z_k| < r_k,      r_k = 2 w (k - 1/2) / n,      k = 1 ... n

I the command in A, M in A the command that has the same field, w in A the width. After a long rise M is w below the
command, after a long fall w above it; after a reversal it stays at first and follows along a parabola. A command that
is held leaves M where it is, so the force of a magneto-rheological damper depends on the commands before, while noise
of the command changes it little. Exact for any sequence of commands. Begins without remanence. States: z_k, the last
command. Source: Rayleigh 1887 for the parabolas, as elements of equally distributed widths (Prandtl and Ishlinskii);
for magneto-rheological dampers An and Kwon 2003.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.effects.slow_channels import changing_command
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.signals.layout import COMMAND, DT

_PARTS = 8
_BEFORE = _PARTS  # position of the last command in the state


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """I <- M, in this path's copy."""
    for i in range(force.size):
        command = kinematics[COMMAND, i]
        if kinematics[DT, i] <= 0.0 or state[_BEFORE] != state[_BEFORE]:
            for k in range(_PARTS):
                state[k] = 0.0
            state[_BEFORE] = command
        if command != command:
            continue  # NaN: the field stays as it is
        change, behind = command - state[_BEFORE], 0.0
        for k in range(_PARTS):
            widest = 2.0 * parameters[0] * (k + 0.5) / _PARTS
            state[k] = min(max(state[k] + change, -widest), widest)
            behind += state[k] / _PARTS
        state[_BEFORE] = command
        kinematics[COMMAND, i] = command - behind


def trial(ranges: Ranges) -> Trial:
    """Needs a changing command, and a loop that is narrower than its range."""
    values = changing_command(ranges)
    span = max(values) - min(values)
    limits = {"width": (0.002 * span, 0.5 * span)}
    return Trial({"width": 0.05 * span}, limits, spread(width=(0.02 * span, 0.05 * span, 0.15 * span)))


EFFECT = Effect(
    kernel=kernel,
    kind="input",
    phenomenon="current",
    tests=("current", "earlier commands"),
    parameters=(Parameter("width", "A", 0.05, 1e-6, 1e3, "distance of the field behind the command after a long way"),),
    states=_PARTS + 1,
    order=1,
    shows="at the same command the force is higher after higher commands",
    separate="steps of the command up and down to the same value at constant velocity",
    trial=trial,
)
