"""The search at the rate that the band asks for: the same answer as on all samples, and motion that stays exact."""

import numpy as np
import pytest

from damper_estimator.identification import fit
from damper_estimator.identification.methods.remaining import QUIET, Remaining
from damper_estimator.identification.rows import Rows, rows_of
from damper_estimator.model import load_model
from damper_estimator.signals import Measurement, default_signals
from damper_estimator.signals.kinematics import differentiate_recording
from damper_estimator.signals.layout import DT

RATE, SECONDS, BAND, CUTOFF = 3000.0, 6.0, 30.0, 60.0


@pytest.fixture(scope="module")
def fast():
    """A semi-active damper on a mount at 3 kHz, with a gauge's noise and steps of the current."""
    random = np.random.default_rng(3)
    time = np.arange(round(RATE * SECONDS)) / RATE
    phases, tones = random.uniform(0.0, 2.0 * np.pi, 12), np.geomspace(0.4, 14.0, 12)
    x = (0.004 / tones**0.6 * np.sin(2.0 * np.pi * np.outer(time, tones) + phases)).sum(axis=1)
    command = np.repeat(random.uniform(0.0, 2.0, 12), time.size // 12)
    kinematics, counts = differentiate_recording(np.round(time * 1e9).astype(np.int64), x, CUTOFF, 0.1, command=command)
    force = truth().force(kinematics.block)
    force = force + 0.01 * force.std() * random.standard_normal(time.size)
    judged, signals = kinematics.warm(), default_signals("d")
    return Measurement("fast", "d", kinematics, force, judged, counts, force, x, CUTOFF, BAND, signals)


def truth():
    values = {"rubber_mount.stiffness": 1.6e6, "viscous.rate": 2100.0, "semi_active_squash.gain": 520.0}
    return load_model("semi_active_on_mount").with_values(values)


def test_motion_is_that_of_the_full_rate(fast):
    thin = fast.thinned(7)
    assert np.array_equal(thin.kinematics.velocity, fast.kinematics.velocity[::7])
    assert thin.kinematics.dt[1:] == pytest.approx(7.0 / RATE)
    assert thin.kinematics.dt[0] == 0.0


def test_every_stretch_is_thinned_from_its_start(fast):
    block = fast.kinematics.block.copy()
    block[DT, 1000] = 0.0
    kinematics = type(fast.kinematics)(fast.kinematics.stamp, block)
    places = kinematics.thinned(7)
    assert 1000 in places and (kinematics.at(places).dt == 0.0).sum() == 2


def test_rate_is_that_of_the_band_and_slow_recordings_stay_whole(fast):
    rows = rows_of(fast)
    thin = rows.thinned()
    assert 10.0 * BAND <= thin.measurement.kinematics.rate < 20.0 * BAND
    assert thin.thinned() is thin


def test_finds_what_a_search_on_all_samples_finds_within_the_standard_errors(fast, monkeypatch):
    start = truth().with_values({"rubber_mount.stiffness": 2e6, "viscous.rate": 1500.0})
    free = ["rubber_mount", "viscous", "semi_active_squash.gain", "command_lag", "static_force"]
    quick = fit(start, [fast], free=free, fix=["*"], starts=0)
    monkeypatch.setattr(Rows, "thinned", lambda rows: rows)
    whole = fit(start, [fast], free=free, fix=["*"], starts=0)
    assert quick.converged and whole.converged
    for one, other in zip(quick.parameters, whole.parameters, strict=True):
        assert abs(one.value - other.value) <= 0.1 * other.standard_error, one.name
        assert one.standard_error == pytest.approx(other.standard_error, rel=0.05)
    assert quick.rmse_n == pytest.approx(whole.rmse_n, rel=1e-4)


def test_remaining_time_is_reported_after_some_seconds_and_in_proportion():
    lines, now = [], [0.0]
    remaining = Remaining(lines.append, lambda: now[0])
    remaining("start 1", 10.0, 90.0)
    assert lines == []
    now[0] = 2.0 * QUIET
    remaining("start 2", 10.0, 90.0)
    remaining("start 3", 10.0, 90.0)
    assert lines == [f"start 2: about {18.0 * QUIET:.0f} s left"]
