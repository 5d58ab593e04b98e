"""How long a model remembers a start, a fault or a wrong value of a slow channel, measured on its behaviour.

The model is driven by a swept sine, once with the channel steady and once with another value that returns to the steady
one after a second. The largest difference of force in that second shows whether the channel matters; the time after
which a hundredth of it is left is the memory.

Settling is measured on filter and model together: a calm sine, with a quarter of the stroke and speed of the region of
the fit, once with a single start and once restarted every second. The forces differ until the start is forgotten.
"""

import numpy as np

from damper_estimator.model import DamperModel
from damper_estimator.signals.butterworth import STATE_SIZE, differentiate
from damper_estimator.signals.kinematics import WARM_UP
from damper_estimator.signals.layout import COMMAND, DT, PRESSURE, ROWS, TEMPERATURE, A, T, V, X

STEP = 1e-3  # s
STROKE = 0.02  # m
WRONG, AFTER = 1.0, 3.0  # s with the other value, and s to forget it
ENDLESS = 60.0  # s, for a model that remembers for longer
NOTHING = 1e-6  # of the largest force
_LEFT = 0.01
LONGEST_SETTLING = 1.0  # s; a longer memory is ignored
STARTS = 6  # of a probe, each at another point of the motion
_CALM = 0.25  # of the region's half width
_CALM_STROKE, _CALM_SPEED = 0.005, 0.1  # m and m/s, if the fit has no region
_UNSETTLED = 0.02  # of the largest force
# Ordinary values, if the fit has none: A, deg C, Pa.
_ORDINARY = {COMMAND: (0.0, 1.0), TEMPERATURE: (20.0, 80.0), PRESSURE: (1e5, 2e6)}


def memory(model: DamperModel, row: int, bounds: np.ndarray) -> float | None:
    """Time in s for which the force remembers a wrong value of a slow channel; None if it does not depend on it.

    Args:
        row: of the block: COMMAND, TEMPERATURE or PRESSURE.
        bounds: (8, 2), the region of the fit.
    """
    ranges = _ranges(bounds)
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


def settling(model: DamperModel, cutoff: float, bounds: np.ndarray) -> float:
    """Time in s after a start until the force is that of a filter and a model that have run for long: from
    ``WARM_UP`` to ``LONGEST_SETTLING``.

    Args:
        cutoff: Hz of the filter; 0 is none.
        bounds: (8, 2), the region of the fit.
    """
    ranges, longest = _ranges(bounds), WARM_UP
    for share in (0.5, 1.0):
        slow = {row: low + share * (high - low) for row, (low, high) in ranges.items()}
        steady, restarted = (model.force(_calm(cutoff, bounds, slow, restarts)) for restarts in (False, True))
        since = np.arange(steady.size) % round(LONGEST_SETTLING / STEP)
        differs = np.abs(restarted - steady) > _UNSETTLED * np.max(np.abs(steady))  # False if one is NaN
        longest = max(longest, STEP * float(np.max(since[differs], initial=-1) + 1))
    return longest


def _calm(cutoff: float, bounds: np.ndarray, slow: dict[int, float], restarts: bool) -> np.ndarray:
    """A calm sine after the filter as a block (8, n), with steady slow channels; restarted every ``LONGEST_SETTLING``,
    or started only once.
    """
    half = _CALM * 0.5 * np.diff(bounds[[X, V]], axis=1)[:, 0]
    stroke = half[0] if np.isfinite(half[0]) and half[0] > 0.0 else _CALM_STROKE
    speed = half[1] if np.isfinite(half[1]) and half[1] > 0.0 else _CALM_SPEED
    each = round(LONGEST_SETTLING / STEP)
    block = np.full((ROWS, (STARTS + 1) * each), np.nan)
    block[T] = STEP * np.arange(block.shape[1])
    block[DT] = STEP
    block[DT, :: each if restarts else block.shape[1]] = 0.0
    # The period does not divide the time between the starts, so that each is at another point of the motion.
    differentiate(
        cutoff,
        block[DT],
        stroke * np.sin(speed / stroke * block[T]),
        np.zeros(STATE_SIZE),
        block[X],
        block[V],
        block[A],
    )
    for row, value in slow.items():
        block[row] = value
    return block


def _ranges(bounds: np.ndarray) -> dict[int, tuple[float, float]]:
    """Lowest and highest ordinary value of each slow channel."""
    return {r: tuple(bounds[r]) if np.isfinite(bounds[r]).all() else _ORDINARY[r] for r in _ORDINARY}


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
