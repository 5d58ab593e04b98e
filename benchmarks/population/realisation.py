"""Each phenomenon in several realisations: how a drawn damper is without it, and with how much of it.

"Off" and "on" differ in nothing but the phenomenon. A magnitude m is a physical number around 1; the strength in a
recording is found by looking for m (``cases.py``).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from population.drives import Drive
from population.parts import Plant

Switch = Callable[[float], Plant]


@dataclass(frozen=True)
class Scene:
    """What the drive does to the damper: quantities that realisations are laid out by.

    Attributes:
        pressure: Pa, that 98 % of the pressure differences over the piston stay below.
        low, high: m, quantiles 4 and 96 % of the displacement.
        x: displacement in m, thinned.
    """

    pressure: float
    low: float
    high: float
    x: np.ndarray


def scene_of(drive: Drive, out: np.ndarray) -> Scene:
    """Of a run of the damper as drawn."""
    low, high = np.quantile(drive.x, [0.04, 0.96])
    pressure = np.quantile(np.abs(out[:, 1] - out[:, 2]), 0.98)
    return Scene(float(pressure), float(low), float(high), drive.x[::50])


@dataclass(frozen=True)
class Realisation:
    """One form of a phenomenon in one damper: ``off`` and ``on`` by magnitude, which lies between the bounds."""

    form: str
    off: Switch
    on: Switch
    low: float
    high: float


def plain(form: str, off: Plant, low: float, high: float, **on: Callable[[float], float]) -> Realisation:
    """``off`` whatever the magnitude; on with fields that follow it."""
    return Realisation(form, lambda m: off, lambda m: off._replace(**{k: own(m) for k, own in on.items()}), low, high)
