"""First-order lag of the force of the preceding effects.

    tau dF/dt + F = F_in

tau in s. F_in is taken as linear between samples; the lag is exact for it, at any step.
One state pair (last F, last F_in); second order in the step. Source: first-order valve dynamics,
Lozoya-Santos et al., section 2.
"""

from math import exp

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.signals.layout import DT


@compiled
def lagged(came, before, last, lag):
    """What follows a line from ``before`` to ``came``, one sample later, from ``last`` on; the lag is in samples."""
    ramp = (came - before) * lag
    return came - ramp + (last - before + ramp) * exp(-1.0 / lag)


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F <- lag(F)."""
    for i in range(force.size):
        dt = kinematics[DT, i]
        came = force[i]
        if dt > 0.0:
            force[i] = lagged(came, state[1], state[0], parameters[0] / dt)
        state[0] = force[i]
        state[1] = came


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    phenomenon="valve_delay",
    tests=("valve",),
    parameters=(Parameter("time_constant", "s", 0.002, 1e-5, 0.1, "time constant of the lag"),),
    states=2,
    order=2,
    shows="the F-v loop opens with frequency, at all speeds",
    separate="the same peak velocity at two frequencies",
    trial=None,
)
