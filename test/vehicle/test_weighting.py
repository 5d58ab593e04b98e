"""Wk against the values of the standards."""

import numpy as np
import pytest

from damper_estimator.vehicle import wk_gain, wk_weighted

# ISO 2631-1:1997, table 3: factors in thousandths at the centres of third octaves.
TABLE = {
    0.5: 418, 0.63: 459, 0.8: 477, 1.0: 482, 1.25: 484, 1.6: 494, 2.0: 531, 2.5: 631, 3.15: 804, 4.0: 967, 5.0: 1039,
    6.3: 1054, 8.0: 1036, 10.0: 988, 12.5: 902, 16.0: 768, 20.0: 636, 25.0: 513, 31.5: 405, 40.0: 314, 50.0: 246,
    63.0: 186, 80.0: 132,
}  # fmt: skip


@pytest.mark.parametrize("frequency", TABLE)
def test_the_gain_is_that_of_the_standards_table(frequency: float) -> None:
    assert wk_gain(np.array([frequency]))[0] == pytest.approx(1e-3 * TABLE[frequency], rel=0.004)


def test_the_gain_at_the_reference_frequency_of_iso_8041() -> None:
    assert wk_gain(np.array([100.0 / (2.0 * np.pi)]))[0] == pytest.approx(0.7718, abs=5e-5)


@pytest.mark.parametrize("frequency", [0.6, 1.0, 5.0, 20.0, 60.0])
@pytest.mark.parametrize("step", [1e-3, 1e-4])
def test_a_weighted_sine_has_the_gain_of_its_frequency(frequency: float, step: float) -> None:
    time = np.arange(0.0, 30.0, step)
    late = time > 15.0
    weighted = wk_weighted(np.sin(2.0 * np.pi * frequency * time), step)[late]
    gain = np.sqrt(2.0 * np.mean(weighted**2))
    # At 1 kHz the bilinear transform bends 60 Hz by one percent.
    assert gain == pytest.approx(wk_gain(np.array([frequency]))[0], rel=0.02 if frequency > 30.0 else 0.003)


def test_too_slow_sampling_is_refused() -> None:
    with pytest.raises(ValueError, match="100 samples per second are too few"):
        wk_weighted(np.zeros(100), 0.01)
