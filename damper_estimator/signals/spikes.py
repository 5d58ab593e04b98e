"""Finds samples of a channel that leave its course and come back: dropouts, glitches of a bus, a loose plug.

A mass on springs cannot do that; one such sample makes a velocity that is wrong for as long as the filter remembers,
and a fit to it meaningless. A run of samples is a spike if each is off the straight line between its neighbours by
far more than these are off theirs without it, and by far more than other runs of as many samples nearby. A force does
such things at an end stop, so it has to be far outside of everything else as well.

For the analysis of recordings, which knows what follows. The node does not; it holds the last value where a
displacement is impossible (``signals.possible``).
"""

import numpy as np

_LONGEST = 5  # samples
_NEARBY = 40  # samples, on either side of a run
_FAR = 10.0  # times what the neighbours, and other runs nearby, are off
_MOST = 0.8  # of the runs nearby; a fifth may be parts of other spikes
_LEAST = 0.001  # m, smaller ones are noise or resolution
_OUTSIDE = 2.0  # times the range of a force without its outermost thousandth
_STEPS = 6.0  # times the smallest step of the values: a coarse signal that rests between two steps has single ones


def displacement_spikes(stamp: np.ndarray, value: np.ndarray) -> np.ndarray:
    """(n,) bool, the samples of spikes of a displacement (n,) m at rising stamps (n,) ns, all finite."""
    return _spikes(stamp, value, _LEAST)


def force_spikes(stamp: np.ndarray, value: np.ndarray) -> np.ndarray:
    """(n,) bool, the samples of spikes of a force (n,) N at rising stamps (n,) ns, all finite."""
    usual = float(np.ptp(np.quantile(value, [0.001, 0.999]))) if value.size else 0.0
    return _spikes(stamp, value, _OUTSIDE * usual)


def _spikes(stamp: np.ndarray, value: np.ndarray, least: float) -> np.ndarray:
    found = np.zeros(value.size, bool)
    steps = np.abs(np.diff(value))
    least = max(least, _STEPS * float(np.min(steps, where=steps > 0.0, initial=np.inf)))
    if steps.max(initial=0.0) < least:
        return found
    for length in range(1, _LONGEST + 1):
        if value.size < length + 2 * _NEARBY:
            break
        for first in _first_of_runs(stamp, value, length, least):
            found[first : first + length] = True
    return found


def _first_of_runs(stamp: np.ndarray, value: np.ndarray, length: int, least: float) -> np.ndarray:
    """Positions of the first samples of spikes of a length."""
    count = value.size - length - 3
    first = np.arange(2, 2 + count)
    before, after = first - 1, first + length
    off = np.stack([_off(stamp, value, before, first + k, after) for k in range(length)])
    nearest, farthest = off.min(axis=0), off.max(axis=0)
    course = np.maximum(_off(stamp, value, before - 1, before, after), _off(stamp, value, before, after, after + 1))
    places = np.flatnonzero(nearest > np.maximum(_FAR * course, least))
    return first[[place for place in places.tolist() if nearest[place] > _FAR * _nearby(farthest, place, length + 2)]]


def _nearby(distance: np.ndarray, place: int, apart: int) -> float:
    """How far runs nearby are off that have no sample or neighbour in common with one, on the side where it is more.

    A part of them may be further off, because spikes come in bursts.
    """
    sides = distance[max(place - _NEARBY, 0) : max(place - apart, 0)], distance[place + apart : place + _NEARBY]
    return max((float(np.quantile(side, _MOST)) for side in sides if side.size), default=np.inf)


def _off(stamp: np.ndarray, value: np.ndarray, left: np.ndarray, place: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Distance of samples from the lines between two others each."""
    share = (stamp[place] - stamp[left]) / np.maximum(stamp[right] - stamp[left], 1)
    return np.abs(value[place] - value[left] - share * (value[right] - value[left]))
