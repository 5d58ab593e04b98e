"""Status of an estimate: each fault degrades for 0.2 s and is counted once; noise is separated from motion."""

import numpy as np
import pytest

from damper_estimator.effects.discovery import find_effect
from damper_estimator.model import DamperModel, make_element
from damper_estimator.runtime import DEGRADED, GOOD, JUMPS, LATE, WARMING_UP, Line, deployed
from damper_estimator.runtime.status import NOISE
from damper_estimator.signals.butterworth import STATE_SIZE, differentiate

MS = 1_000_000
FIT = {"residual_stddev": 10.0, "region": {"velocity": [-9.0, 9.0]}}
MODEL = DamperModel("m", "", (make_element(find_effect("linear_viscous")),), fit=FIT)


def driven(stamp, displacement, cutoff=60.0):
    """Status of every sample of one damper, and its line."""
    line = Line()
    line.add("one", deployed(MODEL, cutoff, 0.1))
    status = []
    for now, value in zip(stamp.tolist(), displacement, strict=True):
        line.step(now, np.array([value]), np.ones(1, bool))
        status.append(int(line.output.status[0, 0]))
    return np.array(status), line


def motion(stamp):
    return 0.03 * np.sin(stamp * 1e-9 * 2 * np.pi * 1.5) + 0.002 * np.sin(stamp * 1e-9 * 2 * np.pi * 15.0)


@pytest.mark.parametrize("step", [0.1, 0.5, 1.0, 2.0, 5.0, 10.0])
def test_motion_alone_never_degrades_at_any_rate(step):
    stamp = np.round(np.arange(0, 2000, step) * MS).astype(np.int64)
    jitter = np.random.default_rng(1).integers(-int(0.3 * step * MS), int(0.3 * step * MS), stamp.size)
    status, line = driven(stamp + jitter, motion(stamp + jitter))
    assert set(status) == {WARMING_UP, GOOD}
    assert line.records["counts"][0, JUMPS] == line.records["counts"][0, LATE] == 0


def test_a_change_of_rate_is_noticed_once_and_forgotten():
    stamp = np.cumsum(np.repeat([1, 10, 1], [1000, 100, 1000])) * MS
    status, line = driven(stamp, motion(stamp))
    assert line.records["counts"][0, LATE] > 0
    assert status[999] == GOOD and status[1000] == DEGRADED and status[1099] == GOOD and (status[1100:] == GOOD).all()


@pytest.mark.parametrize(
    "fault, counter",
    [
        (lambda stamp, x: (np.delete(stamp, slice(500, 520)), np.delete(x, slice(500, 520))), LATE),
        (lambda stamp, x: (stamp, np.where(np.arange(x.size) < 500, x, x + 0.02)), JUMPS),
        (lambda stamp, x: (stamp, np.where(np.arange(x.size) == 500, np.nan, x)), None),
        (lambda stamp, x: (np.where(np.arange(x.size) == 500, stamp - 5 * MS, stamp), x), None),
    ],
    ids=["gap", "jump", "not finite", "late"],
)
def test_a_fault_degrades_for_a_fifth_of_a_second(fault, counter):
    stamp = np.arange(1000) * MS
    stamp, displacement = fault(stamp, motion(stamp))
    status, line = driven(stamp, displacement)
    times = stamp[status == DEGRADED]
    assert times.size > 150 and times.min() >= 499 * MS and times.max() < 725 * MS
    assert (status[stamp >= 725 * MS] == GOOD).all() and (status[(stamp > 200 * MS) & (stamp < 499 * MS)] == GOOD).all()
    if counter is not None:
        assert line.records["counts"][0, counter] == 1


def test_a_long_first_step_does_not_hide_a_gap_after_the_warm_up():
    stamp = np.arange(1000) * 4 * MS
    stamp[1:] += 80 * MS
    stamp[40:] += 30 * MS
    status, line = driven(stamp, motion(stamp))
    assert status[39] == GOOD and (status[40:80] == DEGRADED).all()
    assert line.records["counts"][0, LATE] == 1


@pytest.mark.parametrize("cutoff, step", [(60.0, 1.0), (20.0, 1.0), (60.0, 0.25)])
def test_the_noise_of_the_velocity_is_predicted(cutoff, step):
    """Against the filter itself, driven with white noise."""
    sigma, count = 1e-4, 200_000
    noise = sigma * np.random.default_rng(2).standard_normal(count)
    x, v, a = np.empty((3, count))
    differentiate(cutoff, np.full(count, step * 1e-3), noise, np.zeros(STATE_SIZE), x, v, a)
    line = Line()
    line.add("one", deployed(MODEL, cutoff, 0.1))
    line.records["step"], line.records["variance"] = step * 1e-3, sigma**2
    assert line.velocity_noise(0) == pytest.approx(v[5000:].std(), rel=0.12)


def test_noise_is_distinguished_from_motion():
    stamp = np.arange(4000) * MS
    noise = np.random.default_rng(3).standard_normal(stamp.size)
    quiet, line = driven(stamp, motion(stamp) + 1e-4 * noise)
    assert (quiet[1000:] == GOOD).all()
    assert line.velocity_noise(0) == pytest.approx(0.0094, rel=0.5)
    loud, line = driven(stamp, motion(stamp) + 2e-3 * noise)
    assert (loud[1000:] == DEGRADED).all() and line.velocity_noise(0) > NOISE


@pytest.mark.parametrize("step", [1.0, 2.0])
@pytest.mark.parametrize("size", [0.0025, 0.004, 0.009])
def test_an_outlier_no_faster_than_a_damper_degrades_immediately(size, step):
    """It moves the filtered velocity by up to ``size * step * cutoff^2``; 4 m/s are too slow for a jump."""
    stamp = np.round(np.arange(0, 1000, step) * MS).astype(np.int64)
    displacement = motion(stamp)
    displacement[400] += min(size, 4.5e-3 * step)
    status, line = driven(stamp, displacement)
    assert (status[400 : 400 + round(200 / step)] == DEGRADED).all() and status[399] == GOOD
    assert (status[stamp > stamp[400] + 230 * MS] == GOOD).all()
    assert line.records["counts"][0, JUMPS] in (1, 2)


def test_a_pothole_and_noise_are_no_outliers():
    stamp = np.arange(3000) * MS
    seconds = stamp * 1e-9
    bump = 0.5 * 600.0 * 0.01**2 * np.exp(-(((seconds - 1.5) / 0.01) ** 2))  # 60 g within some 10 ms
    noise = 1e-4 * np.random.default_rng(4).standard_normal(stamp.size)
    for displacement in (motion(stamp) + bump, motion(stamp) + noise):
        status, _ = driven(stamp, displacement)
        assert (status[1000:] == GOOD).all()
