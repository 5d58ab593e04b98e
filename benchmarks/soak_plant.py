"""The car of the soak: four quarter cars with simulated semi-active dampers on an endless road, sensors, coil drivers.

Independent of the estimator. The dampers warm up as they work, so that a force without the temperature is wrong.
"""

from dataclasses import dataclass, replace

import numpy as np

from damper_estimator.plant import DAMPERS, Damper
from damper_estimator.plant.parts import Heat
from damper_estimator.vehicle import CORNERS
from damper_estimator.vehicle.quarter_car import FORCE, TRAVEL, RunningCar
from damper_estimator.vehicle.road import CLASSES

NAMES = ("front_left", "front_right", "rear_left", "rear_right")
STEP = 1e-4  # s, of the simulation
STRETCH = 1.0  # s of road generated at a time
ROAD_CLASS, SPEED = "B", 20.0  # m/s
ENVELOPE = 0.15  # m, length of the tyre's contact, over which the road is averaged
LEVELLING = 0.2  # 1/s, decay rate of the road's slow rise
LIMITS = (0.0, 1.6)  # A
SAFE = 0.2  # A, the safe current
TEMPERATURE = (-40.0, 150.0, 0.5)  # deg C, range of the sensor, and s after which it is silent
WARMING = (True, True, False, False)  # the rear dampers stay at the temperature of their oil
AMBIENT = (30.0, 45.0, 40.0, 40.0)  # deg C
HOTTEST = 30.0  # K above ambient, approximate balance of work and cooling


def damper(warms: bool, start: float, ambient: float) -> Damper:
    """A magneto-rheological damper far from saturation, whose oil warms up by many kelvins within minutes or not."""
    coil = {"pressure": 15e5, "saturation": 5.0, "reach": 2e-3}
    semi_active = DAMPERS["semi_active"].with_part("oil", bulk_modulus=1.8e9, free_gas=0.0005, viscosity_slope=0.02)
    semi_active = semi_active.with_part("coil", **coil).with_part("seal", force=5.0, per_pressure=1e-6)
    return replace(semi_active, heat=Heat(start, 1.2e-2 if warms else 0.0, 1.0 / 60.0, ambient))


@dataclass(frozen=True)
class Sensors:
    """Noise (rms) and resolution of the sensors."""

    displacement: float = 1.2e-5  # m
    resolution: float = 1e-5  # m
    acceleration: float = 0.3  # m/s^2
    offset: float = 0.05  # m/s^2, of the accelerometer
    gauge: float = 5.0  # N
    temperature: float = 0.1  # K
    current: float = 2e-3  # A

    def displacement_of(self, travel: float, random: np.random.Generator) -> float:
        """The sensor's reading."""
        noisy = travel + self.displacement * random.standard_normal()
        return self.resolution * round(noisy / self.resolution)


@dataclass(frozen=True)
class Sample:
    """The true state of one corner at one moment; SI units, deg C."""

    travel: float
    force: float
    acceleration: float
    temperature: float
    pressure: float
    current: float


class Driver:
    """The driver of one coil: limits, a lag, and its own safe current if commands stop; final.

    Attributes:
        current: A, that flows.
        commanded: A, last command.
        is_on: whether it works; otherwise no current flows.
    """

    DEADLINE, LAG = 0.25, 0.003  # s

    def __init__(self) -> None:
        self.current = self.commanded = SAFE
        self.is_on = True
        self._heard = float("-inf")

    def take(self, command: float, now: float) -> None:
        """A command in A at the time ``now``, s."""
        self.commanded, self._heard = command, now

    def is_alone(self, now: float) -> bool:
        """Whether commands have stopped."""
        return now - self._heard > self.DEADLINE

    def step(self, now: float, step: float) -> float:
        """The current that flows ``step`` s later."""
        target = SAFE if self.is_alone(now) or not np.isfinite(self.commanded) else self.commanded
        target = min(max(target, LIMITS[0]), LIMITS[1]) if self.is_on else 0.0
        self.current += (1.0 - np.exp(-step / self.LAG)) * (target - self.current)
        return self.current


class Road:
    """Height of an ISO 8608 road under one wheel in m, without end; final.

    Its slope is white noise, z' + levelling z = 2 pi n0 (G0 v)^(1/2) w, averaged over the tyre's contact.
    """

    def __init__(self, seed: int, roughness: float = 1.0, step: float = STEP) -> None:
        self._random = np.random.default_rng([seed, 8608])
        self._step, self._height = step, 0.0
        self._strength = roughness * 2.0 * np.pi * 0.1 * np.sqrt(CLASSES[ROAD_CLASS] * SPEED / (2.0 * step))
        self._width = max(round(ENVELOPE / SPEED / step), 1)
        self._recent = np.zeros(self._width)
        self._last = 0.0

    def stretch(self, count: int) -> np.ndarray:
        """The next (count + 1,) heights; the first is the last of the previous stretch."""
        from scipy.signal import lfilter

        decay = 1.0 - LEVELLING * self._step
        slope = self._strength * self._random.standard_normal(count)
        raw, _ = lfilter([self._step], [1.0, -decay], slope, zi=[decay * self._height])
        self._height = raw[-1]
        whole = np.concatenate([self._recent, raw])
        sums = np.cumsum(whole)
        smooth = (sums[self._width :] - sums[: -self._width]) / self._width
        self._recent = whole[-self._width :]
        heights = np.concatenate([[self._last], smooth])
        self._last = heights[-1]
        return heights


class Corner:
    """One quarter car on its road; final."""

    def __init__(self, seed: int, damper: Damper, roughness: float = 1.0) -> None:
        self._road = Road(seed, roughness)
        self._count = round(STRETCH / STEP)
        first = self._road.stretch(self._count)
        self._car = RunningCar(CORNERS["semi_active"], damper, first, STEP, SAFE)
        self._current = np.full(self._count + 1, SAFE)

    def drive(self, steps: int, current: float) -> Sample:
        """Advances the simulation by ``steps`` at a current in A."""
        car = self._car
        if car.index + steps > self._count:
            car.continue_on(self._road.stretch(self._count))
        self._current[car.index : car.index + steps + 1] = current
        car.advance(car.index + steps + 1, self._current)
        here = car.record[max(car.index - steps, 0) : car.index + 1, TRAVEL]
        late = here[-5:]
        bend = (late[-1] - 2.0 * late[2] + late[0]) / (4.0 * STEP**2) if late.size == 5 else 0.0
        return Sample(here[-1], car.record[car.index, FORCE], bend, car.temperature, car.gas_pressure, current)
