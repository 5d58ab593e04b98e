"""Each phenomenon in several realisations: a drawn damper without it, and with it at any magnitude.

"Off" and "on" differ in nothing but the phenomenon. A magnitude m is a physical number around 1; a search for m sets
the strength in a recording (``strength_search.py``).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from population.drives import Drive
from population.plant_parameters import Plant

Switch = Callable[[float], Plant]


@dataclass(frozen=True)
class Scene:
    """The damper under a drive: quantities that determine the realisations.

    Attributes:
        pressure: Pa, 98 % quantile of the pressure differences over the piston.
        low, high: m, quantiles 4 and 96 % of the displacement.
        x: displacement in m, thinned.
        current: mean of the base recording, A: a damper on which the current has no effect is as the other one there.
    """

    pressure: float
    low: float
    high: float
    x: np.ndarray
    current: float


def scene_of(drive: Drive, out: np.ndarray, base: Drive) -> Scene:
    """The scene of a run of the drawn damper; ``base`` is the drive of the base recording."""
    low, high = np.quantile(drive.x, [0.04, 0.96])
    pressure = np.quantile(np.abs(out[:, 1] - out[:, 2]), 0.98)
    return Scene(float(pressure), float(low), float(high), drive.x[::50], float(base.current.mean()))


@dataclass(frozen=True)
class Realisation:
    """One form of a phenomenon in one damper: ``off`` and ``on`` by magnitude, which lies between the bounds."""

    form: str
    off: Switch
    on: Switch
    low: float
    high: float


def plain(form: str, off: Plant, low: float, high: float, **on: Callable[[float], float]) -> Realisation:
    """``off`` for any magnitude; on with fields that depend on it."""
    return Realisation(
        form, lambda m: off, lambda m: off._replace(**{k: field(m) for k, field in on.items()}), low, high
    )
