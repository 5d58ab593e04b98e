"""Sensors: each imperfection matches its parameter, in the sign conventions of the signal map."""

from dataclasses import replace

import numpy as np
import pytest

from damper_estimator.plant import (
    DAMPERS,
    Channel,
    Sensors,
    Truth,
    bench_drive,
    current_steps,
    ideal_force,
    measure,
    simulate,
)

SECONDS = 8.0
PERFECT = Sensors(
    displacement_noise=0.0, displacement_step=0.0, force_noise=0.0, force_step=0.0, force_drift=0.0,
    clock_jitter=0.0, stamp_jitter=0.0, drop_out=0.0, temperature_noise=0.0,
)  # fmt: skip
INTERPOLATION = 0.05
"""N, between a sample and the truth at a stamp that is rounded to a microsecond."""


@pytest.fixture(scope="module")
def truth() -> Truth:
    damper = DAMPERS["semi_active"]
    drive = replace(bench_drive("random", damper, SECONDS, 1), current=current_steps(SECONDS, 1))
    return simulate(damper, drive)


def at_stamps(truth: Truth, channel: Channel, values: np.ndarray, late: float = 0.0) -> np.ndarray:
    return np.interp(1e-9 * channel.stamp - late, truth.time, values)


def test_perfect_sensors_show_the_truth(truth: Truth) -> None:
    sensed = measure(truth, PERFECT, 1)
    assert sensed.displacement.value == pytest.approx(at_stamps(truth, sensed.displacement, truth.drive.displacement))
    assert sensed.force.value == pytest.approx(at_stamps(truth, sensed.force, truth.force), abs=INTERPOLATION)
    assert sensed.temperature.value == pytest.approx(at_stamps(truth, sensed.temperature, truth.temperature), abs=0.01)
    assert set(np.unique(sensed.current.value)) <= set(np.unique(truth.drive.current))


def test_the_rate_is_the_rate(truth: Truth) -> None:
    for rate in (100.0, 500.0, 1000.0):
        stamps = measure(truth, replace(PERFECT, rate=rate), 1).force.stamp
        assert stamps.size == pytest.approx(rate * SECONDS, abs=2)
        assert np.diff(stamps) == pytest.approx(1e9 / rate, abs=1001)


def test_noise_and_quantisation_have_their_size(truth: Truth) -> None:
    sensed = measure(truth, replace(PERFECT, displacement_noise=2e-5, force_noise=6.0), 1)
    error = sensed.displacement.value - at_stamps(truth, sensed.displacement, truth.drive.displacement)
    assert error.std() == pytest.approx(2e-5, rel=0.06)
    error = sensed.force.value - at_stamps(truth, sensed.force, truth.force)
    assert error.std() == pytest.approx(6.0, rel=0.06)
    stepped = measure(truth, replace(PERFECT, displacement_step=1e-4, force_step=3.0), 1)
    for channel, step in ((stepped.displacement, 1e-4), (stepped.force, 3.0)):
        assert np.abs(channel.value / step - np.round(channel.value / step)).max() < 1e-6


@pytest.mark.parametrize("skew", [0.004, -0.004])
def test_skew_is_positive_where_the_force_is_late(truth: Truth, skew: float) -> None:
    sensed = measure(truth, replace(PERFECT, skew=skew), 1)
    assert sensed.force.value == pytest.approx(at_stamps(truth, sensed.force, truth.force, skew), abs=INTERPOLATION)
    assert ideal_force(truth, Sensors(skew=skew))[5000:-5000] == pytest.approx(
        np.interp(truth.time - skew, truth.time, truth.force)[5000:-5000]
    )


def test_the_stated_spring_is_what_the_signal_map_subtracts(truth: Truth) -> None:
    sensors = replace(PERFECT, spring_rate=24000.0, preload=-3000.0)
    sensed = measure(truth, sensors, 1)
    travel = at_stamps(truth, sensed.force, truth.drive.displacement)
    damper_force = sensed.force.value - 24000.0 * travel + 3000.0
    assert damper_force == pytest.approx(at_stamps(truth, sensed.force, truth.force), abs=INTERPOLATION)


def test_errors_of_the_chain_are_those_of_the_ideal_force(truth: Truth) -> None:
    sensors = replace(PERFECT, force_gain=1.1, force_offset=40.0, spring_rate_error=3000.0, skew=0.002)
    sensed = measure(truth, sensors, 1)
    expected = at_stamps(truth, sensed.force, ideal_force(truth, sensors))
    assert sensed.force.value == pytest.approx(expected, abs=2 * INTERPOLATION)


def test_a_gauge_that_clips_clips(truth: Truth) -> None:
    force = measure(truth, replace(PERFECT, saturation=500.0), 1).force.value
    assert force.max() == 500.0 and force.min() == -500.0


def test_messages_are_lost_and_late_but_arrive_in_order(truth: Truth) -> None:
    sensed = measure(truth, replace(Sensors(), drop_out=0.05), 1)
    for channel in (sensed.displacement, sensed.force):
        assert channel.stamp.size == pytest.approx(0.95 * 500.0 * SECONDS, rel=0.02)
        assert (np.diff(channel.stamp) > 0).all()
        assert (np.diff(channel.log) >= 0).all()
        assert (channel.log > channel.stamp).all()
    assert not np.array_equal(sensed.displacement.stamp, sensed.force.stamp)


def test_jitter_makes_the_steps_uneven(truth: Truth) -> None:
    steps = np.diff(measure(truth, replace(PERFECT, clock_jitter=5e-5), 1).displacement.stamp)
    assert steps.std() == pytest.approx(5e4 * np.sqrt(2.0), rel=0.1)


def test_a_seed_repeats_the_noise_and_a_clock_seed_the_stamps(truth: Truth) -> None:
    first, again = (measure(truth, Sensors(), 1) for _ in range(2))
    neighbour = measure(truth, Sensors(), 2, clock_seed=1)
    assert np.array_equal(first.force.value, again.force.value)
    assert np.array_equal(first.force.stamp, neighbour.force.stamp)
    assert np.array_equal(first.displacement.log, neighbour.displacement.log)
    assert not np.array_equal(first.force.value, neighbour.force.value)


def test_the_truth_accompanies_the_measurement(truth: Truth) -> None:
    sensed = measure(truth, replace(PERFECT, skew=0.003, force_offset=50.0), 1)
    assert np.array_equal(sensed.true_force.stamp, sensed.displacement.stamp)
    assert sensed.true_force.value == pytest.approx(at_stamps(truth, sensed.true_force, truth.force), abs=INTERPOLATION)
