"""Spring force that was not, or not correctly, subtracted from the gauge's force.

    F_measured = F + k x

k in N/m, x in m. Offline only; corrected with ``force.spring_rate`` in the signal map. Source: definition of
the signal map's force channel.
"""

from collections.abc import Mapping

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Values, number
from damper_estimator.effects.trial import Ranges, Trial
from damper_estimator.signals.layout import X

_UNSTATED = 0.25  # beside other explanations


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += k x."""
    for i in range(force.size):
        force[i] += parameters[0] * kinematics[X, i]


def correct(values: Values, chain: Mapping[str, float]) -> dict[str, float]:
    """Adds the error to the subtracted spring rate."""
    return {"spring_rate": chain["spring_rate"] + number(values, "rate")}


def trial(ranges: Ranges) -> Trial:
    """A gauge that carries a spring nearly always has it in the signal map. Without one there, a straight line over
    displacement is more likely the damper's gas, unless that was identified.
    """
    stated = ranges.spring_rate or "gas_spring" in ranges.identified
    return Trial(prior=1.0 if stated else _UNSTATED)


EFFECT = Effect(
    kernel=kernel,
    kind="channel",
    phenomenon="spring_rate_error",
    tests=("spring",),
    parameters=(Parameter("rate", "N/m", 0.0, -200000.0, 200000.0, "error of the spring rate", linear=True),),
    shows="a straight line over displacement, at any velocity",
    separate="a slow stroke without the spring, or with a known one",
    trial=trial,
    correct=correct,
)
