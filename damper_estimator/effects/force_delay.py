"""Delays the force of the preceding effects.

    F <- F(t - tau)

tau in s, up to 0.2 s; linear between samples. States: a ring of past samples; second order in the step.
Source: HIS paper, eq. (8).
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter
from damper_estimator.effects.delay_line import MAX_DELAY, STATES, delayed
from damper_estimator.signals.layout import DT


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F <- F(t - tau)."""
    for i in range(force.size):
        force[i] = delayed(state, kinematics[DT, i], force[i], parameters[0])


EFFECT = Effect(
    kernel=kernel,
    kind="modifier",
    phenomenon="valve_delay",
    tests=("valve",),
    parameters=(Parameter("delay", "s", 0.005, 0.0, MAX_DELAY, "delay of the force"),),
    states=STATES,
    order=2,
    shows="the F-v loop opens with frequency, at all speeds",
    separate="the same peak velocity at two frequencies",
    trial=None,
)
