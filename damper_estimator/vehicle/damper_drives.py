"""All drives of a damper: the benches of the plant, and roads and bumps under a quarter car."""

from dataclasses import replace

import numpy as np

from damper_estimator.plant import BENCH_EXCITATIONS, STEP, Damper, Drive, bench_drive
from damper_estimator.plant.excitation import REST_AFTER, REST_BEFORE, fade, within
from damper_estimator.vehicle.quarter_car import CORNERS, QuarterCar, suspension_travel
from damper_estimator.vehicle.road import bump_height, road_height

SPEEDS = {"A": 30.0, "B": 25.0, "C": 20.0, "D": 10.0, "E": 4.0}
"""m/s, speed on each ISO 8608 class at which cars stay within their stroke."""

ROADS = {"road": "C"} | {f"road_{letter.lower()}": letter for letter in SPEEDS}
"""ISO 8608 class by the excitation's name."""

EXCITATIONS = (*BENCH_EXCITATIONS, *ROADS, "bump")
"""All names."""


def drive(
    name: str,
    damper: Damper,
    seconds: float,
    seed: int,
    current: np.ndarray | None = None,
    car: QuarterCar | None = None,
    step: float = STEP,
) -> Drive:
    """A drive by name. On roads the damper works in a corner of a car (``car``, by default from ``CORNERS``).

    ``current`` (A, shape (seconds / step,)) acts on the damper and is recorded; zero by default.

    Raises:
        KeyError: for an unknown name, or a damper without a corner.
        ValueError: for a record that is too short.
    """
    count = round(seconds / step)
    coil = np.zeros(count) if current is None else current
    if name in BENCH_EXCITATIONS:
        return replace(bench_drive(name, damper, seconds, seed, step), current=coil)
    corner = CORNERS[damper.name] if car is None else car
    travel = suspension_travel(corner, damper, _surface(name, seconds, count, step, seed), coil, step)
    # Both ends are at rest, so that rest can be detected; the rod's slow creep into the gas is no motion.
    travel = travel * fade(step * np.arange(count), count * step, 0.5)
    stroke = damper.geometry
    travel = within(travel, 0.97 * stroke.compression_stroke, 0.97 * stroke.rebound_stroke)
    return Drive(name, step, travel, coil, seed)


def _surface(name: str, seconds: float, count: int, step: float, seed: int) -> np.ndarray:
    """Height under the wheel in m, flat before and after the run, shape (count,)."""
    time = step * np.arange(count)
    length = seconds - REST_BEFORE - REST_AFTER - 1.0  # the car needs a second to come to rest
    if length < 2.0:
        raise ValueError(f"{seconds:g} s are too short; at least {REST_BEFORE + REST_AFTER + 3.0:g} s are needed")
    if name == "bump":
        rng = np.random.default_rng([seed, 5])
        starts = np.arange(REST_BEFORE, REST_BEFORE + length - 1.0, 2.5)
        return sum(
            bump_height(rng.uniform(0.03, 0.07), rng.uniform(0.5, 2.0), rng.uniform(5.0, 9.0), time, start)
            for start in starts
        )
    running = np.zeros(count)
    first, size = round(REST_BEFORE / step), round(length / step)
    profile = road_height(ROADS[name], SPEEDS[ROADS[name]], size, step, seed)
    running[first : first + size] = profile * fade(step * np.arange(size), length, 1.0)
    return running
