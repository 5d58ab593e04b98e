"""Time skew between the measured force and the displacement.

    F_measured(t) = F(t - s)

s in s, positive where the force channel is late. Linear between samples; offline only; corrected with ``force.skew`` in
the signal map. Source: definition of the signal map's force channel.
"""

from collections.abc import Mapping

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Values, number
from damper_estimator.effects.trial import Ranges, Trial
from damper_estimator.signals.layout import T


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F <- F(t - s)."""
    time, given = kinematics[T], force.copy()
    last = force.size - 1
    j = 0
    for i in range(force.size):
        # np.interp would do the same, but takes seconds to compile.
        at = time[i] - parameters[0]
        while j < last and time[j + 1] <= at:
            j += 1
        if at <= time[j] or j == last:
            force[i] = given[j]
        else:
            force[i] = (given[j + 1] - given[j]) / (time[j + 1] - time[j]) * (at - time[j]) + given[j]


def trial(ranges: Ranges) -> Trial:
    """Channels of a logger are out of step by milliseconds."""
    return Trial(limits={"skew": (-0.03, 0.03)})


def correct(values: Values, chain: Mapping[str, float]) -> dict[str, float]:
    """Reads the force channel earlier by the skew."""
    return {"skew": chain["skew"] + number(values, "skew")}


EFFECT = Effect(
    kernel=kernel,
    kind="channel",
    phenomenon="channel_skew",
    tests=("shift",),
    parameters=(Parameter("skew", "s", 0.0, -0.05, 0.05, "delay of the force channel"),),
    shows="the F-v loop opens with frequency, equally at all speeds; the force crosses zero late",
    separate="tap the damper: both channels must show the impact at the same instant",
    trial=trial,
    correct=correct,
)
