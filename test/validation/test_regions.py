"""Where it fails: a planted error is found where it was planted, and noise is no region."""

import numpy as np
import pytest

from damper_estimator.validation import compare


def words(comparison):
    return [region.where for region in comparison.regions]


def plant(where, size=150.0):
    """The model's force plus an error where ``where(kinematics)`` holds."""
    return lambda k: 1500.0 * k.velocity + size * np.sign(k.velocity) * where(k)


def test_a_planted_speed_band_comes_first_in_words(viscous, motion, measured):
    speeds = plant(lambda k: (k.velocity > 0.1) & (k.velocity < 0.2))
    c = compare(viscous, measured(*motion(60.0, rms=0.03), speeds))
    first = c.regions[0]
    assert first.where == "rebound between 0.1 and 0.2 m/s"
    assert first.direction == "rebound" and (first.low, first.high) == pytest.approx((0.1, 0.2))
    assert first.share_of_squared_error > 0.8 and first.share_of_samples < 0.3
    assert "too soft" in first.what and "N too soft" in first.sentence


def test_a_model_that_gives_too_much_is_too_stiff(viscous, motion, measured):
    c = compare(viscous, measured(*motion(), plant(lambda k: k.velocity < -0.05, -150.0)))
    assert "compression" in c.regions[0].where and "too stiff" in c.regions[0].what


@pytest.mark.parametrize(
    ("axis", "where"),
    [
        ("displacement", lambda k: k.displacement > np.quantile(k.displacement, 0.8)),
        ("time", lambda k: k.time > 30.0),
        ("acceleration", lambda k: abs(k.acceleration) > np.quantile(abs(k.acceleration), 0.8)),
        ("temperature", lambda k: k.temperature > 43.0),
        ("command", lambda k: k.command == 1.5),
    ],
)  # fmt: skip
def test_a_planted_error_is_found_on_its_own_axis(axis, where, viscous, motion, measured):
    time, x = motion()
    slow = {"temperature": 40.0 + 5.0 * np.sin(time), "command": np.round(2 * np.mod(time / 7.0, 1.5)) / 2 + 0.5}
    c = compare(viscous, measured(time, x, plant(where), **slow))
    found = [region for region in c.regions if region.axis == axis]
    assert found and found[0].share_of_squared_error > 0.6
    assert found[0].excess >= 0.7 * c.regions[0].excess


def test_an_error_after_reversals_is_distinguished_from_slow_motion(viscous, motion, measured):
    def late(k):
        since = k.time % 0.25
        return 1500.0 * k.velocity + 200.0 * (since < 0.02) * np.sign(k.velocity)

    time = np.arange(20000) / 500.0
    c = compare(viscous, measured(time, -0.01 * np.cos(4 * np.pi * time), late))
    assert any("after a reversal" in where and "first" in where for where in words(c))


def sines(frequencies, speed=0.1, seconds=4.0):
    """Time and displacement of sines one after the other, all of one peak speed, in no order."""
    draw = np.random.default_rng(0)
    chosen = draw.permutation(np.repeat(frequencies, 4))
    time = np.arange(round(seconds * chosen.size * 500)) / 500.0
    frequency = chosen[np.minimum((time / seconds).astype(int), chosen.size - 1)]
    angle = 2 * np.pi * np.cumsum(frequency) / 500.0
    return time, speed * np.cumsum(np.cos(angle)) / 500.0


def test_an_error_of_fast_or_small_motion_is_found_by_frequency_and_amplitude(viscous, measured):
    """At one speed a high frequency and a small amplitude are the same samples: reported once."""
    time, x = sines((1.0, 3.0, 9.0))
    since = np.diff(x, 2, prepend=[0.0, 0.0]) * 250000.0
    fast = np.convolve(np.abs(since) > 2.5, np.ones(100), "same") > 0  # 9 Hz at 0.1 m/s: peaks of 5.7 m/s^2
    c = compare(viscous, measured(time, x, plant(lambda k: fast, 60.0)))
    found = [region for region in c.regions if region.axis in ("frequency", "amplitude")]
    assert len(found) == 1 and found[0].share_of_squared_error > 0.85 and found[0].excess >= 0.8 * c.regions[0].excess
    assert found[0].where in ("motion above 5 Hz", "amplitude below 5 mm", "amplitude below 2 mm")


def test_frequency_is_distinguished_from_speed(viscous, measured):
    """Two speeds at two frequencies: only the fast small motion is wrong."""
    time, slow = sines((1.0, 8.0))
    loud = 0.5 + 0.5 * np.sign(np.sin(2 * np.pi * time / 16.0))
    x = slow * (0.4 + 0.6 * loud)
    high = np.abs(np.gradient(np.gradient(x, time), time))
    at_eight = np.convolve(high > 1.3, np.ones(70), "same") > 0
    c = compare(viscous, measured(time, x, plant(lambda k: at_eight, 60.0)))
    assert c.regions[0].axis in ("frequency", "amplitude", "acceleration")
    assert any(region.axis == "frequency" and region.low >= 1.0 for region in c.regions)


def test_a_region_is_narrowed_down_as_far_as_the_data_support(viscous, motion, measured):
    speeds = plant(lambda k: (k.velocity > 0.05) & (k.displacement > 0.005))
    c = compare(viscous, measured(*motion(60.0), speeds))
    assert len(c.regions) == 1
    first = c.regions[0]
    assert first.where == "rebound above 0.05 m/s, displacement above 4 mm"
    assert first.narrowed[0][0] == "displacement" and first.share_of_squared_error > 0.9
    assert first.share_of_samples < 0.05 and "too soft" in first.what


def test_one_planted_error_is_reported_once(viscous, motion, measured):
    """Whatever else goes with it: speed with acceleration, place with time."""
    for where in (
        lambda k: np.abs(k.velocity) > 0.05,
        lambda k: k.displacement < np.quantile(k.displacement, 0.15),
        lambda k: k.time > 25.0,
    ):
        assert len(compare(viscous, measured(*motion(), plant(where))).regions) == 1


def test_the_gauges_zero_and_drift_leave_the_regions_as_they_are(viscous, motion, measured):
    def offset_too(k):
        return plant(lambda k: (k.velocity > 0.1) & (k.velocity < 0.2))(k) + 60.0 + 0.5 * k.time

    driven = motion(60.0, rms=0.03)
    plain = compare(viscous, measured(*driven, plant(lambda k: (k.velocity > 0.1) & (k.velocity < 0.2)))).regions
    both = compare(viscous, measured(*driven, offset_too))
    assert [r.where for r in both.regions] == [r.where for r in plain]
    assert both.regions[0].share_of_squared_error == pytest.approx(plain[0].share_of_squared_error, abs=0.05)
    assert both.regions[0].bias_n == pytest.approx(plain[0].bias_n + both.split.offset_n, abs=8.0)
    assert both.regions[0].drift_n > 50.0 > plain[0].drift_n == 0.0


def test_an_error_that_goes_with_the_acceleration_says_so(viscous, motion, measured):
    c = compare(viscous, measured(*motion(), lambda k: 1500.0 * k.velocity + 5.0 * k.acceleration))
    assert c.regions[0].axis == "acceleration"
    assert "too low at positive acceleration, too high at negative" in c.regions[0].what


def test_noise_alone_is_no_region(viscous, motion, measured):
    for seed in range(5):
        noise = np.random.default_rng(seed)
        c = compare(
            viscous,
            measured(
                *motion(30.0, seed=seed),
                lambda k, noise=noise: 1500.0 * k.velocity + 30.0 * noise.standard_normal(len(k)),
            ),
        )
        assert words(c) == []


def test_regions_are_worst_first_and_carry_more_error_than_time(viscous, motion, measured):
    c = compare(viscous, measured(*motion(), lambda k: 2500.0 * k.velocity))
    excess = [region.excess for region in c.regions]
    assert excess == sorted(excess, reverse=True) and min(excess) > 0.0


def test_a_regions_numbers_are_those_of_its_samples(viscous, motion, measured):
    c = compare(viscous, measured(*motion(60.0), plant(lambda k: k.velocity > 0.05)))
    region, pool = next(r for r in c.regions if r.axis == "velocity"), c.pool
    residual = pool.residual[(pool.velocity >= region.low) & (pool.velocity < region.high)]
    assert region.rmse_n == pytest.approx(np.sqrt(np.mean(residual**2)), rel=1e-12)
    assert region.bias_n == pytest.approx(residual.mean(), rel=1e-12)
    assert region.share_of_squared_error == pytest.approx(np.sum(residual**2) / np.sum(pool.residual**2), rel=1e-9)
    assert abs(pool.residual[np.argmin(abs(pool.elapsed - region.time))]) == pytest.approx(abs(residual).max())


def test_bands_follow_the_datas_own_range(viscous, motion, measured):
    """The same shape of motion and error, ten times smaller, has bands ten times smaller."""
    large, small = (
        compare(viscous, measured(*motion(60.0, rms=rms), plant(lambda k, v=rms * 5.0: k.velocity > v)))
        for rms in (0.05, 0.005)
    )
    low = [next(r.low for r in c.regions if r.axis == "velocity") for c in (large, small)]
    assert low[0] == pytest.approx(10 * low[1], rel=1e-6)
