"""Bench excitations match their names."""

import numpy as np
import pytest

from damper_estimator.plant import BENCH_EXCITATIONS, DAMPERS, STEP, Drive, bench_drive, current_steps
from damper_estimator.plant.excitation import REST_AFTER, REST_BEFORE, within

PASSENGER = DAMPERS["passenger_front"]
EVERY_EXCITATION = pytest.mark.parametrize("name", BENCH_EXCITATIONS)
COARSE = 1e-3


def moving(drive: Drive) -> np.ndarray:
    """The displacement without the rests and the ramps of the envelope."""
    edges = round((REST_BEFORE + 1.0) / drive.step), -round((REST_AFTER + 1.0) / drive.step)
    return drive.displacement[slice(*edges)]


@EVERY_EXCITATION
def test_a_record_begins_and_ends_at_rest(name: str) -> None:
    drive = bench_drive(name, PASSENGER, 12.0, 1, COARSE)
    assert drive.displacement.size == 12000
    assert np.abs(drive.displacement[: round(REST_BEFORE / COARSE)]).max() == 0.0
    assert np.abs(drive.displacement[-round(REST_AFTER / COARSE) :]).max() == 0.0
    assert np.abs(drive.displacement).max() > 0.004


@EVERY_EXCITATION
@pytest.mark.parametrize("damper", DAMPERS.values(), ids=DAMPERS)
def test_no_excitation_leaves_the_stroke(name: str, damper: str) -> None:
    for seed in range(3):
        travel = bench_drive(name, damper, 30.0, seed, COARSE).displacement
        assert travel.max() < damper.geometry.rebound_stroke
        assert travel.min() > -damper.geometry.compression_stroke


@EVERY_EXCITATION
def test_a_seed_repeats_its_motion_and_another_seed_differs(name: str) -> None:
    first, again, other = (bench_drive(name, PASSENGER, 12.0, seed, COARSE).displacement for seed in (1, 1, 4))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


@EVERY_EXCITATION
def test_the_motion_does_not_depend_on_the_step(name: str) -> None:
    coarse, fine = (bench_drive(name, PASSENGER, 12.0, 1, step).displacement for step in (COARSE, COARSE / 4))
    assert np.abs(coarse - fine[::4]).max() < 1e-5


@EVERY_EXCITATION
def test_the_motion_is_smooth(name: str) -> None:
    drive = bench_drive(name, PASSENGER, 12.0, 1)
    spectrum = np.abs(np.fft.rfft(drive.velocity)) ** 2
    frequency = np.fft.rfftfreq(drive.velocity.size, STEP)
    assert spectrum[frequency > 60.0].sum() < 1e-3 * spectrum.sum()
    assert np.abs(np.diff(drive.acceleration)).max() < 0.1 * np.abs(drive.acceleration).max()


@pytest.mark.parametrize(("name", "rms"), [("random", 0.005), ("random10", 0.010)])
def test_random_displacement_has_its_rms_and_its_band(name: str, rms: float) -> None:
    drive = bench_drive(name, PASSENGER, 120.0, 1, COARSE)
    motion = moving(drive)
    assert motion.std() == pytest.approx(rms, rel=0.04)
    spectrum = np.abs(np.fft.rfft(motion * np.hanning(motion.size))) ** 2
    frequency = np.fft.rfftfreq(motion.size, COARSE)
    inside = (frequency > 0.08) & (frequency < 20.5)
    assert spectrum[inside].sum() > 0.9999 * spectrum.sum()
    assert spectrum[(frequency > 15.0) & inside].mean() > 1e-4 * spectrum[inside].mean()


def test_the_slow_triangle_moves_at_5_mm_per_second() -> None:
    drive = bench_drive("slow", PASSENGER, 42.5, 1, COARSE)
    speed = np.abs(moving(drive.__class__("v", COARSE, drive.velocity, drive.current)))
    assert np.median(speed) == pytest.approx(0.005, rel=0.02)
    assert np.ptp(drive.displacement) == pytest.approx(0.05, rel=0.02)


def test_steps_are_50_mm_high() -> None:
    drive = bench_drive("step", PASSENGER, 12.0, 1, COARSE)
    standing = np.abs(drive.velocity) < 1e-6
    levels = np.unique(np.round(drive.displacement[standing], 6))
    assert levels.tolist() == [-0.025, 0.0, 0.025]
    assert np.abs(drive.velocity).max() > 0.5


def test_the_dyno_series_has_strokes_of_several_frequencies_and_amplitudes_with_pauses() -> None:
    drive = bench_drive("dyno", PASSENGER, 60.0, 1, COARSE)
    slots = np.array_split(drive.displacement[round(REST_BEFORE / COARSE) : -round(REST_AFTER / COARSE)], 11)
    crossings = [np.count_nonzero(np.diff(np.sign(slot)) != 0) for slot in slots]
    amplitudes = [np.abs(slot).max() for slot in slots]
    assert max(crossings) > 8 * min(crossings)
    assert max(amplitudes) > 8 * min(amplitudes)
    assert all(np.abs(slot[-50:]).max() < 1e-6 for slot in slots)


def test_a_record_that_is_too_short_is_refused() -> None:
    with pytest.raises(ValueError, match="too short"):
        bench_drive("random", PASSENGER, 3.0, 1)


def test_current_steps_stay_in_range_and_are_held() -> None:
    current = current_steps(30.0, 1, COARSE)
    changes = np.flatnonzero(np.diff(current))
    assert current.size == 30000
    assert 0.0 <= current.min() < 0.7 and 1.3 < current.max() <= 2.0
    assert 10 < changes.size < 40
    assert np.diff(changes).min() >= 800


def test_limiting_leaves_small_motions_alone() -> None:
    motion = np.linspace(-0.2, 0.2, 401)
    limited = within(motion, 0.08, 0.06)
    small = (motion > -0.06) & (motion < 0.045)
    assert limited[small] == pytest.approx(motion[small], rel=0.002)
    assert limited.min() >= -0.08 and limited.max() <= 0.06
    assert (np.diff(limited) >= 0.0).all()
