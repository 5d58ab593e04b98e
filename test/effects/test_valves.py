"""Valves that open or close late, stick or open above their old preload, and the friction of a guide."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from motions import entry, force, sweep

from damper_estimator.effects.discovery import find_effect
from damper_estimator.effects.trial import Ranges
from damper_estimator.signals.layout import DT, ROWS, T, V, X

PLAIN = entry("linear_viscous", rebound=2000.0, compression=2000.0)
LATE = {"overshoot": 1.2, "opening": 150.0, "time_constant": 0.004}
OPEN = {"passage": 3.0, "time_constant": 0.01}
STUCK = {"extra": 0.5, "lifting": 300.0, "time_constant": 0.002}
RAISED = {
    "raised_rebound": 300.0, "opening_rebound": 0.15, "raised_compression": 120.0, "opening_compression": 0.25,
    "width": 0.04,
}  # fmt: skip


def change(name, block, **values):
    """(n,) N by which an effect changes the force of a plain damper."""
    return force(block, PLAIN, entry(name, **values)) - force(block, PLAIN)


EACH = pytest.mark.parametrize(
    ("name", "values"), [("valve_lag", LATE), ("sticking_valve", STUCK), ("late_check", OPEN)]
)


@EACH
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_valve_of_one_direction_leaves_the_other_one_alone(name, values, side):
    block = sweep()
    found = change(name, block, **values, side=side)
    there = side * block[V] > 0.0
    assert np.abs(found[there]).max() > 20.0
    settled = ~there & (np.abs(block[V]) > 0.1)
    assert np.abs(found[settled]).max() < 0.05 * np.abs(found[there]).max()


@EACH
def test_valves_of_both_directions_act_alike(name, values):
    block, mirrored = sweep(), sweep()
    mirrored[[X, V]] *= -1.0
    np.testing.assert_allclose(change(name, mirrored, **values), -change(name, block, **values), atol=1e-9)


def test_a_valve_that_closes_at_once_only_has_too_much_force():
    block = sweep(frequency=4.0, rate=4000)
    alike, fast = (change("valve_lag", block, **LATE, closing=closing) for closing in (1.0, 0.02))
    force_without = force(block, PLAIN)
    rising = force_without * np.gradient(force_without) > 0.0
    later = block[T] > 0.25
    lacks = [np.max(-found * np.sign(force_without), where=later & ~rising, initial=0.0) for found in (fast, alike)]
    assert lacks[0] < 0.1 * lacks[1]
    np.testing.assert_allclose(fast[later & rising].max(), alike[later & rising].max(), rtol=0.1)


def test_a_stuck_valve_gives_a_fixed_share_more_until_it_lifts_and_sticks_again_after_the_reversal():
    block = sweep(frequency=1.0, seconds=2.0, rate=2000)
    plain, found = force(block, PLAIN), change("sticking_valve", block, **STUCK)
    low = sweep(amplitude=0.01, frequency=1.0, seconds=2.0)
    assert change("sticking_valve", low, **STUCK) == pytest.approx(0.5 * force(low, PLAIN)), "never lifts"
    for begin in (0.0, 1.0):  # rising rebound of both cycles begins at the lower reversal
        rising = (block[T] > begin + 0.76) & (block[T] < begin + 1.0)
        stuck = rising & (1.5 * np.abs(plain) < 0.95 * STUCK["lifting"]) & (np.abs(plain) > 20.0)
        lifted = rising & (np.abs(plain) > 1.2 * STUCK["lifting"])
        assert found[stuck] == pytest.approx(0.5 * plain[stuck], rel=0.02)
        assert np.abs(found[lifted]).max() < 1.0
    falling = (block[T] > 1.05) & (block[T] < 1.2) & (np.abs(plain) < STUCK["lifting"])
    assert np.abs(found[falling]).max(initial=0.0) < 1.0, "stays open while the force falls"


def triangle(half: float, rate: float = 10000.0, speed: float = 0.2) -> np.ndarray:
    """(8, n) four strokes of ``half`` seconds each at a constant speed in m/s, the first one in rebound."""
    each = round(half * rate)
    block = np.zeros((ROWS, 4 * each))
    block[T] = np.arange(4 * each) / rate
    block[DT, 1:] = 1.0 / rate
    block[V] = np.repeat([speed, -speed, speed, -speed], each)
    block[X, 1:] = np.cumsum(block[V, 1:]) / rate
    return block


@given(passage=st.floats(0.1, 20.0), late=st.floats(0.002, 0.02))
def test_behind_a_check_valve_that_closes_late_two_passages_share_the_flow_until_it_is_shut(passage, late):
    block = triangle(0.4)
    found = force(block, PLAIN, entry("late_check", passage=passage, time_constant=late))
    plain = force(block, PLAIN)
    first, *later = np.split(found / plain, 4)
    assert first == pytest.approx(1.0), "at the start no valve is open"
    lift = np.exp(-np.arange(1, first.size + 1) / (10000.0 * late))
    for share in later:
        assert share == pytest.approx((1.0 + passage * lift) ** -2, rel=1e-6)


def test_what_a_late_check_valve_lacks_grows_with_the_number_of_reversals():
    lacking = [
        np.abs(change("late_check", triangle(half), **OPEN)).sum() / np.abs(force(triangle(half), PLAIN)).sum()
        for half in (0.05, 0.2, 0.8)
    ]
    assert lacking[0] > 2.0 * lacking[1] > 4.0 * lacking[2] > 0.0


def test_a_valve_with_more_preload_adds_no_more_than_that_and_nothing_before_it_opened():
    block = sweep(amplitude=0.06)
    found = force(block, entry("late_relief", **RAISED))
    v = block[V]
    assert not found[(v < 0.15) & (v > -0.25)].any()
    assert (found * v >= 0.0).all()
    assert found[v > 0.5] == pytest.approx(300.0, rel=1e-3)
    assert found[v < -0.6] == pytest.approx(-120.0, rel=1e-3)
    assert (np.diff(found[np.argsort(v)]) >= -1e-9).all()


def test_friction_of_a_guide_is_seal_friction_where_it_is_alike_over_the_stroke():
    block = sweep()
    alike = dict.fromkeys(("compressed", "middle", "extended"), 40.0)
    expected = force(block, entry("seal_friction", rebound=40.0, compression=40.0))
    assert force(block, entry("guide_friction", **alike)) == pytest.approx(expected)


def test_friction_of_a_guide_follows_the_position_and_never_drives():
    block = sweep()
    found = force(
        block, entry("guide_friction", compressed=90.0, middle=30.0, extended=50.0, compressed_end=-0.02,
                     extended_end=0.03)
    )  # fmt: skip
    sliding = np.abs(block[V]) > 0.02
    expected = np.interp(block[X], [-0.02, 0.005, 0.03], [90.0, 30.0, 50.0])
    assert np.abs(found[sliding]) == pytest.approx(expected[sliding])
    assert (found * block[V] >= 0.0).all()


RANGES = Ranges(compression=-0.03, extension=0.03, speed=1.0, acceleration=40.0, force=500.0, seconds=60.0)


@pytest.mark.parametrize(
    ("name", "itself", "other", "reason"),
    [
        ("late_relief", RAISED | {"opening_rebound": 0.4}, {"opening_rebound": 0.12, "opening_compression": 0.2},
         "whole curve"),
        ("valve_lag", LATE | {"closing": 1.0, "side": 0.0, "opening": 400.0}, {"opening": 150.0}, "a mass"),
        ("thixotropy", {"travel": 0.3, "recovery": 2.0}, {"travel": 0.004, "recovery": 0.3}, "a curve"),
        ("thixotropy", {"travel": 0.3, "recovery": 2.0}, {"travel": 30.0, "recovery": 2.0}, "a gain"),
    ],
)  # fmt: skip
def test_values_of_another_effect_are_excluded(name, itself, other, reason):
    tried = find_effect(name).trial(RANGES)
    assert not tried.exclusion(itself)
    assert reason in tried.exclusion(itself | other)


def test_a_valve_of_one_side_or_that_closes_otherwise_than_it_opens_is_no_mass():
    tried = find_effect("valve_lag").trial(RANGES)
    mass = LATE | {"closing": 1.0, "side": 0.0}
    for different in ({"side": 1.0}, {"side": -1.0}, {"closing": 0.2}, {"closing": 3.0}):
        assert not tried.exclusion(mass | different)


@given(friction=st.floats(1.0, 150.0), slower=st.sampled_from([0.1, 0.25, 0.5]))
def test_a_valve_that_rubs_opens_the_same_loop_however_slowly_the_force_moves(friction, slower):
    """The force of a linear damper at the same velocities, but at another rate: more while it rises than while it
    falls, by at most twice the friction.
    """
    valve = entry("valve_friction", friction=friction, steeper=5.0, opening=50.0)
    viscous = entry("viscous", rate=2000.0)
    fast = sweep(amplitude=0.03, frequency=4.0, rate=2000)
    slow = sweep(amplitude=0.03 / slower, frequency=4.0 * slower, seconds=1.0 / slower, rate=round(2000 * slower))
    changes = [force(block, viscous, valve) - 2000.0 * block[V] for block in (fast, slow)]
    assert changes[0] == pytest.approx(changes[1], abs=1e-6 * friction)
    assert np.abs(changes[0]).max() <= friction
    later = slice(1000, None)
    rising = np.gradient(np.abs(fast[V]))[later] > 0.0
    at = (np.abs(fast[V][later]) > 0.3) & (np.abs(fast[V][later]) < 0.5)
    outward = (np.sign(fast[V]) * changes[0])[later]
    assert outward[at & rising].min() > 0.0 > outward[at & ~rising].max()


def test_a_relaxing_spring_is_a_spring_then_a_damper_and_decays_with_its_time_constant():
    spring = entry("relaxing_spring", stiffness=2e4, relaxation=0.2)
    fast, slow = sweep(frequency=40.0, rate=8000), sweep(frequency=0.02, seconds=100.0, rate=100)
    # Without its start: it was not loaded then.
    assert force(fast, spring)[4000:] == pytest.approx(2e4 * fast[X][4000:], abs=0.04 * 2e4 * 0.03)
    assert force(slow, spring)[500:] == pytest.approx(4e3 * slow[V][500:], abs=0.04 * 4e3 * np.abs(slow[V]).max())
    block = sweep(seconds=2.0)
    block[V, 500:] = 0.0
    held = force(block, spring)[510:]
    assert held[200] / held[0] == pytest.approx(np.exp(-1.0), rel=1e-3)
