"""Long recordings are searched in their informative stretches, and judged as a whole."""

from dataclasses import replace
from unittest.mock import patch

import numpy as np
import pytest

from damper_estimator.diagnosis import diagnose, informative
from damper_estimator.diagnosis.informative import CHOSEN, LONGEST, stretches_used
from damper_estimator.identification import pooled_error
from damper_estimator.signals.kinematics import Kinematics
from damper_estimator.signals.layout import TEMPERATURE, A, T, V, X

chosen_of = informative.informative


def lengthened(measurement, seconds):
    """The recording again and again, each time with a restart, until it lasts so long."""
    once = measurement.kinematics
    length = float(once.time[-1] - once.time[0]) + 1.0
    count = int(np.ceil(seconds / length))
    parts = []
    for k in range(count):
        block = once.block.copy()
        block[T] += k * length
        parts.append(Kinematics(once.stamp + round(k * length * 1e9), block))
    tiled = {
        name: np.tile(getattr(measurement, name), count) for name in ("force", "judged", "raw_displacement", "gauge")
    }
    return replace(measurement, kinematics=Kinematics.joined(parts), gauge_stamp=None, **tiled)


@pytest.fixture(scope="module")
def long(base):
    return lengthened(base, 1500.0)


def seconds(measurements):
    return sum(float(m.kinematics.dt.sum()) for m in measurements)


def times(measurements):
    return np.concatenate([m.kinematics.time for m in measurements])


def test_ordinary_recordings_are_used_whole(base):
    assert chosen_of([base, base])[0] is base
    assert stretches_used("fit", [base], chosen_of([base])) == ()


def test_of_a_long_one_some_minutes_are_left_in_order_of_time(long):
    (part,) = chosen_of([long])
    assert seconds([long]) > LONGEST and 0.8 * CHOSEN < seconds([part]) <= 1.1 * CHOSEN
    assert np.all(np.diff(part.kinematics.stamp) > 0)
    at = np.searchsorted(long.kinematics.stamp, part.kinematics.stamp)
    np.testing.assert_array_equal(part.force, long.force[at])
    np.testing.assert_array_equal(part.kinematics.velocity, long.kinematics.velocity[at])
    assert not part.judged[part.kinematics.dt <= 0.0].any(), "a stretch begins with a warm-up"
    used = stretches_used("unseen", [long], [part])
    assert {one.use for one in used} == {"unseen"} and all(one.start < one.stop for one in used)
    assert sum(one.stop - one.start for one in used) == pytest.approx(seconds([part]), rel=0.01)


@pytest.mark.parametrize("row, factor", [((X,), 1.6), ((X, V, A), 1.8)])
def test_a_rare_large_motion_is_among_them(long, row, factor):
    """End stops are touched for seconds in an hour."""
    time = long.kinematics.time
    event = (time > 611.0) & (time < 613.0)
    block = long.kinematics.block.copy()
    block[list(row)] = np.where(event, factor, 1.0) * block[list(row)]
    rare = replace(long, kinematics=replace(long.kinematics, block=block))
    kept = times(chosen_of([rare]))
    assert np.count_nonzero((kept > 611.0) & (kept < 613.0)) > 0.9 * np.count_nonzero(event)


def test_a_warm_hour_keeps_its_cold_start_and_its_hot_end(long):
    block = long.kinematics.block.copy()
    block[TEMPERATURE] = 20.0 + 40.0 * (1.0 - np.exp(-block[T] / 500.0))
    warm = replace(long, kinematics=replace(long.kinematics, block=block))
    (part,) = chosen_of([warm])
    hot = part.kinematics.temperature
    assert hot.max() - hot.min() > 0.8 * (block[TEMPERATURE].max() - block[TEMPERATURE].min())


def test_the_choice_does_not_look_at_the_force(long):
    other = replace(long, force=np.random.default_rng(0).normal(0.0, 500.0, long.force.size))
    np.testing.assert_array_equal(times(chosen_of([long])), times(chosen_of([other])))


def test_several_recordings_remain_several(long):
    half = len(long.kinematics) // 2
    both = [long.part(0, half), long.part(half, 2 * half)]
    kept = chosen_of(both)
    assert 1 <= len(kept) <= 2 and seconds(kept) <= 1.1 * CHOSEN
    assert all(any(m.kinematics.stamp[0] in whole.kinematics.stamp for whole in both) for m in kept)


def test_the_verdict_is_that_of_the_whole_and_its_errors_too(user_model, soft):
    first, other = (lengthened(m, 80.0) for m in soft)
    with patch.multiple(informative, LONGEST=50.0, CHOSEN=40.0):
        found = diagnose(user_model, [first], [other])
    with patch.object(informative, "LONGEST", np.inf):
        whole = diagnose(user_model, [first], [other])
    assert found.stretches and not whole.stretches
    assert {one.use for one in found.stretches} == {"fit", "unseen"}
    assert found.verdict == whole.verdict == "missing"
    assert [one.phenomenon for one in found.findings] == [one.phenomenon for one in whole.findings]
    assert found.rmse_n == whole.rmse_n
    assert found.findings[0].rmse_after_n == pytest.approx(whole.findings[0].rmse_after_n, rel=0.05)
    assert found.findings[-1].rmse_after_n == pytest.approx(pooled_error(found.improved, [other])[0])
    assert found.record()["stretches"][0]["recording"] == first.recording
