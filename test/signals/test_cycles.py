"""Cycles by reversals, and groups of them by velocity and frequency."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from damper_estimator.compiled import plain
from damper_estimator.signals.cycles import Cycle, find_cycles, turning_points
from damper_estimator.signals.grouping import GroupLimits, group_limits
from damper_estimator.signals.kinematics import Differentiator


def kinematics_of(time, displacement):
    return Differentiator(60.0, 0.1).block(np.round(1e9 * time).astype(np.int64), displacement)[0]


def sine_series(*blocks, rate=500.0):
    """Sines of (Hz, m, cycles) one after another, each between two upper reversals."""
    parts = [a * np.cos(2 * np.pi * f * np.arange(round(n / f * rate)) / rate) - a for f, a, n in blocks]
    x = np.concatenate(parts)
    return np.arange(x.size) / rate, x


def cycle(peak_velocity, frequency):
    return Cycle(0, 10, 0.0, 1.0 / frequency, 0.01, 0.0, peak_velocity, 0.0)


def test_a_sine_has_its_frequency_amplitude_and_peak_velocity():
    time, x = sine_series((2.0, 0.02, 12))
    found = find_cycles(kinematics_of(time, x))[1:]
    assert len(found) >= 9
    for cycle in found:
        assert cycle.frequency == pytest.approx(2.0, rel=1e-3)
        assert cycle.amplitude == pytest.approx(0.02, rel=2e-3)
        assert cycle.peak_velocity == pytest.approx(0.02 * 4.0 * np.pi, rel=2e-3)
        assert cycle.departure < 0.01


def test_noise_at_the_reversals_makes_no_cycles():
    time, x = sine_series((1.0, 0.02, 10))
    noisy = x + 2e-5 * np.random.default_rng(0).standard_normal(x.size)
    assert len(find_cycles(kinematics_of(time, noisy))) == len(find_cycles(kinematics_of(time, x)))


def test_cycles_follow_one_another_without_gaps():
    time, x = sine_series((1.0, 0.02, 5), (4.0, 0.01, 10))
    found = find_cycles(kinematics_of(time, x))
    assert all(a.end == b.start for a, b in zip(found, found[1:], strict=False))


def test_a_cycle_never_spans_a_gap():
    time, x = sine_series((2.0, 0.02, 10))
    late = np.where(time > 2.3, time + 1.0, time)
    kinematics = kinematics_of(late, x)
    gap = kinematics.stretches()[1].start
    assert not any(cycle.first < gap < cycle.last for cycle in find_cycles(kinematics))


def test_a_triangle_is_no_sine():
    time = np.arange(5000) / 500.0
    x = 0.02 * (4.0 * np.abs(np.mod(time, 1.0) - 0.5) - 1.0)
    assert all(cycle.departure > 0.08 for cycle in find_cycles(kinematics_of(time, x))[1:])


def test_rest_has_no_cycles():
    time = np.arange(2000) / 500.0
    assert find_cycles(kinematics_of(time, np.zeros(time.size))) == []


@settings(deadline=None, max_examples=50)
@given(st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=60), st.floats(0.05, 0.5))
def test_turning_points_alternate_and_move_by_the_least_stroke(values, least):
    x = np.array(values)
    found = np.zeros(x.size, np.int64)
    count = turning_points(x, least, found)
    again = np.zeros(x.size, np.int64)
    assert count == plain(turning_points)(x, least, again)
    assert (found == again).all()
    steps = np.diff(x[found[:count]])
    assert (np.abs(steps) >= least).all()
    assert (np.sign(steps[1:]) == -np.sign(steps[:-1])).all()


def test_groups_are_those_of_the_papers_table():
    low = [cycle(v, 1.5) for v in (0.1, 0.15, 0.2, 0.25, 0.3, 0.4)]
    high = [cycle(v, 12.0) for v in (0.1, 0.2, 0.3, 0.5, 0.7, 0.9, 1.2)]
    limits = group_limits([*low, *high])
    assert [limits.group(c) for c in low] == ["LVLF"] * 6
    assert [limits.group(c) for c in high] == ["LVHF"] * 3 + ["HVHF"] * 4


def test_a_quantity_that_hardly_varies_is_not_divided():
    assert group_limits([cycle(v, 1.5) for v in (0.3, 0.35, 0.4)]) == GroupLimits(np.inf, np.inf)
    limits = group_limits([cycle(v, 1.5) for v in (0.1, 0.5, 1.0)])
    assert {limits.group(cycle(v, 1.5)) for v in (0.1, 1.0)} == {"LV", "HV"}


def test_one_rare_cycle_does_not_set_the_range():
    usual = [replace(cycle(v, 1.5), end=2.0) for v in np.linspace(0.1, 0.2, 200)]
    assert group_limits([*usual, cycle(5.0, 1.5)]).velocity == group_limits(usual).velocity
