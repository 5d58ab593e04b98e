"""The quarter car around the simulated damper."""

import numpy as np
import pytest

from damper_estimator.plant import DAMPERS, simulate
from damper_estimator.vehicle import CORNERS, EXCITATIONS, drive, suspension_travel
from damper_estimator.vehicle.quarter_car import TRAVEL, RunningCar

STEP = 2e-4
EVERY_DAMPER = pytest.mark.parametrize("name", DAMPERS)


def travel_on(name: str, road: np.ndarray, step: float = STEP, current: float = 0.0) -> np.ndarray:
    return suspension_travel(CORNERS[name], DAMPERS[name], road, np.full_like(road, current), step)


@EVERY_DAMPER
def test_on_a_flat_road_nothing_moves(name: str) -> None:
    assert np.abs(travel_on(name, np.zeros(2000))).max() < 1e-6


@EVERY_DAMPER
def test_a_step_in_the_road_compresses_first_and_dies_out(name: str) -> None:
    time = STEP * np.arange(20000)
    travel = travel_on(name, 0.02 * np.clip((time - 0.1) / 0.02, 0.0, 1.0))
    first = travel[(time > 0.1) & (time < 0.2)]
    assert first.min() < -0.004
    # Friction can keep the rod in place.
    stuck = 2.0 * DAMPERS[name].seal.force * 1.5 / CORNERS[name].spring_rate
    assert np.abs(travel[time > 3.5]).max() < stuck + 1e-3


def test_without_damping_force_the_body_swings_at_its_natural_frequency() -> None:
    damper = DAMPERS["passenger_front"]
    open_valves = damper.with_part("piston", bleed_area=1e-3, ring_gap=1e-8)
    open_valves = open_valves.with_part("seal", force=0.0, per_pressure=0.0, viscous=0.0)
    car = CORNERS["passenger_front"]
    time = STEP * np.arange(30000)
    road = 0.01 * np.clip((time - 0.1) / 0.05, 0.0, 1.0)
    travel = suspension_travel(car, open_valves, road, np.zeros_like(road), STEP)
    late = time > 1.0
    swing = np.where(late, travel - travel[late].mean(), 0.0)
    spectrum = np.abs(np.fft.rfft(swing * late * np.hanning(late.size), 8 * late.size))
    measured = np.fft.rfftfreq(8 * late.size, STEP)[np.argmax(spectrum)]
    both = car.spring_rate * car.tyre_rate / (car.spring_rate + car.tyre_rate)
    assert measured == pytest.approx(np.sqrt(both / car.body_mass) / (2.0 * np.pi), rel=0.05)


def test_the_motion_converges_with_the_step() -> None:
    def road(step: float) -> np.ndarray:
        return 0.01 * (1.0 - np.cos(2.0 * np.pi * 3.0 * step * np.arange(round(1.0 / step))))

    finest = travel_on("passenger_front", road(1e-4 / 8), 1e-4 / 8)
    errors = [
        np.sqrt(np.mean((travel_on("passenger_front", road(1e-4 * k), 1e-4 * k) - finest[:: 8 * k]) ** 2))
        for k in (4, 2, 1)
    ]
    assert 0.8 < np.log2(errors[0] / errors[1]) < 2.5
    assert errors[2] < 0.01 * np.std(finest)


def test_more_current_means_less_motion() -> None:
    road = drive_road()
    free, held = (travel_on("semi_active", road, current=amperes) for amperes in (0.0, 2.0))
    assert held.std() < 0.8 * free.std()


def drive_road() -> np.ndarray:
    time = STEP * np.arange(15000)
    return 0.01 * np.sin(2.0 * np.pi * 1.6 * time) * np.clip(time, 0.0, 1.0)


@pytest.mark.parametrize("excitation", [name for name in EXCITATIONS if name.startswith("road") or name == "bump"])
@pytest.mark.parametrize("seed", [1, 2])
def test_roads_move_the_damper_within_its_stroke_and_leave_it_at_rest_at_both_ends(excitation: str, seed: int) -> None:
    damper = DAMPERS["light_car"]
    record = drive(excitation, damper, 10.0, seed, step=STEP)
    travel = record.displacement
    assert travel.size == 50000
    assert -damper.geometry.compression_stroke < travel.min() < -0.002
    assert 0.001 < travel.max() < damper.geometry.rebound_stroke
    assert np.abs(travel[: round(1.9 / STEP)]).max() < 1e-5
    assert abs(travel[-1]) < 1e-6


def test_rougher_roads_move_the_damper_more() -> None:
    damper = DAMPERS["passenger_front"]
    motion = [drive(f"road_{letter}", damper, 12.0, 1, step=STEP).displacement.std() for letter in "abcd"]
    assert motion == sorted(motion)


def test_every_excitation_can_drive_every_damper() -> None:
    for damper in DAMPERS.values():
        for excitation in EXCITATIONS:
            record = drive(excitation, damper, 6.5, 1, step=STEP)
            assert np.isfinite(simulate(damper, record).force).all()


def test_an_unknown_excitation_is_an_error() -> None:
    with pytest.raises(KeyError):
        drive("moon", DAMPERS["light_car"], 10.0, 1)


def test_a_road_in_stretches_equals_the_whole_road() -> None:
    """The slope at a seam is one-sided, so the agreement is that of the step."""
    rng = np.random.default_rng(3)
    road = 0.01 * np.cumsum(np.convolve(rng.standard_normal(4000), np.ones(100) / 100, "same")) * STEP * 50
    current = np.full(road.size, 0.5)
    whole = suspension_travel(CORNERS["semi_active"], DAMPERS["semi_active"], road, current, STEP)
    running = RunningCar(CORNERS["semi_active"], DAMPERS["semi_active"], road[:2001], STEP, 0.5)
    running.advance(2001, current)
    first = running.column(TRAVEL)
    running.continue_on(road[2000:])
    running.advance(road[2000:].size, current)
    joined = np.concatenate([first, running.column(TRAVEL)[1:]])
    assert joined.size == whole.size
    assert np.abs(joined - whole).max() < 1e-3 * np.abs(whole).max()
