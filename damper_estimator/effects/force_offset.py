"""Offset of the strain gauge: a constant added to the measured force.

    F_measured = F + F_0

F_0 in N. Offline only; corrected with ``force.offset`` in the signal map. Source: definition of the signal
map's force channel.
"""

from collections.abc import Mapping

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Values, number


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += F_0."""
    for i in range(force.size):
        force[i] += parameters[0]


def correct(values: Values, chain: Mapping[str, float]) -> dict[str, float]:
    """Subtracts the offset."""
    return {"offset": chain["offset"] - number(values, "offset")}


EFFECT = Effect(
    kernel=kernel,
    kind="channel",
    phenomenon="force_offset",
    parameters=(Parameter("offset", "N", 0.0, -20000.0, 20000.0, "offset of the gauge", linear=True),),
    shows="a constant difference, also at rest",
    separate="tare at rest, with the damper unloaded",
    correct=correct,
)
