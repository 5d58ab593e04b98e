"""Gain error of the strain gauge.

    F_measured = (1 + g) F

g without unit. Offline only; corrected with ``force.scale`` in the signal map. Source: definition of the
signal map's force channel.
"""

from collections.abc import Mapping

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Values, number


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F *= 1 + g."""
    for i in range(force.size):
        force[i] *= 1.0 + parameters[0]


def correct(values: Values, chain: Mapping[str, float]) -> dict[str, float]:
    """Divides the gauge's reading by its gain."""
    return {name: chain[name] / (1.0 + number(values, "gain")) for name in ("scale", "offset")}


EFFECT = Effect(
    kernel=kernel,
    kind="channel",
    phenomenon="force_gain_error",
    parameters=(Parameter("gain", "1", 0.0, -0.9, 2.0, "relative error of the gauge's gain"),),
    shows="the error is a fixed share of the force in all conditions",
    separate="a known weight on the gauge",
    correct=correct,
)
