"""A quarter car with a simulated semi-active damper, sensors and a controller in the loop.

The plant runs at its own fine step. Once per sample of the sensors the controller is told the displacement (noisy,
quantised, through the estimator's filter) and the body's acceleration (noisy, with an offset); its current reaches the
coil's driver a latency later, and the coil's field follows with the plant's own lag, which no controller sees.
"""

from dataclasses import dataclass

import numpy as np

from damper_estimator.control import CornerController
from damper_estimator.model.estimator import DamperEstimator
from damper_estimator.plant import STEP, Damper, Drive
from damper_estimator.plant import kernel as plant_kernel
from damper_estimator.plant.damper import parts_of
from damper_estimator.plant.simulation import rest
from damper_estimator.vehicle.quarter_car import BODY_ACCELERATION, FORCE, TRAVEL, TYRE_FORCE, QuarterCar, RunningCar


@dataclass(frozen=True)
class CornerSensors:
    """What the controller sees, and when its answer arrives."""

    rate: float = 500.0  # Hz
    displacement_noise: float = 1.2e-5  # m, rms
    displacement_step: float = 1.0e-5  # m, quantisation
    acceleration_noise: float = 0.03  # m/s^2, rms
    acceleration_offset: float = 0.05  # m/s^2
    latency: float = 1e-3  # s, from the sample to the coil's driver


@dataclass(frozen=True)
class Ride:
    """A run; arrays (n,) every ``step`` s. Forces in N as of the damper alone, its gas force included.

    Attributes:
        travel: m, positive in extension.
        force: of the damper.
        wanted: the wish, held from the sample on at which it was made.
        current: A, as set by the driver.
        body_acceleration: m/s^2.
        tyre_force: N, change from the static load.
        static_load: N.
    """

    step: float
    travel: np.ndarray
    force: np.ndarray
    wanted: np.ndarray
    current: np.ndarray
    body_acceleration: np.ndarray
    tyre_force: np.ndarray
    static_load: float

    @property
    def time(self) -> np.ndarray:
        """Seconds from the start."""
        return self.step * np.arange(self.travel.size)


def ride(
    car: QuarterCar,
    damper: Damper,
    road: np.ndarray,
    controller: CornerController,
    estimator: DamperEstimator,
    sensors: CornerSensors = CornerSensors(),
    seed: int = 0,
    current: float = 0.0,
    step: float = STEP,
) -> Ride:
    """Drives over a road of height ``road`` (n,) in m, from rest at a coil current.

    Args:
        estimator: fresh; filters the displacement and makes the kinematics that the controller sees.
        seed: of the sensors' noise.
        current: A, before the controller's first answer.
    """
    running = RunningCar(car, damper, road, step, current)
    set_current, wanted = np.full(road.size, current), np.full(road.size, np.nan)
    random = np.random.default_rng([seed, 13])
    between, late = round(1.0 / (sensors.rate * step)), round(sensors.latency / step)
    resolution = sensors.displacement_step
    for index in range(0, road.size, between):
        if index:
            running.advance(index + 1, set_current)
        travel = running.record[index, TRAVEL] + sensors.displacement_noise * random.standard_normal()
        travel = resolution * round(travel / resolution) if resolution > 0.0 else travel
        felt = running.record[max(index - 1, 0), BODY_ACCELERATION] + sensors.acceleration_offset
        felt += sensors.acceleration_noise * random.standard_normal()
        stamp = round(1e9 * index * step)
        kinematics = estimator.block(np.array([stamp]), np.array([travel]), set_current[index]).kinematics
        action = controller.step(kinematics.block[:, 0], felt)
        first = index + 1 + late
        set_current[first : first + between] = action.current
        wanted[index : index + between] = action.wanted
    running.advance(road.size, set_current)
    return Ride(
        step,
        running.column(TRAVEL),
        running.column(FORCE),
        wanted,
        set_current,
        running.column(BODY_ACCELERATION),
        running.column(TYRE_FORCE),
        car.static_load,
    )


def attainable(damper: Damper, travel: np.ndarray, limits: tuple[float, float], step: float) -> np.ndarray:
    """Lowest and highest force (2, n) in N that the damper could have given on this motion (m, (n,)).

    It is run through the whole motion with its coil steadily at the lower, and at the upper current: the lag is not
    counted, which no controller can go round.
    """
    drive = Drive("given", step, travel, np.zeros_like(travel))
    forces = []
    for current in limits:
        parts = parts_of(damper)
        memory, work = rest(parts, float(travel[0]), current), np.zeros((plant_kernel.WORK_ROWS, 7))
        out = np.empty((travel.size, plant_kernel.OUT_ROWS))
        steady = np.full_like(travel, current)
        plant_kernel.integrate(parts, memory, work, travel, drive.velocity, steady, step, out)
        forces.append(out[:, plant_kernel.FORCE])
    return np.sort(np.array(forces), axis=0)
