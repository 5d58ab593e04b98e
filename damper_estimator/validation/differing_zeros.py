"""Zeros of the gauge that differ between recordings of one damper."""

from collections.abc import Iterator, Sequence
from itertools import pairwise, permutations

import numpy as np

from damper_estimator.numbers import number
from damper_estimator.signals import Measurement
from damper_estimator.validation.finding import DataFinding
from damper_estimator.validation.surrogate import Surrogate, surrogate

LEAST_DRIFT = 0.05  # of the force's rms
_OVER_REST = 1.5  # times the rms that the motion does not explain
_CERTAIN = 5.0  # standard errors
_CONFIRMED = 0.5  # of a difference must show at equal speeds
_OTHER_COMMAND = 0.2  # of the range of the recordings' mean commands
_PAIRS = 12  # of recordings whose zeros are compared by a common curve
_SLOWEST, _FAST, _SPEEDS, _LEAST_ROWS = 0.2, 0.95, 6, 20  # equal speeds: of their quantile; bands; samples in each


def zeros_differ(recordings: Sequence[tuple[Measurement, Surrogate]]) -> Iterator[DataFinding]:
    """The two recordings whose forces at standstill differ most clearly, by separate curves, by a common one, and at
    equal speeds.

    Separate curves extrapolate to standstill differently where the excitations differ; a common one mistakes a damper
    that changed in between for a zero. Recordings at other currents are not compared: a static force may follow it.
    """
    commands = [float(np.mean(m.kinematics.command[m.judged])) for m, _ in recordings]
    far = _OTHER_COMMAND * (max(commands, default=0.0) - min(commands, default=0.0))
    apart = []
    for i, k in permutations(range(len(recordings)), 2):
        pair = recordings[i], recordings[k]
        if not abs(commands[i] - commands[k]) > far and (clear := _clearness(*pair)) > 1.0:  # NaN without a command
            apart.append((clear, pair))
    for _, (lower, higher) in sorted(apart, key=lambda item: -item[0])[:_PAIRS]:
        together = surrogate([lower[0], higher[0]])
        change = together.levels[1] - together.levels[0] if together else 0.0
        is_clear = change > _least_change(lower[1], higher[1])
        if is_clear and _at_equal_speeds(lower[0], higher[0]) > _CONFIRMED * change:
            names = [m.recording for m, _ in (lower, higher)]
            yield DataFinding(
                "zero_differs",
                f"the force at standstill is {number(change)} N higher in {names[1]} than in {names[0]}: the gauge's "
                "zero",
                "tare each recording (`damper-estimator tare BAG -o MAP.yaml`) and give each its own map",
                "",
                min(change / max(lower[1].rms_n, higher[1].rms_n), 1.0),
            )
            return


def _at_equal_speeds(one: Measurement, other: Measurement) -> float:
    """By how much the mean of both directions is higher in the other recording at the same speeds, N. A hysteresis
    cancels out in each mean, the asymmetry of the damper in their difference. NaN where no speed is common.
    """
    parts = []
    for m in (one, other):
        parts.append((m.kinematics.velocity[m.judged], m.in_band(m.force)[m.judged]))
    top = min(float(np.quantile(np.abs(v), _FAST)) for v, _ in parts)
    changes = []
    for low, high in pairwise(np.linspace(_SLOWEST * top, top, _SPEEDS + 1)):
        means = []
        for v, force in parts:
            directions = [force[(side * v >= low) & (side * v < high)] for side in (1.0, -1.0)]
            if all(values.size >= _LEAST_ROWS for values in directions):
                means.append(0.5 * sum(float(values.mean()) for values in directions))
        if len(means) == 2:
            changes.append(means[1] - means[0])
    return float(np.mean(changes)) if changes else float("nan")


def _clearness(lower: tuple[Measurement, Surrogate], higher: tuple[Measurement, Surrogate]) -> float:
    """How much higher the second one's force at standstill is, over what would be clear."""
    return (higher[1].levels[0] - lower[1].levels[0]) / _least_change(lower[1], higher[1])


def _least_change(one: Surrogate, other: Surrogate) -> float:
    """N, the difference of two zeros that is clear."""
    return max(
        LEAST_DRIFT * max(one.rms_n, other.rms_n),
        _OVER_REST * max(one.rest_n, other.rest_n),
        _CERTAIN * float(np.hypot(one.level_error, other.level_error)),
    )
