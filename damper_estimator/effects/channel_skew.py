"""Time skew between the measured force and the displacement.

    F_measured(t) = F(t - s) + k (x(t - s) - x(t))

s in s, positive where the force channel is late. A gauge that carries a parallel spring (k in N/m, subtracted as the
signal map states it) shows the spring's force late as well. Linear between samples; offline only; corrected with
``force.skew`` in the signal map. Source: definition of the signal map's force channel.
"""

from collections.abc import Mapping

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Values, number
from damper_estimator.effects.force_gain_error import SPRING_RATE
from damper_estimator.effects.trial import Ranges, Trial
from damper_estimator.signals.layout import T, X


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F <- (F + k x)(t - s) - k x."""
    time, spring = kinematics[T], settings[0] * kinematics[X]
    given = force + spring
    last = force.size - 1
    j = 0
    for i in range(force.size):
        # np.interp would do the same, but takes seconds to compile.
        at = time[i] - parameters[0]
        while j < last and time[j + 1] <= at:
            j += 1
        if at <= time[j] or j == last:
            force[i] = given[j] - spring[i]
        else:
            force[i] = (given[j + 1] - given[j]) / (time[j + 1] - time[j]) * (at - time[j]) + given[j] - spring[i]


def trial(ranges: Ranges) -> Trial:
    """Channels of a logger are out of step by milliseconds."""
    starts = ({"skew": 0.003}, {"skew": -0.003})
    return Trial({"spring_rate": ranges.spring_rate}, {"skew": (-0.03, 0.03)}, starts)


def correct(values: Values, chain: Mapping[str, float]) -> dict[str, float]:
    """Reads the force channel earlier by the skew."""
    return {"skew": chain["skew"] + number(values, "skew")}


EFFECT = Effect(
    kernel=kernel,
    kind="channel",
    phenomenon="channel_skew",
    tests=("shift",),
    parameters=(Parameter("skew", "s", 0.0, -0.05, 0.05, "delay of the force channel"),),
    settings=(SPRING_RATE,),
    shows="the F-v loop opens with frequency, equally at all speeds; the force crosses zero late",
    separate="tap the damper: both channels must show the impact at the same instant",
    trial=trial,
    correct=correct,
)
