"""Friction-like step whose position in velocity shifts with the acceleration: the simplest hysteresis of an MR damper.

    F = F_y tanh(s (v + h a))

F_y in N (yield force), s in s/m (steepness), h in s (shift). No state. Source: the hysteresis term common to
the Kwok and Guo forms (Lozoya-Santos et al., eqs. (1), (2)), here over velocity and acceleration.
"""

from math import tanh

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Values, number
from damper_estimator.effects.trial import Ranges, Trial, spread
from damper_estimator.signals.layout import A, V

_LEAST_OPEN = 0.5  # of the step's width: how far the largest acceleration shifts it


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += F_y tanh(s (v + h a))."""
    for i in range(force.size):
        force[i] += parameters[0] * tanh(parameters[1] * (kinematics[V, i] + parameters[2] * kinematics[A, i]))


def trial(ranges: Ranges) -> Trial:
    """The step is narrower than the range of the recorded speeds."""
    steep = 1.0 / ranges.speed
    limits = {"steepness": (1.5 * steep, 100.0 * steep), "shift": (-0.03, 0.03)}
    values = {"steepness": 10.0 * steep, "shift": 0.003}
    starts = spread(steepness=(4.0 * steep, 30.0 * steep), shift=(-0.005, 0.01))

    def exclusion(values: Values) -> str:
        opened = abs(number(values, "shift")) * ranges.acceleration * number(values, "steepness")
        return "its loop is closed: a step of friction" if opened < _LEAST_OPEN else ""

    return Trial(values, limits, starts, exclusion, imitates="friction step")


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="hysteresis",
    parameters=(
        Parameter("force", "N", 300.0, 0.0, 10000.0, "yield force", linear=True),
        Parameter("steepness", "s/m", 30.0, 0.1, 5000.0, "steepness through zero velocity"),
        Parameter("shift", "s", 0.0, -0.05, 0.05, "shift of the step per acceleration"),
    ),
    shows="the F-v loop is open near zero velocity and closes at high velocity",
    separate="the same peak velocity at two frequencies: a lag grows with frequency, memory of displacement does not",
    trial=trial,
    general=True,
)
