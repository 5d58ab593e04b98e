"""Quarter car: body and wheel on a road, with the simulated damper between them.

With z upwards, x = z_body - z_wheel (extension) and everything measured from the loaded rest:

    m_body z_body'' = -k x - F - stops(x)
    m_wheel z_wheel'' = k x + F + stops(x) + tyre,     tyre = max(k_t (z_road - z_wheel) + c_t (..)', -static load)

F is the damper's force less its force at rest. The tyre can leave the road. Car and damper take turns: the car moves
with the damper's last force, the damper follows. That is accurate to the first order of the step, and at 0.1 ms far
better than a road is known.
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


CORNERS = {
    "passenger_front": QuarterCar(380.0, 42.0, 24000.0, 210000.0, 120.0),
    "rally_rear": QuarterCar(330.0, 48.0, 34000.0, 240000.0, 150.0),
    "light_car": QuarterCar(220.0, 28.0, 15000.0, 160000.0, 80.0),
    "semi_active": QuarterCar(480.0, 48.0, 30000.0, 250000.0, 150.0),
}
"""The corner that each damper of the catalogue was made for."""


def suspension_travel(
    car: QuarterCar, damper: Damper, road: np.ndarray, current: np.ndarray, step: float
) -> np.ndarray:
    """Damper displacement in m, from rest on a road of height ``road`` (m), with a coil current (A); all (n,)."""
    parts = parts_of(damper)
    travel = np.zeros(road.size)
    limits = (-0.7 * damper.geometry.compression_stroke, 0.7 * damper.geometry.rebound_stroke)
    numbers = (car.body_mass, car.wheel_mass, car.spring_rate, car.tyre_rate, car.tyre_damping, *limits)
    _drive(parts, rest(parts, 0.0, float(current[0])), numbers, road, np.gradient(road, step), current, step, travel)
    return travel


@compiled
def _drive(
    parts: Parts,
    memory: np.ndarray,
    numbers: tuple[float, ...],
    road: np.ndarray,
    slope: np.ndarray,
    current: np.ndarray,
    step: float,
    travel: np.ndarray,
) -> None:
    """The loop over a record; writes the displacement to ``travel``."""
    body_mass, wheel_mass, spring, tyre_rate, tyre_damping, low, high = numbers
    load = (body_mass + wheel_mass) * GRAVITY
    work = np.zeros((plant_kernel.WORK_ROWS, 7))
    seen = np.zeros(plant_kernel.OUT_ROWS)
    plant_kernel.observe(parts, memory, 0.0, 0.0, seen)
    at_rest = seen[plant_kernel.FORCE]
    body, body_speed, wheel, wheel_speed = 0.0, 0.0, 0.0, 0.0
    for index in range(1, len(road)):
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
        travel[index] = body - wheel
        plant_kernel.advance(
            parts, memory, work, x, v, travel[index], body_speed - wheel_speed, current[index], step, seen
        )
