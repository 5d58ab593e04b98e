"""Displacement and accelerometer together: a Kalman filter, its motion, and its reaction if one is missing."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from damper_estimator.signals import Differentiator, Fusion
from damper_estimator.signals.fusion import FUSION_SIZE, OFFSET, PLACE, SPEED, VV, XX, fuse
from damper_estimator.signals.layout import A, V, X

STEP = 0.001
FUSION = Fusion(2e-5, 0.3, 0.01)


def sensed(size: int, seed: int, offset: float = 0.0):
    """Stamps (n,), true motion (3, n), and the sensors' values (n,) each."""
    random = np.random.default_rng(seed)
    time = STEP * np.arange(size)
    x = 0.01 * np.sin(9.0 * time) + 0.002 * np.sin(80.0 * time)
    v = 0.09 * np.cos(9.0 * time) + 0.16 * np.cos(80.0 * time)
    a = -0.81 * np.sin(9.0 * time) - 12.8 * np.sin(80.0 * time)
    displacement = x + 2e-5 * random.standard_normal(size)
    felt = a + offset + 0.3 * random.standard_normal(size)
    return np.round(1e9 * time).astype(np.int64), np.array([x, v, a]), displacement, felt


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def test_the_velocity_has_no_delay_of_the_low_pass():
    stamp, truth, displacement, felt = sensed(4000, 1, offset=0.4)
    fused = Differentiator(60.0, 0.1, FUSION).block(stamp, displacement, acceleration=felt)[0].block
    late = Differentiator(60.0, 0.1).block(stamp, displacement)[0].block
    part = slice(1000, None)
    errors = [rms((block[V] - truth[1])[part]) / rms(truth[1][part]) for block in (fused, late)]
    assert errors[0] < 0.05 and errors[0] < 0.2 * errors[1]
    assert rms((fused[X] - truth[0])[part]) < 2e-5
    assert abs(np.mean((fused[A] - truth[2])[part])) < 0.1  # the offset of 0.4 is found


def test_it_is_the_kalman_filter_of_the_textbook():
    chosen = np.cumsum(np.random.default_rng(3).choice([1, 3], 300))  # uneven steps
    stamp, _, displacement, felt = (values[..., chosen] for values in sensed(900, 2))
    state, out, alone = np.zeros(FUSION_SIZE), np.zeros((3, 1)), np.zeros(1, np.uint8)
    mean, spread, before = np.zeros(3), np.zeros((3, 3)), 0.0
    for i, dt in enumerate(np.diff(stamp, prepend=stamp[0]) / 1e9):
        sample = np.array([dt]), displacement[i : i + 1], felt[i : i + 1]
        fuse(FUSION.noises(), *sample, state, out[0], out[1], out[2], alone)
        if i == 0:
            mean, spread = np.array([displacement[0], 0.0, 0.0]), np.diag([2e-5**2, 0.1**2, 1.0])
        else:
            move = np.array([[1.0, dt, -0.5 * dt * dt], [0.0, 1.0, -dt], [0.0, 0.0, 1.0]])
            entry = np.array([0.5 * dt * dt, dt, 0.0])
            mean = move @ mean + entry * 0.5 * (before + felt[i])
            spread = move @ spread @ move.T + np.outer(entry, entry) * 0.3**2 + np.diag([0.0, 0.0, 0.01**2 * dt])
            gain = spread[0] / (spread[0, 0] + 2e-5**2)
            mean = mean + gain * (displacement[i] - mean[0])
            spread = spread - np.outer(gain, spread[0])
        before = felt[i]
        assert state[[PLACE, SPEED, OFFSET]] == pytest.approx(mean, rel=1e-6, abs=1e-9)
        assert (state[XX], state[VV]) == pytest.approx((spread[0, 0], spread[1, 1]), rel=1e-5)


@given(st.integers(0, 99), st.lists(st.integers(1, 299), max_size=4))
@settings(max_examples=20, deadline=None)
def test_blocks_of_any_size_give_the_same_bits(seed, cuts):
    stamp, _, displacement, felt = sensed(300, seed)
    felt[100:120] = np.nan
    stamp[200:] += 10**9  # a gap
    whole = Differentiator(60.0, 0.1, FUSION).block(stamp, displacement, acceleration=felt)[0].block
    parts, differentiator = [], Differentiator(60.0, 0.1, FUSION)
    for first, end in zip([0, *sorted(cuts)], [*sorted(cuts), 300], strict=True):
        part = slice(first, end)
        parts.append(differentiator.block(stamp[part], displacement[part], acceleration=felt[part])[0].block)
    assert np.array_equal(np.concatenate(parts, axis=1), whole, equal_nan=True)


def test_without_an_acceleration_the_motion_is_that_of_the_low_pass():
    stamp, _, displacement, felt = sensed(600, 4)
    felt[200:400] = np.nan
    differentiator = Differentiator(60.0, 0.1, FUSION)
    fused = differentiator.block(stamp, displacement, acceleration=felt)[0].block
    late = Differentiator(60.0, 0.1).block(stamp, displacement)[0].block
    assert np.array_equal(fused[:, 200:400], late[:, 200:400], equal_nan=True)
    assert differentiator.alone.tolist() == [0] * 200 + [1] * 200 + [0] * 200
    assert np.isfinite(fused[[X, V, A]]).all() and rms(fused[V, 450:] - late[V, 450:]) > 0.01


@pytest.mark.parametrize("value", [np.inf, -np.inf, 1e300, 3000.0, -800.0])
def test_an_outlier_of_the_accelerometer_is_reported_and_forgotten(value):
    stamp, truth, displacement, felt = sensed(1200, 5)
    felt[600] = value
    differentiator = Differentiator(60.0, 0.1, FUSION)
    block = differentiator.block(stamp, displacement, acceleration=felt)[0].block
    assert np.isfinite(block[[X, V, A]]).all()
    alone_at = np.flatnonzero(differentiator.alone)
    assert 600 <= alone_at[0] <= 605 and alone_at[-1] < 620
    assert rms((block[V] - truth[1])[900:]) < 0.1 * rms(truth[1])


def test_a_jump_of_the_displacement_is_reported_and_forgotten():
    stamp, truth, displacement, felt = sensed(1200, 6)
    displacement[600] += 0.1
    differentiator = Differentiator(60.0, 0.1, FUSION)
    block = differentiator.block(stamp, displacement, acceleration=felt)[0].block
    assert np.flatnonzero(differentiator.alone)[0] == 600
    assert rms((block[V] - truth[1])[900:]) < 0.1 * rms(truth[1])
