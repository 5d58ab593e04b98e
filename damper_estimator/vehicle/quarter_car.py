"""Quarter car: body and wheel on a road, with the simulated damper between them.

With z upwards, x = z_body - z_wheel (extension) and everything measured from the loaded rest:

    m_body z_body'' = -k x - F - stops(x)
    m_wheel z_wheel'' = k x + F + stops(x) + tyre,     tyre = max(k_t (z_road - z_wheel) + c_t (..)', -static load)

F is the damper's force less its force at rest. The tyre can lift off the road. Car and damper alternate: the car moves
with the damper's last force, then the damper follows. This is accurate to first order in the step; at 0.1 ms the error
is far below the uncertainty of any road.
"""

from dataclasses import dataclass

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.plant import Damper
from damper_estimator.plant import kernel as plant_kernel
from damper_estimator.plant.damper import Parts, parts_of
from damper_estimator.plant.simulation import rest

GRAVITY = 9.81
"""m/s^2."""

STOP_STIFFNESS = 6e5
"""N/m, of the chassis stops that keep the damper within its stroke."""


@dataclass(frozen=True)
class QuarterCar:
    """One corner of a car; motion ratio 1."""

    body_mass: float  # kg
    wheel_mass: float  # kg
    spring_rate: float  # N/m
    tyre_rate: float  # N/m
    tyre_damping: float  # N s/m

    @property
    def static_load(self) -> float:
        """Of the tyre, N."""
        return (self.body_mass + self.wheel_mass) * GRAVITY


CORNERS = {
    "passenger_front": QuarterCar(380.0, 42.0, 24000.0, 210000.0, 120.0),
    "rally_rear": QuarterCar(330.0, 48.0, 34000.0, 240000.0, 150.0),
    "light_car": QuarterCar(220.0, 28.0, 15000.0, 160000.0, 80.0),
    "semi_active": QuarterCar(480.0, 48.0, 30000.0, 250000.0, 150.0),
}
"""The corner of each damper of the catalogue."""


def suspension_travel(
    car: QuarterCar, damper: Damper, road: np.ndarray, current: np.ndarray, step: float
) -> np.ndarray:
    """Damper displacement in m, from rest on a road of height ``road`` (m), with a coil current (A); all (n,)."""
    running = RunningCar(car, damper, road, step, float(current[0]))
    running.advance(road.size, current)
    return running.column(TRAVEL)


TRAVEL, FORCE, BODY_ACCELERATION, TYRE_FORCE = range(4)
"""Columns of the record: m, N (the damper's, with its gas), m/s^2, N (change from the static load)."""


class RunningCar:
    """A quarter car that drives over a road in stretches, so that a controller can act between them; final.

    Attributes:
        record: (n, 4), columns as above; valid up to ``index``.
        index: of the last valid sample; 0 is rest.
        rest_force: of the damper, N.
    """

    def __init__(self, car: QuarterCar, damper: Damper, road: np.ndarray, step: float, current: float):
        """``road`` (n,) in m every ``step`` s; ``current`` in A of the damper at rest."""
        stroke = damper.geometry
        limits = (-0.7 * stroke.compression_stroke, 0.7 * stroke.rebound_stroke)
        self._parts = parts_of(damper)
        self._memory = rest(self._parts, 0.0, current)
        self._numbers = (
            car.body_mass, car.wheel_mass, car.spring_rate, car.tyre_rate, car.tyre_damping, *limits,
        )  # fmt: skip
        self._road, self._slope, self._step = road, np.gradient(road, step), step
        self._motion = np.zeros(4)
        self._work, self._seen = np.zeros((plant_kernel.WORK_ROWS, 7)), np.zeros(plant_kernel.OUT_ROWS)
        plant_kernel.observe(self._parts, self._memory, 0.0, 0.0, self._seen)
        self.rest_force = float(self._seen[plant_kernel.FORCE])
        self.record = np.zeros((road.size, 4))
        self.record[0, FORCE] = self.rest_force
        self.index = 0

    def advance(self, end: int, current: np.ndarray) -> None:
        """Runs up to sample ``end`` (not included); ``current`` (n,) in A over the whole road."""
        _drive(
            self._parts, self._memory, self._work, self._seen, self.rest_force, self._numbers, self._motion, self._road,
            self._slope, current, self._step, self.index + 1, end, self.record,
        )  # fmt: skip
        self.index = end - 1

    def continue_on(self, road: np.ndarray) -> None:
        """Starts the next stretch of road at the last height of the previous one; the record restarts."""
        last = self.record[self.index]
        self._road, self._slope = road, np.gradient(road, self._step)
        self.record = np.zeros((road.size, 4))
        self.record[0], self.index = last, 0

    @property
    def temperature(self) -> float:
        """Of the oil, deg C."""
        return float(self._memory[plant_kernel.TEMPERATURE])

    @property
    def gas_pressure(self) -> float:
        """Absolute, Pa."""
        return float(self._seen[plant_kernel.GAS_PRESSURE])

    def column(self, which: int) -> np.ndarray:
        """One quantity over the whole road, (n,)."""
        return np.ascontiguousarray(self.record[:, which])


@compiled
def _drive(
    parts: Parts,
    memory: np.ndarray,
    work: np.ndarray,
    seen: np.ndarray,
    at_rest: float,
    numbers: tuple[float, ...],
    motion: np.ndarray,
    road: np.ndarray,
    slope: np.ndarray,
    current: np.ndarray,
    step: float,
    first: int,
    end: int,
    record: np.ndarray,
) -> None:
    """The loop from sample ``first`` to ``end``; ``motion``: body, its speed, wheel, its speed, carried."""
    body_mass, wheel_mass, spring, tyre_rate, tyre_damping, low, high = numbers
    load = (body_mass + wheel_mass) * GRAVITY
    body, body_speed, wheel, wheel_speed = motion[0], motion[1], motion[2], motion[3]
    for index in range(first, end):
        x, v = body - wheel, body_speed - wheel_speed
        force = spring * x + seen[plant_kernel.FORCE] - at_rest
        force += STOP_STIFFNESS * (min(x - low, 0.0) + max(x - high, 0.0))
        before = index - 1
        tyre = tyre_rate * (road[before] - wheel) + tyre_damping * (slope[before] - wheel_speed)
        tyre = max(tyre, -load)
        body_change, wheel_change = -force / body_mass, (force + tyre) / wheel_mass
        body += step * (body_speed + 0.5 * step * body_change)
        wheel += step * (wheel_speed + 0.5 * step * wheel_change)
        body_speed += step * body_change
        wheel_speed += step * wheel_change
        record[before, BODY_ACCELERATION], record[before, TYRE_FORCE] = body_change, tyre
        record[index, TRAVEL] = body - wheel
        plant_kernel.advance(
            parts, memory, work, x, v, body - wheel, body_speed - wheel_speed, current[index], step, seen
        )
        record[index, FORCE] = seen[plant_kernel.FORCE]
    motion[0], motion[1], motion[2], motion[3] = body, body_speed, wheel, wheel_speed
