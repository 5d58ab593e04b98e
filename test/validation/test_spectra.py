"""Partial coherence distinguishes inputs; differentiated and integrated velocity are compared."""

from dataclasses import replace

import numpy as np
import pytest

from damper_estimator.validation.spectra import additive_curves, coherences, partial_coherence
from damper_estimator.validation.velocity import velocity_agreement

RATE = 200.0


def noise(size, seed):
    return np.random.default_rng(seed).standard_normal(size)


def test_an_input_that_only_follows_another_has_no_partial_coherence():
    true = noise(40000, 0)
    follower = true + 0.5 * noise(40000, 1)
    output = 3.0 * true + 0.2 * noise(40000, 2)
    found = coherences(["true", "follower"], [np.stack([output, true, follower])], RATE, 0.0)
    assert np.median(found.partial["true"]) > 0.95
    assert np.median(found.partial["follower"]) < 0.05
    assert np.median(found.ordinary["follower"]) > 0.7
    assert np.median(found.multiple) > 0.98


def test_coherences_do_not_depend_on_units():
    columns = np.stack([noise(20000, 0), noise(20000, 1), noise(20000, 2)])
    columns[0] += columns[1]
    scaled = columns * np.array([[1e3], [1e-6], [4e4]])
    one, other = (coherences(["a", "b"], [c], RATE, 50.0) for c in (columns, scaled))
    assert other.partial["a"] == pytest.approx(one.partial["a"], abs=1e-6)


def test_a_copy_of_another_input_cannot_be_distinguished_from_it():
    one = noise(20000, 0)
    found = coherences(["a", "copy"], [np.stack([one + 0.1 * noise(20000, 1), one, 2.0 * one])], RATE, 0.0)
    assert np.isnan(found.partial["a"]).all() and np.isnan(found.partial["copy"]).all()


def test_a_short_recording_gives_nothing():
    found = coherences(["a"], [np.stack([noise(500, 0), noise(500, 1)])], RATE, 0.0)
    assert found.frequency.size == 0


def test_additive_curves_are_found_together():
    u, w = noise(50000, 0), noise(50000, 1)
    curves = additive_curves({"u": u, "w": w}, 5.0 * np.tanh(2.0 * u) + 3.0 * w**2)
    knots, values = curves["u"]
    inside = np.abs(knots) < 2.0
    assert values[inside] == pytest.approx(5.0 * np.tanh(2.0 * knots[inside]), abs=0.3)


def test_a_damper_with_a_spring_shows_velocity_and_displacement(measured, motion):
    time, x = motion(seconds=60.0)
    both = measured(time, x, lambda k: 800.0 * np.tanh(k.velocity / 0.1) + 15000.0 * k.displacement)
    found = partial_coherence([both])
    low = (found.frequency > 0.5) & (found.frequency < 4.0)  # the spring is small compared with the damper above that
    assert np.nanmedian(found.partial["velocity"][low]) > 0.9
    assert np.nanmedian(found.partial["displacement"][low]) > 0.8
    alone = partial_coherence(
        [measured(time, x, lambda k: 800.0 * np.tanh(k.velocity / 0.1) + 30.0 * noise(time.size, 3))]
    )
    assert np.nanmedian(alone.partial["displacement"][low]) < 0.3
    assert alone.curve_rms_n["displacement"] < 0.02 * alone.curve_rms_n["velocity"]


def with_accelerometer(measured, motion, change):
    time, x = motion(seconds=20.0)
    plain = measured(time, x, lambda k: k.velocity)
    return replace(plain, acceleration=change(plain.kinematics.acceleration))


def test_both_velocities_agree_where_both_are_right(measured, motion):
    found = velocity_agreement(with_accelerometer(measured, motion, lambda a: a))
    assert found.correlation > 0.999
    assert found.gain == pytest.approx(1.0, abs=0.01)
    assert found.relative_difference < 0.02


def test_a_zero_error_of_the_accelerometer_is_not_a_difference(measured, motion):
    found = velocity_agreement(with_accelerometer(measured, motion, lambda a: a + 0.3))
    assert found.relative_difference < 0.05


def test_a_wrong_gain_of_the_accelerometer_is_seen(measured, motion):
    assert velocity_agreement(with_accelerometer(measured, motion, lambda a: 1.1 * a)).gain == pytest.approx(
        1.1, abs=0.01
    )


def test_a_hole_splits_the_comparison(measured, motion):
    def holed(a):
        a = a.copy()
        a[4000:4200] = np.nan
        return a

    found = velocity_agreement(with_accelerometer(measured, motion, holed))
    assert found.relative_difference < 0.02
    assert not found.compared[3900:4300].any()


def test_without_an_accelerometer_there_is_nothing_to_compare(measured, motion):
    time, x = motion(seconds=5.0)
    assert velocity_agreement(measured(time, x, lambda k: k.velocity)) is None
