"""The size of a phenomenon that changes a recording's force by a wanted share."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from population.damper_phenomena import Realisation
from population.drives import Drive
from population.measurement_chain import FAULTS, Chain, faulty, gauge
from population.plant_parameters import Plant
from population.simulate import force_of, in_band, rms, share

WEAK, MEDIUM, STRONG = 0.04, 0.10, 0.20
LEVELS = {"weak": WEAK, "medium": MEDIUM, "strong": STRONG}
TOLERANCE = 0.15
LEAST_SHOWN = 0.5
"""Of the wanted strength, on the unseen recording, and with a second effect."""


@dataclass(frozen=True)
class Switched:
    """A phenomenon at a strength: damper and chain without it and with it."""

    phenomenon: str
    form: str
    size: float
    strength: float
    off: tuple[Plant, Chain]
    on: tuple[Plant, Chain]


def shown(plant: Plant, chain: Chain, drive: Drive) -> np.ndarray:
    """(n,) N, of the gauge without noise."""
    return gauge(chain, drive, force_of(plant, drive))


def found(strength: Callable[[float], float], wanted: float, low: float, high: float) -> tuple[float, float] | None:
    """Size with the wanted strength, and that strength; None if no size has it."""
    size = min(max(1.0, low), high)
    below, above = low, high
    for _ in range(9):
        reached = strength(size)
        if abs(reached / wanted - 1.0) <= TOLERANCE:
            return size, reached
        if reached < wanted:
            below = max(below, size)
        else:
            above = min(above, size)
        if above <= 1.01 * below:
            return None
        guess = size * min(max(wanted / max(reached, 1e-9), 0.05), 20.0)
        size = guess if 1.02 * below < guess < 0.98 * above else float(np.sqrt(below * above))
    return None


def in_damper(name: str, form: Realisation, chain: Chain, drive: Drive, wanted: float) -> Switched | None:
    """The phenomenon of a damper at the wanted strength."""
    forces: dict[Plant, np.ndarray] = {}

    def force(plant: Plant) -> np.ndarray:
        if plant not in forces:
            forces.clear()
            forces[plant] = force_of(plant, drive)
        return forces[plant]

    def strength(size: float) -> float:
        off = force(form.off(size))
        return share(off, force_of(form.on(size), drive))

    best = found(strength, wanted, form.low, form.high)
    if best is None:
        return None
    size, reached = best
    return Switched(name, form.form, size, reached, (form.off(size), chain), (form.on(size), chain))


def in_chain(
    name: str, form: int, sign: float, plant: Plant, chain: Chain, drive: Drive, wanted: float
) -> Switched | None:
    """The fault of a measurement chain at the wanted strength."""
    force = force_of(plant, drive)
    off = in_band(gauge(chain, drive, force))
    spread = float(in_band(force).std())
    _, forms, low, high = FAULTS[name]

    def strength(size: float) -> float:
        return rms(in_band(gauge(faulty(chain, name, form, sign * size), drive, force)) - off) / spread

    # It starts in the middle of its range, which spans orders of magnitude.
    middle = float(np.sqrt(low * high))
    best = found(lambda size: strength(size * middle), wanted, low / middle, high / middle)
    if best is None:
        return None
    size = sign * best[0] * middle
    return Switched(name, forms[form], size, best[1], (plant, chain), (plant, faulty(chain, name, form, size)))
