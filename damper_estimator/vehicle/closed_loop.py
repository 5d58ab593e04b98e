"""A quarter car with a simulated semi-active damper, sensors and a controller in the loop.

The plant runs at a fine step. At each sample of the sensors the controller receives the displacement (noisy, quantised,
through the estimator's filter) and the body's acceleration (noisy, with an offset); its current reaches the coil's
driver after a latency, and the coil's field follows with the plant's lag, which is hidden from controllers.
"""

from dataclasses import dataclass

import numpy as np

from damper_estimator.control import Action, CornerController, Law
from damper_estimator.plant import STEP, Damper, Drive
from damper_estimator.plant import kernel as plant_kernel
from damper_estimator.plant.damper import parts_of
from damper_estimator.plant.simulation import rest
from damper_estimator.runtime import DamperEstimator
from damper_estimator.vehicle.quarter_car import BODY_ACCELERATION, FORCE, TRAVEL, TYRE_FORCE, QuarterCar, RunningCar


@dataclass(frozen=True)
class CornerSensors:
    """Errors of the controller's inputs, and the latency of its output."""

    rate: float = 500.0  # Hz
    displacement_noise: float = 1.2e-5  # m, rms
    displacement_step: float = 1.0e-5  # m, quantisation
    acceleration_noise: float = 0.03  # m/s^2, rms
    acceleration_offset: float = 0.05  # m/s^2
    latency: float = 1e-3  # s, from the sample to the coil's driver


@dataclass(frozen=True)
class Ride:
    """A run; arrays (n,) every ``step`` s. Forces in N are those of the damper alone, with its gas force.

    Attributes:
        travel: m, positive in extension.
        force: of the damper.
        wanted: the force that the controller desired, held from sample to sample.
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


@dataclass(frozen=True)
class Sensed:
    """The controller's inputs at one moment.

    Attributes:
        stamp: ns since the start of the ride.
        travel: m, of the displacement sensor.
        felt: m/s^2, of the body's accelerometer.
        current: A, of the driver.
    """

    stamp: int
    travel: float
    felt: float
    current: float


class RunningRide:
    """A ride from sample to sample of the sensors: a controller calls `sense` and answers with `act`; final."""

    def __init__(
        self,
        car: QuarterCar,
        damper: Damper,
        road: np.ndarray,
        sensors: CornerSensors = CornerSensors(),
        seed: int = 0,
        current: float = 0.0,
        step: float = STEP,
    ):
        """Arguments as `ride`."""
        self._running = RunningCar(car, damper, road, step, current)
        self._current, self._wanted = np.full(road.size, current), np.full(road.size, np.nan)
        self._random = np.random.default_rng([seed, 13])
        self._between, self._late = round(1.0 / (sensors.rate * step)), round(sensors.latency / step)
        self._car, self._sensors, self._step = car, sensors, step
        self._index = -self._between

    @property
    def rest_force(self) -> float:
        """Of the damper, N."""
        return self._running.rest_force

    def sense(self) -> Sensed | None:
        """Drives to the next sample; None at the end of the road."""
        self._index += self._between
        index, running, sensors = self._index, self._running, self._sensors
        if index >= self._current.size:
            running.advance(self._current.size, self._current)
            return None
        if index:
            running.advance(index + 1, self._current)
        travel = running.record[index, TRAVEL] + sensors.displacement_noise * self._random.standard_normal()
        resolution = sensors.displacement_step
        travel = resolution * round(travel / resolution) if resolution > 0.0 else travel
        felt = running.record[max(index - 1, 0), BODY_ACCELERATION] + sensors.acceleration_offset
        felt += sensors.acceleration_noise * self._random.standard_normal()
        return Sensed(round(1e9 * index * self._step), float(travel), float(felt), float(self._current[index]))

    def act(self, action: Action) -> None:
        """The controller's answer to the last sample; its current holds until the next one."""
        first = self._index + 1 + self._late
        self._current[first : first + self._between] = action.current
        self._wanted[self._index : self._index + self._between] = action.wanted

    def ride(self) -> Ride:
        """The completed part of the ride."""
        running = self._running
        return Ride(
            self._step,
            running.column(TRAVEL),
            running.column(FORCE),
            self._wanted,
            self._current,
            running.column(BODY_ACCELERATION),
            running.column(TYRE_FORCE),
            self._car.static_load,
        )


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
        estimator: a new one; filters the displacement and computes the controller's kinematics.
        seed: of the sensors' noise.
        current: A, before the controller's first answer.
    """
    running = RunningRide(car, damper, road, sensors, seed, current, step)
    while (sensed := running.sense()) is not None:
        estimates = estimator.block(np.array([sensed.stamp]), np.array([sensed.travel]), sensed.current)
        running.act(controller.step(estimates.kinematics.block[:, 0], sensed.felt))
    return running.ride()


def desired_force(ride: Ride, law: Law, rest_force: float) -> np.ndarray:
    """(n,) N, the force of a law at the true velocities of a ride from rest, without a sensor's errors or delay."""
    a = ride.body_acceleration
    body = ride.step * np.concatenate([[0.0], np.cumsum(0.5 * (a[1:] + a[:-1]))])
    wheel = body - np.gradient(ride.travel, ride.step)
    return rest_force + np.asarray(law.force(body, wheel))


def attainable(damper: Damper, travel: np.ndarray, limits: tuple[float, float], step: float) -> np.ndarray:
    """Lowest and highest attainable force (2, n) in N of the damper on this motion (m, (n,)).

    It is run through the whole motion with its coil constantly at the lower, and at the upper current: the lag, which
        no controller can avoid, does not count.
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
