"""Delays the velocity for the following effects of its path: hysteresis as the time that valves take to open and close.

    v <- v(t - tau)

tau in s, up to 0.2 s; linear between samples. States: a ring of past samples; second order in the step.
Source: HIS paper, eq. (4).
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.effects.delay_line import MAX_DELAY, STATES, delayed
from damper_estimator.signals.layout import DT, V


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """v <- v(t - tau), in this path's copy."""
    for i in range(force.size):
        kinematics[V, i] = delayed(state, kinematics[DT, i], kinematics[V, i], parameters[0])


EFFECT = Effect(
    kernel=kernel,
    kind="input",
    phenomenon="valve_delay",
    tests=("valve",),
    parameters=(Parameter("delay", "s", 0.005, 0.0, MAX_DELAY, "delay of the velocity"),),
    states=STATES,
    order=2,
    shows="the F-v loop opens with frequency at low speed",
    separate="the same peak velocity at two frequencies",
    trial=None,
)
