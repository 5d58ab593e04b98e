"""On which slow channels a model's force depends, and how long it remembers a wrong value; asked of its behaviour.

The model is driven by a swept sine, once with the channel steady and once with another value that returns to the steady
one after a second. The largest difference of force in that second tells whether the channel matters, the time after
which a hundredth of it is left is the memory.
"""

import numpy as np

from damper_estimator.model import DamperModel
from damper_estimator.signals.layout import COMMAND, DT, PRESSURE, ROWS, TEMPERATURE, A, T, V, X

STEP = 1e-3  # s
STROKE = 0.02  # m
WRONG, AFTER = 1.0, 3.0  # s with the other value, and s to forget it
ENDLESS = 60.0  # s, for a model that has not forgotten by then
NOTHING = 1e-6  # of the largest force
_LEFT = 0.01
# Ordinary values, where the fit has none: A, deg C, Pa.
_ORDINARY = {COMMAND: (0.0, 1.0), TEMPERATURE: (20.0, 80.0), PRESSURE: (1e5, 2e6)}


def memory(model: DamperModel, row: int, bounds: np.ndarray) -> float | None:
    """How many seconds the force remembers a wrong value of a slow channel; None where it does not depend on it.

    Args:
        row: of the block: COMMAND, TEMPERATURE or PRESSURE.
        bounds: (8, 2), the region of the fit.
    """
    ranges = {r: bounds[r] if np.isfinite(bounds[r]).all() else _ORDINARY[r] for r in _ORDINARY}
    steady = swept_sine(WRONG + AFTER)
    for other, (low, high) in ranges.items():
        steady[other] = 0.5 * (low + high)
    low, high = ranges[row]
    undisturbed, differences = model.force(steady), []
    for value in (low, high) if low < high else (low - 1.0, low + 1.0):
        disturbed = steady.copy()
        disturbed[row, steady[T] < WRONG] = value
        differences.append(np.nan_to_num(np.abs(model.force(disturbed) - undisturbed)))
    difference = np.max(differences, axis=0)
    during, after = difference[steady[T] < WRONG], difference[steady[T] >= WRONG]
    largest = float(during.max())
    if not largest > NOTHING * float(np.max(np.nan_to_num(np.abs(undisturbed)), initial=1.0)):
        return None
    left = np.flatnonzero(after > _LEFT * largest)
    if left.size and left[-1] == after.size - 1:
        return ENDLESS
    return STEP * float(left[-1] + 1) if left.size else 0.0


def swept_sine(seconds: float) -> np.ndarray:
    """A motion of 20 mm, swept from 0.5 to 6 Hz in every second, as a block (8, n) without slow channels."""
    time = np.arange(0.0, seconds, STEP)
    within = time % 1.0
    block = np.full((ROWS, time.size), np.nan)
    block[T], block[DT] = time, STEP
    block[DT, 0] = 0.0
    block[X] = STROKE * np.sin(2.0 * np.pi * (0.5 * within + 2.75 * within**2))
    block[V] = np.gradient(block[X], STEP)
    block[A] = np.gradient(block[V], STEP)
    return block
