"""Coulomb friction, smoothed near zero velocity.

    F = F_c tanh(v / v_s)

F_c in N, v in m/s; v_s (m/s) is the width of the transition: a true jump would turn velocity noise into force noise. No
state. Source: Gao et al., eq. (1), with the sign of eq. (2).
"""

from math import tanh

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting
from damper_estimator.effects.trial import Ranges, Trial
from damper_estimator.signals.layout import V


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += F_c tanh(v / v_s)."""
    for i in range(force.size):
        force[i] += parameters[0] * tanh(kinematics[V, i] / settings[0])


def trial(ranges: Ranges) -> Trial:
    """The transition is a small part of the recorded speeds."""
    return Trial({"transition": max(0.005, 0.01 * ranges.speed)}, {"force": (0.0, 2.0 * ranges.force)})


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="friction",
    tests=("friction step",),
    parameters=(Parameter("force", "N", 50.0, 0.0, 10000.0, "friction force", linear=True),),
    settings=(Setting("transition", "m/s", 0.005, "width of the transition through zero velocity", lower=1e-6),),
    shows="an odd step of the force where the velocity changes sign, at every amplitude and frequency",
    separate="a slow triangle (5 mm/s): friction remains, viscous force vanishes",
    trial=trial,
)
