"""Gain error of the strain gauge that drifts during a recording.

    F_measured = (1 + g + d (s(t) - 1/2)) (F + k x + P) - k x - P,      s(t) = (1 - e^(-t / tau)) / (1 - e^(-T / tau))

g without unit is the error half-way of the drift, d what it changes by in T (s, setting), tau in s how fast it settles,
t in s since the recording began; the spring (k in N/m, P in N) as in ``force_gain_error``. A supply that sinks, or a
bridge that warms up. Offline only; ``force.scale`` in the signal map corrects g, the drift is cured at the amplifier.
No state. Source: definition of the signal map's force channel; first-order settling.
"""

from math import expm1

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting
from damper_estimator.effects.force_gain_error import PRELOAD, SPRING_RATE, correct
from damper_estimator.effects.slow_channels import keeps_its_temperature
from damper_estimator.effects.trial import Ranges, Trial, Untestable
from damper_estimator.signals.layout import T, X

_FASTEST = 5.0  # s, of an amplifier or a supply that settles; what changes faster is not the gauge
_MOST = 0.5  # of the gain, within a recording
_UNSEEN = 0.1  # prior without a thermometer: dampers warm up more often than amplifiers
_WARMER = 0.03  # prior where a thermometer shows that the damper did


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += (g + d (s(t) - 1/2)) (F + k x + P)."""
    whole = expm1(-settings[2] / parameters[2])
    for i in range(force.size):
        time = min(max(kinematics[T, i], 0.0), settings[2])
        share = expm1(-time / parameters[2]) / whole - 0.5
        carried = force[i] + settings[0] * kinematics[X, i] + settings[1]
        force[i] += (parameters[0] + parameters[1] * share) * carried


def trial(ranges: Ranges) -> Trial:
    """The temperature of the damper explains a force that fades as well, unless a thermometer shows none."""
    if ranges.seconds < 2.0 * _FASTEST:
        raise Untestable("the gain of a gauge drifts over longer than these recordings last")
    prior = _UNSEEN if ranges.temperature is None else _WARMER
    values = {"spring_rate": ranges.spring_rate, "preload": ranges.preload, "seconds": ranges.seconds}
    settling = (max(_FASTEST, 0.1 * ranges.seconds), 10.0 * ranges.seconds)
    limits = {"settling": settling, "drift": (-_MOST, _MOST)}
    return Trial(values, limits, prior=1.0 if keeps_its_temperature(ranges) else prior)


EFFECT = Effect(
    kernel=kernel,
    kind="channel",
    phenomenon="force_gain_error",
    parameters=(
        Parameter("gain", "1", 0.0, -0.9, 2.0, "relative error of the gauge's gain half-way of the drift"),
        Parameter("drift", "1", 0.0, -1.5, 1.5, "change of that error"),
        Parameter("settling", "s", 100.0, 0.1, 1e5, "time constant of the change"),
    ),
    settings=(
        SPRING_RATE,
        PRELOAD,
        Setting("seconds", "s", 60.0, "time in which it changes", lower=1.0),
    ),
    shows="the error is a share of the force that grows or falls with time, whatever the damper does",
    separate="a known weight on the gauge at the beginning and at the end",
    trial=trial,
    correct=correct,
)
