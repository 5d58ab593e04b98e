"""A gauge that carries a coil spring as well errs on the whole force: on the spring's, and on its preload."""

from dataclasses import replace

import numpy as np
import pytest

from damper_estimator.diagnosis import diagnose
from damper_estimator.diagnosis.diagnosis_data import ranges_of

SPRING, PRELOAD = 25e3, -1500.0  # N/m, N


def carried(measurement, gain: float, late: float):
    """The measurement as such a gauge gives it, with the stated spring subtracted again."""
    time, x = measurement.kinematics.time, measurement.kinematics.displacement
    whole = measurement.force + SPRING * x + PRELOAD
    force = (1.0 + gain) * np.interp(time - late, time, whole) - SPRING * x - PRELOAD
    signals = replace(measurement.signals, spring_rate=SPRING, preload=PRELOAD)
    return replace(measurement, force=force, signals=signals, recording=f"{measurement.recording} again")


def test_the_spring_of_the_map_is_that_of_the_gauge(base):
    ranges = ranges_of([carried(base, 0.0, 0.0)])
    assert (ranges.spring_rate, ranges.preload) == (SPRING, PRELOAD)


@pytest.mark.parametrize(("phenomenon", "gain", "late", "parameter", "tolerance"), [
    ("force_gain_error", -0.06, 0.0, "gain", 0.01),
    ("channel_skew", 0.0, 0.005, "skew", 3e-4),
])  # fmt: skip
def test_the_gauge_is_blamed_for_what_it_makes_of_the_spring_too(
    base, user_model, phenomenon, gain, late, parameter, tolerance
):
    found = diagnose(user_model, [carried(base, gain, late)])
    first = found.findings[0]
    assert first.phenomenon == phenomenon
    (value,) = (p.value for p in first.parameters if p.name.endswith(parameter))
    assert value == pytest.approx(gain or late, abs=tolerance)
    assert [one.phenomenon for one in found.findings] == [phenomenon]
