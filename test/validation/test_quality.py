"""Data quality: clipping, lateness, noise floor, channel quality, suitability."""

import numpy as np
import pytest

from damper_estimator.signals import low_pass_zero_phase
from damper_estimator.signals.clipping import clipped
from damper_estimator.validation import compare
from damper_estimator.validation.channel_quality import channel_quality
from damper_estimator.validation.suitability import excitation, verdict

TIME = np.arange(5000) / 500.0
SINE = 1000.0 * np.sin(2 * np.pi * TIME)


def test_a_clipped_gauge_is_counted():
    cut = np.clip(SINE, -800.0, 900.0)
    assert np.array_equal(clipped(cut), (cut == -800.0) | (cut == 900.0))


@pytest.mark.parametrize("quantum", [0.0, 1.0, 3.0, 20.0])
def test_a_coarse_gauge_that_does_not_clip_is_not_counted(quantum):
    coarse = np.round(SINE / quantum) * quantum if quantum else SINE
    assert not clipped(coarse).any() and not clipped(np.zeros(10)).any()


@pytest.mark.parametrize("late", [-0.004, -0.001, 0.0, 0.002, 0.005])
def test_the_lateness_of_the_force_is_recovered(late, viscous, motion, measured):
    def of(k):
        return np.interp(k.time - late, k.time, 1500.0 * k.velocity)

    assert compare(viscous, measured(*motion(), of)).data_quality.skew_s == pytest.approx(late, abs=1e-4)


def test_lateness_does_not_depend_on_gain_and_offset(viscous, motion, measured):
    def of(k):
        return 1.7 * np.interp(k.time - 0.003, k.time, 1500.0 * k.velocity) + 90.0

    assert compare(viscous, measured(*motion(), of)).data_quality.skew_s == pytest.approx(0.003, abs=1e-4)


def test_lateness_is_not_reported_where_the_model_explains_too_little(viscous, motion, measured):
    noise = np.random.default_rng(0)
    c = compare(viscous, measured(*motion(), lambda k: 1e5 * k.displacement + 500.0 * noise.standard_normal(len(k))))
    assert np.isnan(c.data_quality.skew_s)


def test_coherence_is_one_for_a_linear_relation_and_small_for_noise(viscous, motion, measured):
    linear = compare(viscous, measured(*motion(), lambda k: 4000.0 * k.velocity)).coherence
    inside = (linear.frequency > 0.5) & (linear.frequency < 10.0)
    assert linear.value[inside] == pytest.approx(1.0, abs=1e-3) and linear.frequency.max() <= 30.0
    noise = np.random.default_rng(0)
    other = compare(viscous, measured(*motion(), lambda k: 500.0 * noise.standard_normal(len(k)))).coherence
    assert np.median(other.value) < 0.3


def test_coherence_is_empty_for_a_short_recording(viscous, motion, measured):
    assert compare(viscous, measured(*motion(0.8), lambda k: 900.0 * k.velocity)).coherence.frequency.size == 0


def test_channel_quality_counts_what_arrived_and_sees_quantum_and_noise():
    stamp = np.round(TIME * 1e9).astype(np.int64)
    stamp[100], stamp[200], stamp[3000:] = stamp[99], stamp[190], stamp[3000:] + 10**9
    value = np.round(SINE / 4.0) * 4.0
    value[50] = np.nan
    q = channel_quality(stamp, value, 0.1)
    assert (q.samples, q.gaps, q.inversions, q.duplicates, q.non_finite) == (5000, 1, 1, 1, 1)
    assert q.rate_hz == pytest.approx(500.0, rel=2e-3) and q.quantum == pytest.approx(4.0)
    still = channel_quality(np.arange(5000) * 2_000_000, np.random.default_rng(0).normal(size=5000), 0.1)
    assert still.noise == pytest.approx(1.0, rel=0.2) and still.quantum == 0.0


def test_a_rounded_clock_does_not_change_the_rate():
    stamp = np.round(np.arange(30000) / 3005.0, 4) * 1e9
    assert channel_quality(stamp.astype(np.int64), np.zeros(30000), 0.1).rate_hz == pytest.approx(3005.0, rel=1e-3)


def judged(measurement, at_rest=True):
    stamp = measurement.kinematics.stamp
    quality = [channel_quality(stamp, value, 0.1) for value in (measurement.raw_displacement, measurement.gauge)]
    return verdict(excitation(measurement), *quality, at_rest)


def test_a_rich_recording_is_good_and_a_poor_one_says_what_to_drive(motion, measured):
    assert judged(measured(*motion(60.0, rms=0.03), lambda k: 1500.0 * k.velocity)).good
    slow = judged(measured(*motion(60.0, rms=0.001), lambda k: 1500.0 * k.velocity))
    assert not slow.good and any("faster" in text for text in slow.drive_next)
    sine = judged(measured(TIME, 0.03 * np.sin(4 * np.pi * TIME), lambda k: 1500.0 * k.velocity), at_rest=False)
    assert any("one frequency" in text for text in sine.remarks) and any(
        "stand still" in text for text in sine.drive_next
    )


def test_a_wrong_sign_is_a_fault(motion, measured):
    assert any("sign" in fault for fault in judged(measured(*motion(), lambda k: -1500.0 * k.velocity)).faults)


def test_in_band_means_zero_phase(viscous, motion, measured):
    m = measured(*motion(5.0), lambda k: 1500.0 * k.velocity)
    assert np.array_equal(m.in_band(m.force), low_pass_zero_phase(30.0, m.kinematics.dt, m.force))
