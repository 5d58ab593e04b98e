"""A ride with a controller in the loop: its record and its measures."""

from dataclasses import replace

import numpy as np
import pytest

from damper_estimator.control import ConstantCommand, mixed
from damper_estimator.vehicle import (
    CORNER_CASES,
    LIMITS,
    REST,
    SURFACES,
    Ride,
    Surface,
    compare_commands,
    desired_force,
    ride_measures,
    tracking_ratio,
    wk_weighted,
)

CORNER = CORNER_CASES["semi_active"]
BUMP = Surface("bump", 8.0)


@pytest.fixture(scope="module")
def trials():
    commands = {
        "low": ConstantCommand(LIMITS[0]),
        "again": ConstantCommand(LIMITS[0]),
        "high": ConstantCommand(LIMITS[1]),
    }
    return compare_commands(CORNER, BUMP, commands, 4.0, seed=1)


def made(force) -> Ride:
    zero = np.zeros(force.size)
    return Ride(1e-3, zero, force, zero, zero, zero, zero, 5000.0)


def test_the_law_is_judged_at_the_true_velocities():
    step, travel_at, body_at = 1e-3, 2.0 * np.pi * 1.3, 2.0 * np.pi * 0.7
    time = step * np.arange(5000)
    ride = replace(
        made(np.zeros(5000)), travel=0.02 * np.sin(travel_at * time), body_acceleration=0.8 * np.cos(body_at * time)
    )
    found = desired_force(ride, mixed(3000.0, 0.8), -200.0)
    body = 0.8 / body_at * np.sin(body_at * time)
    wheel = body - 0.02 * travel_at * np.cos(travel_at * time)
    assert found[1:-1] == pytest.approx((-200.0 + 2400.0 * body - 600.0 * wheel)[1:-1], abs=0.05)


def test_at_least_twelve_scenarios_exist():
    assert len(CORNER_CASES) * len(SURFACES) >= 12
    assert len({surface.name for surface in SURFACES}) == len(SURFACES)


def test_the_same_command_on_the_same_seed_is_the_same_ride(trials):
    assert np.array_equal(trials["low"].ride.force, trials["again"].ride.force)
    assert tracking_ratio(trials, "low", "again") == 1.0


def test_a_steady_current_yields_a_limit_of_the_attainable_range(trials):
    """Without the lag the damper on the road and on the same motion agree."""
    trial = trials["low"]
    nearest = np.min(np.abs(trial.attainable - trial.ride.force), axis=0)
    assert np.sqrt(np.mean(nearest**2)) < 0.01 * trial.ride.force.std()
    width = np.ptp(trial.attainable, axis=0)
    assert width.max() > 500.0


def test_more_current_means_less_stroke(trials):
    assert trials["high"].measures.peak_stroke < trials["low"].measures.peak_stroke


def test_the_desired_force_counts_within_the_attainable_range():
    count = 4000
    force = np.full(count, 100.0)
    limits = np.stack([np.full(count, -50.0), np.full(count, 130.0)])
    wanted = np.where(np.arange(count) % 2, 1000.0, 120.0)
    found = ride_measures(made(force), wanted, limits, start=REST)
    assert found.tracking_n == pytest.approx(np.sqrt(np.mean([30.0**2, 20.0**2])))
    assert found.tracking_raw_n == pytest.approx(np.sqrt(np.mean([900.0**2, 20.0**2])))
    assert found.wanted_n == pytest.approx(5.0)


def test_measures_cover_the_judged_part():
    step = 1e-3
    time = step * np.arange(4000)
    late = time >= 1.0
    shaking = np.where(late, np.sin(2.0 * np.pi * 5.0 * time), 50.0)
    ride = replace(
        made(np.zeros(4000)), body_acceleration=shaking, tyre_force=np.where(late, -2500.0, 9000.0),
        travel=np.where(late, 0.01, 0.5),
    )  # fmt: skip
    found = ride_measures(ride, np.zeros(4000), np.zeros((2, 4000)), start=1.0)
    assert found.acceleration == pytest.approx(np.sqrt(0.5), rel=1e-6)
    assert found.weighted_acceleration == pytest.approx(np.sqrt(np.mean(wk_weighted(shaking, step)[late] ** 2)))
    assert found.tyre_load == pytest.approx(0.5)
    assert found.lowest_tyre_load == pytest.approx(0.5)
    assert found.stroke == pytest.approx(0.0, abs=1e-12)
    assert found.peak_stroke == pytest.approx(0.01)
