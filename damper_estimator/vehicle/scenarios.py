"""Scenarios for comparisons of controllers: semi-active dampers in their corners, on roads and single events."""

from dataclasses import dataclass, replace

import numpy as np

from damper_estimator.control import Law, mixed
from damper_estimator.plant import DAMPERS, STEP, Damper
from damper_estimator.plant.excitation import fade
from damper_estimator.plant.parts import Coil, Mount
from damper_estimator.vehicle.quarter_car import CORNERS, QuarterCar
from damper_estimator.vehicle.road import bump_height, pothole_height, road_height

LIMITS = (0.0, 2.0)
"""A, of the coil's driver."""

REST = 1.0
"""s, at rest at the start of every run; the rest of the run is measured."""


@dataclass(frozen=True)
class Corner:
    """A semi-active damper in its corner, with a suitable law."""

    damper: Damper
    car: QuarterCar
    law: Law


_BASE, _LIGHT = DAMPERS["semi_active"], DAMPERS["light_car"]

CORNER_CASES = {
    "semi_active": Corner(_BASE, CORNERS["semi_active"], mixed(6000.0, 0.8)),
    "soft_mount": Corner(
        replace(_BASE, name="soft_mount", mount=Mount(stiffness=1.2e6, damping=1500.0)).with_part(
            "oil", free_gas=0.012
        ),
        CORNERS["semi_active"],
        mixed(6000.0, 0.8),
    ),
    "light_slow": Corner(
        replace(_LIGHT, name="light_slow", coil=Coil(pressure=16e5, saturation=1.0, reach=5e-4, time=0.030)),
        CORNERS["light_car"],
        mixed(2900.0, 0.76),
    ),
}
"""By name: the catalogue's magneto-rheological damper; the same on a soft mount with aerated oil; a light car's damper
with a slow coil that saturates early. The skyhook's damping is 0.6 of the critical one of body on spring, the
groundhook's 0.16 of that of wheel on tyre."""


@dataclass(frozen=True)
class Surface:
    """A road: an ISO 8608 class (``kind`` A to E), ``bump`` or ``pothole``, at a speed in m/s."""

    kind: str
    speed: float

    @property
    def name(self) -> str:
        """In words."""
        what = f"ISO {self.kind}" if len(self.kind) == 1 else self.kind
        return f"{what}, {3.6 * self.speed:.0f} km/h"


SURFACES = (Surface("B", 30.0), Surface("C", 20.0), Surface("D", 10.0), Surface("bump", 8.0), Surface("pothole", 14.0))
"""Roads at typical speeds, and single events."""


def surface_height(surface: Surface, seconds: float, seed: int, step: float = STEP) -> np.ndarray:
    """Height under the wheel in m, shape (seconds / step,); flat for the first second."""
    count = round(seconds / step)
    time = step * np.arange(count)
    height = np.zeros(count)
    if len(surface.kind) == 1:
        first = round(REST / step)
        profile = road_height(surface.kind, surface.speed, count - first, step, seed)
        height[first:] = profile * fade(time[: count - first], 2.0 * seconds, 1.0)
        return height
    random = np.random.default_rng([seed, 17])
    for start in np.arange(REST, seconds - 1.5, 2.5):
        if surface.kind == "bump":
            height += bump_height(random.uniform(0.04, 0.07), random.uniform(0.6, 1.5), surface.speed, time, start)
        else:
            depth, length = random.uniform(0.03, 0.05), random.uniform(0.5, 1.0)
            height += pothole_height(depth, length, 0.2, surface.speed, time, start)
    return height
