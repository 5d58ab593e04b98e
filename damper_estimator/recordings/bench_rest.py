"""Rest at both ends of a bench test, and the position at rest."""

from dataclasses import dataclass

import numpy as np

_NOISE = 8.0  # standard deviations of the sensor's noise that count as motion
_QUANTA = 3.5  # steps of its resolution: noise moves both the position at rest and a sample by one or two
_STROKE = 0.005  # share of the stroke
_BLOCK = 16  # samples
_SETTLED = 5  # samples that determine the position at rest


@dataclass(frozen=True)
class Motion:
    """Rows ``start`` to ``stop`` (exclusive) of motion; all rows without rest, or without motion."""

    start: int
    stop: int


def find_motion(position: np.ndarray) -> Motion:
    """Finds where the displacement first leaves its position at rest, and last returns to it.

    Motion differs from the first (last) position by more than the sensor's noise (from second differences, which motion
    hardly affects, where the record is quietest), its resolution, and 0.5 % of the stroke.

    Args:
        position: displacement (n,), in any unit; NaN counts as rest.
    """
    known = np.flatnonzero(np.isfinite(position))
    values = position[known]
    if len(values) < 2 * _SETTLED:
        return Motion(0, len(position))
    moving = np.flatnonzero(np.abs(_without_spikes(values) - np.median(values[:_SETTLED])) > _threshold(values))
    returning = np.flatnonzero(np.abs(_without_spikes(values) - np.median(values[-_SETTLED:])) > _threshold(values))
    if not len(moving) or not len(returning):
        return Motion(0, len(position))
    ends = sorted((int(known[moving[0]]), int(known[returning[-1]])))  # a single step returns before it leaves
    return Motion(ends[0], ends[1] + 1)


def rest_position(position: np.ndarray, motion: Motion) -> float:
    """The median position before the motion, else after it, else over all."""
    for part in (position[: motion.start], position[motion.stop :], position):
        known = part[np.isfinite(part)]
        if len(known) >= _SETTLED:
            return float(np.median(known))
    return 0.0


def middle_position(position: np.ndarray) -> float:
    """Half way between the ends of the stroke (1 % of the samples beyond either)."""
    known = position[np.isfinite(position)]
    return float(np.percentile(known, (1, 99)).mean()) if len(known) else 0.0


def _threshold(values: np.ndarray) -> float:
    noise = 1.4826 * _quietest(np.abs(np.diff(values, 2))) / np.sqrt(6.0)
    steps = np.abs(np.diff(values))
    quantum = steps[steps > 0].min(initial=np.inf)
    stroke = np.ptp(np.percentile(values, (1, 99)))
    return max(_NOISE * noise, _QUANTA * quantum if np.isfinite(quantum) else 0.0, _STROKE * stroke)


def _quietest(values: np.ndarray) -> float:
    """The median in the quietest tenth of short blocks: the sensor's noise, if the test has a rest."""
    blocks = values[: len(values) // _BLOCK * _BLOCK].reshape(-1, _BLOCK)
    return float(np.percentile(np.median(blocks, axis=1), 10)) if len(blocks) else float(np.median(values))


def _without_spikes(values: np.ndarray) -> np.ndarray:
    """The median of each sample and its neighbours."""
    inner = np.median([values[:-2], values[1:-1], values[2:]], axis=0)
    return np.concatenate([values[:1], inner, values[-1:]])
