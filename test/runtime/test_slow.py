"""Slow channels: a wrong or silent value is never trusted, the last plausible one is held, and a fault is forgotten."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from damper_estimator.effects.discovery import find_effect
from damper_estimator.model import DamperModel, make_element
from damper_estimator.runtime import (
    DEGRADED,
    EXTRAPOLATING,
    GOOD,
    IMPLAUSIBLE,
    SILENT,
    WARMING_UP,
    DamperEstimator,
    HeldValues,
    Line,
    deployed,
)
from damper_estimator.signals import default_signals
from damper_estimator.signals.fusion import Fusion
from damper_estimator.signals.signal_map import parse_signal_map

MS = 1_000_000
FIT = {"residual_stddev": 10.0, "region": {"velocity": [-9.0, 9.0], "command": [0.08, 1.96]}}


def entry(name, **values):
    return make_element(find_effect(name), values)


def semi_active(lag=0.02, **fit):
    effects = (entry("command_lag", time_constant=lag), entry("viscous"), entry("semi_active_squash", gain=600.0))
    return DamperModel("semi-active", "", effects, fit=FIT | fit)


VISCOUS = DamperModel("viscous", "", (entry("viscous"),), fit=FIT)


def driven(model, value, heard, step=1, signals=None, role="command"):
    """Status and held channel (n,) of samples that come every ``step`` ms."""
    size = len(heard)
    stamp = (1 + np.arange(size)) * step * MS
    estimator = DamperEstimator(deployed(model, 60.0, 0.1, signals=signals))
    held = {
        "command": HeldValues(1.0, 1 + np.arange(size)),
        role: HeldValues(np.asarray(value, float), np.asarray(heard)),
    }
    estimates = estimator.take(stamp, 0.02 * np.sin(0.01 * np.arange(size)), held)
    row = {"command": 5, "temperature": 6, "pressure": 7}[role]
    return estimates.status, estimates.kinematics.block[row], estimator.line.records["counts"][0]


def every(size, samples):
    """Messages received at each sample, one every ``every`` samples."""
    return 1 + np.arange(size) // samples


@pytest.mark.parametrize("wild", [65535.0, 1e300, -1e300, np.nan, np.inf, -20.0])
def test_one_implausible_value_is_not_used_and_its_sample_is_not_good(wild):
    value = np.where(np.arange(1000) == 500, wild, 1.0)
    status, held, counts = driven(semi_active(), value, every(1000, 1))
    assert (held == 1.0).all() and counts[IMPLAUSIBLE] == 1
    assert (status[500:700] == DEGRADED).all() and (status[720:] == GOOD).all() and status[499] == GOOD


@pytest.mark.parametrize("samples, silent_after", [(1, 50), (10, 50), (40, 200), (200, 500)])
def test_a_channel_that_falls_silent_is_noticed_after_a_few_of_its_usual_intervals(samples, silent_after):
    heard = np.minimum(every(4000, samples), every(4000, samples)[2000])
    status, _, counts = driven(semi_active(), np.ones(4000), heard)
    last = int(np.flatnonzero(np.diff(heard))[-1]) + 1
    assert set(status[200:last]) == {GOOD}
    first = int(np.argmax(status[last:] == DEGRADED))
    assert 0.8 * silent_after <= first <= 1.2 * silent_after + 2
    assert (status[last + first :] == DEGRADED).all() and counts[SILENT] == 4000 - last - first


def test_the_map_sets_the_maximum_age_and_the_limits_of_a_value():
    content = {
        "dampers": {"one": {"command": {"limits": [0.0, 2.0], "max_age": 3.0}, "temperature": {"limits": [0, 90]}}}
    }
    signals = parse_signal_map(content, "test").dampers["one"]
    status, _, _ = driven(semi_active(), np.ones(4000), np.minimum(every(4000, 1), 500), signals=signals)
    assert (status[500:3400] == GOOD).all() and (status[3600:] == DEGRADED).all()
    damper = deployed(semi_active(), 60.0, 0.1, signals=signals)
    assert damper.possible("command") == pytest.approx((-0.2, 2.2)) and damper.possible("temperature") == (0.0, 90.0)
    assert deployed(semi_active(), 60.0, 0.1).possible("command") == pytest.approx((-1.8, 3.84))


def test_after_a_channel_comes_back_the_status_lasts_as_long_as_the_model_remembers():
    heard = np.where(np.arange(3000) < 500, every(3000, 1), np.where(np.arange(3000) < 1000, 500, every(3000, 1)))
    quick, _, _ = driven(semi_active(0.005), np.ones(3000), heard)
    slow, _, _ = driven(semi_active(0.2), np.ones(3000), heard)
    assert (quick[1000:1190] == DEGRADED).all() and (quick[1210:] == GOOD).all()
    assert (slow[1000:1700] == DEGRADED).all() and slow[-1] == GOOD


def test_a_model_that_does_not_depend_on_a_channel_is_not_degraded_by_it():
    status, _, counts = driven(VISCOUS, np.full(2000, 65535.0), every(2000, 1), role="temperature")
    assert set(status[200:]) == {GOOD} and counts[IMPLAUSIBLE + 1] == 2000
    hot = DamperModel("hot", "", (entry("viscous"), entry("temperature_gain", fade=0.01)), fit=FIT)
    assert driven(hot, np.full(2000, 65535.0), every(2000, 1), role="temperature")[0][-1] == DEGRADED
    assert driven(hot, np.full(2000, np.nan), np.zeros(2000, int), role="temperature")[0][-1] == EXTRAPOLATING
    assert driven(hot, np.full(2000, 25.0), every(2000, 1), role="temperature")[0][-1] == GOOD


def test_the_memory_of_a_lag_is_the_time_in_which_it_forgets():
    for lag in (0.01, 0.05, 0.2):
        memories = deployed(semi_active(lag), 60.0, 0.1).memories
        assert memories["command"] == pytest.approx(lag * np.log(100.0), rel=0.5)
        assert memories["temperature"] is None and memories["pressure"] is None
    assert deployed(VISCOUS, 60.0, 0.1).memories["command"] is None


def test_outside_the_region_a_command_is_extrapolated_without_affecting_trust():
    estimator = DamperEstimator(deployed(semi_active(), 60.0, 0.1, signals=default_signals("one")))
    stamp = (1 + np.arange(2000)) * MS
    command = np.where((stamp > 600 * MS) & (stamp < 700 * MS), 0.0, 1.0)
    estimator.block(stamp[:650], np.zeros(650), command[:650])
    answered = estimator.line.run(arrived(stamp[650:660]))
    assert set(answered.status[:, 0]) == {EXTRAPOLATING} and set(answered.trusted[:, 0]) == {GOOD}


def arrived(stamp):
    from damper_estimator.runtime import LineInput

    made = LineInput.empty(stamp.size, 1)
    made.stamp[:], made.slow[:, 0, 0], made.received[:, 0, 0] = stamp, 0.0, 650 + np.arange(stamp.size)
    return made


def test_a_model_that_was_never_identified_is_at_best_degraded():
    for fit in ({}, {"residual_stddev": 10.0}, {"region": {"velocity": [-9.0, 9.0]}}):
        bare = DamperModel("bare", "", (entry("viscous"),), fit=fit)
        status, _, _ = driven(bare, np.ones(500), every(500, 1))
        assert set(status) == {WARMING_UP, DEGRADED}


@given(st.integers(0, 10_000))
@settings(max_examples=40, deadline=None)
def test_while_a_needed_channel_is_wrong_or_silent_nothing_is_good(seed):
    """Random arrivals with random implausible values, against the rule in plain Python."""
    random = np.random.default_rng(seed)
    size = 1500
    heard = np.cumsum(random.random(size) < random.choice([0.005, 0.05, 0.5]))
    values = np.where(random.random(heard[-1] + 1) < 0.1, random.choice([np.nan, 1e9, -1e9]), 1.0)
    values[0] = np.nan
    status, held, _ = driven(semi_active(), values[heard], heard)
    possible = np.isfinite(values[heard]) & (np.abs(values[heard]) < 10.0)
    age, last = np.zeros(size), 0
    for i in range(size):
        last = i if i == 0 or heard[i] != heard[i - 1] else last
        age[i] = (i - last) * 1e-3
    assert not (status[~possible] == GOOD).any() and not (status[age > 0.5] == GOOD).any()
    assert np.isnan(held[: int(np.argmax(possible))]).all() or not possible.any() or possible[0]
    assert set(np.unique(held[np.isfinite(held)])) <= {1.0}


@pytest.mark.parametrize("each, silent", [(1, 10), (4, 20), (10, 50), (50, 100)])
def test_an_accelerometer_is_silent_after_five_of_its_usual_intervals(each, silent):
    """But not before 10 ms, and at the latest after the longest gap; in ms."""
    fusion, last = Fusion(), 2000
    known = replace(VISCOUS, fit=FIT | {"region": {"velocity": [-9.0, 9.0]}})
    line = Line()
    line.add("one", deployed(known, 60.0, 0.1, fusion=fusion))
    status = []
    for i in range(2 * last):
        if i % each == 0 and i <= last:
            line.input.acceleration[0, 0], line.input.acceleration_stamp[0, 0] = 0.0, i * MS
        line.step(i * MS, np.zeros(1), np.ones(1, bool))
        status.append(int(line.output.status[0, 0]))
    assert set(status[500 : last + silent + 1]) == {GOOD} and set(status[last + silent + 1 :]) == {DEGRADED}
