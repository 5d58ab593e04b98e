"""The force of a fluid whose structure breaks down in motion."""

import numpy as np
import pytest
from motions import entry, force, sweep

from damper_estimator.signals.layout import DT, T, V

PLAIN = entry("linear_viscous", rebound=2000.0, compression=1500.0)
FLUID = {"strength": 0.8, "neutral": 0.4, "travel": 0.3, "recovery": 2.0}


def gain(block, **values):
    """(n,) force with the fluid over that without it, where there is any."""
    plain = force(block, PLAIN)
    moving = np.abs(plain) > 1.0
    return block[T][moving], force(block, PLAIN, entry("thixotropy", **(FLUID | values)))[moving] / plain[moving]


def steady(speed, seconds=30.0):
    """Motion at one speed, without regard to its displacement."""
    block = sweep(seconds=seconds, rate=500)
    block[V] = speed
    return block


@pytest.mark.parametrize("speed", [-1.0, -0.05, 0.02, 0.4])
def test_steady_motion_ends_where_breaking_and_growing_balance(speed):
    breaking = abs(speed) / FLUID["travel"]
    broken = breaking / (breaking + 1.0 / FLUID["recovery"])
    _, share = gain(steady(speed))
    assert share[0] == pytest.approx(1.0)
    assert share[-1] == pytest.approx(1.0 + FLUID["strength"] * (FLUID["neutral"] - broken), rel=1e-6)


def test_at_rest_it_grows_within_the_time_of_recovery():
    block = steady(0.5)
    resting = (block[T] > 10.0) & (block[T] < 10.0 + FLUID["recovery"])
    block[V, resting] = 1e-9
    time, share = gain(block)
    fast, after = share[time < 10.0][-1], share[time >= 12.0][0]
    whole = 1.0 + FLUID["strength"] * FLUID["neutral"]
    assert (whole - after) / (whole - fast) == pytest.approx(np.exp(-1.0), rel=0.02)


def test_slow_motion_is_stiffer_than_the_same_motion_after_a_fast_one():
    block = steady(0.05)
    block[V, block[T] > 15.0] = 1.0
    block[V, block[T] > 18.0] = 0.05
    time, share = gain(block)
    before, after, later = (share[np.searchsorted(time, at)] for at in (14.9, 18.1, 29.0))
    assert after < 0.8 * before
    assert later == pytest.approx(before, rel=0.05)


def test_without_strength_it_changes_nothing_and_never_turns_the_force_round():
    block = sweep(amplitude=0.05, frequency=5.0, seconds=5.0)
    assert np.array_equal(force(block, PLAIN, entry("thixotropy", strength=0.0)), force(block, PLAIN))
    _, share = gain(block, strength=3.0, neutral=0.0, travel=1e-3, recovery=60.0)
    assert share.min() == pytest.approx(0.1)


def test_a_reset_starts_where_the_model_holds():
    block = steady(0.4, 4.0)
    block[DT, 1000] = 0.0
    time, share = gain(block)
    assert share[np.searchsorted(time, block[T, 1000])] == pytest.approx(1.0)
