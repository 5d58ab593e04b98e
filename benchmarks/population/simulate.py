"""Runs a plant over a drive."""

from collections.abc import Callable

import numpy as np

from population import magneto, monotube, twin_tube
from population.drives import RATE, Drive
from population.plant_parameters import Plant

KERNELS = (twin_tube.integrate, monotube.integrate, magneto.integrate)


class Unstable(Exception):
    """A drawn damper that cannot be simulated."""


def run(plant: Plant, drive: Drive) -> np.ndarray:
    """(n, 4): force in N, pressures of rebound, compression and gas in Pa.

    Raises:
        Unstable: if the result is not finite or implausible for a damper.
    """
    if plant.mount_form:
        plant = plant._replace(rod_mass=max(plant.rod_mass, lightest(plant)))
    out = np.empty((drive.x.size, 4))
    KERNELS[plant.family](plant, drive.x, drive.v, drive.a, drive.temperature, drive.current, 1.0 / RATE, out)
    if not np.isfinite(out).all() or np.abs(out[:, 0]).max() > 1e5:
        raise Unstable(f"force up to {np.abs(out[:, 0]).max():.3g} N")
    return out


def lightest(plant: Plant) -> float:
    """kg, smallest mass of the rod behind its joint for the simulation's step; the same for any joint."""
    annulus = plant.piston - plant.rod
    chamber = annulus**2 * plant.bulk / (plant.rebound_volume - annulus * 0.8 * plant.stroke)
    return (3.0 * plant.mount + chamber + plant.rub_stiffness) / (1.2 * RATE**2)


def force_of(plant: Plant, drive: Drive) -> np.ndarray:
    """(n,) N."""
    return run(plant, drive)[:, 0]


def in_band(values: np.ndarray, rate: float = RATE, cutoff: float = 30.0) -> np.ndarray:
    """(n,) the part of a signal below ``cutoff`` Hz; the band in which recordings are judged."""
    frequency = np.fft.rfftfreq(values.size, 1.0 / rate)
    smooth = 1.0 / (1.0 + (frequency / cutoff) ** 8)
    return np.fft.irfft(np.fft.rfft(values) * smooth, values.size)


def rms(values: np.ndarray) -> float:
    """About zero."""
    return float(np.sqrt(np.mean(values * values)))


def share(off: np.ndarray, on: np.ndarray) -> float:
    """Strength: rms of the in-band difference over that of the force about its mean."""
    force = in_band(on)
    return rms(in_band(on - off)) / float(force.std())


Force = Callable[[Plant, Drive], np.ndarray]
