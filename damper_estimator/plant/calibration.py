"""The magnitude of a phenomenon that changes the force by a wanted share.

Forces are compared below 30 Hz, like models: a rod that rings on its mount at 60 Hz does not count.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import exp, log

import numpy as np
from scipy import signal

from damper_estimator.plant.damper import Damper
from damper_estimator.plant.phenomena import PHENOMENA, Phenomenon, Setup
from damper_estimator.plant.sensors import ideal_force
from damper_estimator.plant.simulation import Drive, Truth, simulate

TOLERANCE = 0.02
"""Relative deviation from the wanted strength at which the search ends."""

MOST_TRIALS = 14

BAND = 30.0
"""Hz, above which forces are not compared."""


@dataclass(frozen=True)
class Calibration:
    """Signed magnitude of a phenomenon and its strength on one record."""

    phenomenon: str
    magnitude: float
    strength: float


def relative_difference(off: np.ndarray, on: np.ndarray) -> float:
    """RMS(F_on - F_off) / RMS(F_on); forces in N, shape (n,)."""
    return float(np.sqrt(np.mean((on - off) ** 2) / np.mean(on**2)))


def strength(off: Setup, on: Setup, drive: Drive) -> float:
    """Relative difference of the noise-free forces of two setups under one drive, in band."""
    return relative_difference(
        in_band(ideal_force(simulate(off.damper, drive), off.sensors), drive.step),
        in_band(ideal_force(simulate(on.damper, drive), on.sensors), drive.step),
    )


def in_band(force: np.ndarray, step: float) -> np.ndarray:
    """A force (n,) every ``step`` seconds below ``BAND``: third-order Butterworth, forward and backward."""
    sections = signal.butter(3, BAND, fs=1.0 / step, output="sos")
    return signal.sosfiltfilt(sections, force, padlen=min(3 * round(1.0 / (BAND * step)), force.size - 1))


def calibrate(name: str, setup: Setup, drive: Drive, wanted: float, sign: float = 1.0) -> Calibration:
    """Finds the magnitude at which a phenomenon has the ``wanted`` strength on this record, as nearly as possible.

    Strength is assumed to grow with magnitude. ``sign`` applies only to errors of the measurement chain. If the record
    does not excite the phenomenon enough, the magnitude is the highest physical one, and the reached strength is
    smaller.

    Raises:
        ValueError: if ``wanted`` is not between 0 and 1.
        KeyError: for an unknown phenomenon.
    """
    if not 0.0 < wanted < 1.0:
        raise ValueError(f"strength {wanted:g} is not between 0 and 1")
    phenomenon = PHENOMENA[name]
    factor = sign if phenomenon.signed else 1.0
    reach = _Reach(phenomenon, setup, drive, factor)
    place, reached = _search(reach, log(phenomenon.lowest), log(phenomenon.highest), log(wanted))
    return Calibration(name, factor * exp(place), exp(reached))


class _Reach:
    """Logarithm of the strength as a function of that of the magnitude; simulates the off state again only if it
    changes."""

    def __init__(self, phenomenon: Phenomenon, setup: Setup, drive: Drive, factor: float) -> None:
        self._phenomenon, self._setup, self._drive, self._factor = phenomenon, setup, drive, factor
        self._truths: dict[Damper, Truth] = {}

    def __call__(self, place: float) -> float:
        magnitude = self._factor * exp(place)
        off, on = self._phenomenon.off(self._setup, magnitude), self._phenomenon.on(self._setup, magnitude)
        without = in_band(ideal_force(self._truth(off.damper), off.sensors), self._drive.step)
        again = self._truths[off.damper] if on.damper == off.damper else simulate(on.damper, self._drive)
        changed = in_band(ideal_force(again, on.sensors), self._drive.step)
        return log(max(relative_difference(without, changed), 1e-12))

    def _truth(self, damper: Damper) -> Truth:
        if damper not in self._truths:
            self._truths = {damper: simulate(damper, self._drive)}  # one at a time: a minute needs 50 MB
        return self._truths[damper]


def _search(reach: Callable[[float], float], low: float, high: float, wanted: float) -> tuple[float, float]:
    """Argument and value nearest to ``wanted``: secant steps, with bisection where they leave the bracket."""
    place, slope, top = 0.0, 1.0, high
    tried: list[tuple[float, float]] = []
    for _ in range(MOST_TRIALS):
        value = reach(place)
        if tried and place != tried[-1][0]:
            slope = (value - tried[-1][1]) / (place - tried[-1][0])
        tried.append((place, value))
        if abs(value - wanted) < TOLERANCE or (place == top and value < wanted):
            break
        low, high = (place, high) if value < wanted else (low, place)
        guess = place + (wanted - value) / slope if slope > 0.05 else np.inf
        if guess >= top and high == top:
            place = top
        else:
            place = guess if low < guess < high else 0.5 * (low + high)
    return min(tried, key=lambda pair: abs(pair[1] - wanted))
