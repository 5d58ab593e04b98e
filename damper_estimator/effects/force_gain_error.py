"""Gain error of the strain gauge.

    F_measured = (1 + g) (F + k x + P) - k x - P

g without unit. A gauge that carries a parallel spring (k in N/m, P in N at x = 0, both subtracted as the signal map
states them) errs on the spring's force as well. Offline only; corrected with ``force.scale`` in the signal map. Source:
definition of the signal map's force channel.
"""

from collections.abc import Mapping

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting, Values, number
from damper_estimator.effects.trial import Ranges, Trial
from damper_estimator.signals.layout import X

SPRING_RATE = Setting("spring_rate", "N/m", 0.0, "of a spring in the gauge's force, by the signal map", adds=True)
PRELOAD = Setting("preload", "N", 0.0, "of that spring at displacement 0", adds=True)


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += g (F + k x + P)."""
    for i in range(force.size):
        force[i] += parameters[0] * (force[i] + settings[0] * kinematics[X, i] + settings[1])


def correct(values: Values, chain: Mapping[str, float]) -> dict[str, float]:
    """Divides the gauge's reading by its gain."""
    return {name: chain[name] / (1.0 + number(values, "gain")) for name in ("scale", "offset")}


def trial(ranges: Ranges) -> Trial:
    """The gauge carries the spring that the signal map states."""
    return Trial({"spring_rate": ranges.spring_rate, "preload": ranges.preload})


EFFECT = Effect(
    kernel=kernel,
    kind="channel",
    phenomenon="force_gain_error",
    parameters=(Parameter("gain", "1", 0.0, -0.9, 2.0, "relative error of the gauge's gain"),),
    settings=(SPRING_RATE, PRELOAD),
    shows="the error is a fixed share of the force in all conditions",
    separate="a known weight on the gauge",
    trial=trial,
    correct=correct,
)
