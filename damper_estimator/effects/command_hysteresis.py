"""Magnetic hysteresis: the field lags behind the current by a way of the current, not by a time.

    w dM = |dI| (I - M)

I the command in A, M in A the command that has the same field, w in A the width. After a long rise M is w below the
command, after a long fall w above it; after a reversal it follows slowly at first. A command that is held leaves M
where it is, so the force of a magneto-rheological damper depends on the commands before. Exact for any sequence of
commands. Begins without remanence. One state. Source: Coleman and Hodgdon 1986, with f(I) = I and g = 0; for
magneto-rheological dampers An and Kwon 2003.
"""

from math import exp

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.effects.trial import Ranges, Trial, changing_command, spread
from damper_estimator.signals.layout import COMMAND, DT

_BEHIND, _BEFORE = 0, 1  # positions in the state: I - M, and the last command


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """I <- M, in this path's copy."""
    width = parameters[0]
    for i in range(force.size):
        command = kinematics[COMMAND, i]
        if kinematics[DT, i] <= 0.0 or state[_BEFORE] != state[_BEFORE]:
            state[_BEHIND], state[_BEFORE] = 0.0, command
        if command != command:
            continue  # NaN: the field stays as it is
        if command > state[_BEFORE]:
            state[_BEHIND] = width + (state[_BEHIND] - width) * exp((state[_BEFORE] - command) / width)
        elif command < state[_BEFORE]:
            state[_BEHIND] = -width + (state[_BEHIND] + width) * exp((command - state[_BEFORE]) / width)
        state[_BEFORE] = command
        kinematics[COMMAND, i] = command - state[_BEHIND]


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
    states=2,
    order=1,
    shows="at the same command the force is higher after higher commands",
    separate="steps of the command up and down to the same value at constant velocity",
    trial=trial,
)
