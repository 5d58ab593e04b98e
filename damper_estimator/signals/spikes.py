"""Finds samples of a channel that leave its course and come back: dropouts, glitches of a bus, a loose plug.

A mass on springs cannot do that; one such sample makes a velocity that is wrong for as long as the filter remembers,
and a fit to it meaningless. A run of samples is a spike if each is off the straight line between its neighbours by
far more than these are off theirs without it, and by far more than other runs of as many samples nearby. A force does
such things at an end stop, so it has to be far outside of everything else as well.

For the analysis of recordings, which knows what follows. The node does not; it holds the last value where a
displacement is impossible (``signals.possible``), and such runs of up to 0.1 s are spikes as well if they come back.
"""

from collections.abc import Callable, Iterator

import numpy as np

from damper_estimator.signals.admission import DEFAULT_MAX_GAP, DUPLICATE, Admission
from damper_estimator.signals.at_stamps import in_order
from damper_estimator.signals.channels import ChannelData
from damper_estimator.signals.possible import STATE_SIZE, keep_possible

_LONGEST = 5  # samples
_NEARBY = 40  # samples, on either side of a run
_FAR = 10.0  # times what the neighbours, and other runs nearby, are off
_MOST = 0.8  # of the runs nearby; a fifth may be parts of other spikes
_LEAST = 0.001  # m, smaller ones are noise or resolution
_OUTSIDE = 2.0  # times the range of a force without its outermost thousandth
_RETURN = 0.5  # of the way out: what stays further away has another zero
_ANOTHER_UNIT = 0.05  # share of impossible samples from which on all are in another unit
_STEPS = 6.0  # times the smallest step of the values: a coarse signal that rests between two steps has single ones


Course = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Stamps (n,) ns and values (n,) of a channel in order of stamp without its spikes, and the stamps (k,) of these."""


def displacement_course(data: ChannelData, skew: float = 0.0) -> Course:
    """Of a displacement, stamps corrected for skew in s."""
    return _course(data, skew, displacement_spikes)


def force_course(data: ChannelData, skew: float = 0.0) -> Course:
    """Of a force, stamps corrected for skew in s."""
    return _course(data, skew, force_spikes)


def _course(data: ChannelData, skew: float, spikes: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Course:
    stamp, value = in_order(data, skew)
    wild = spikes(stamp, value)
    return stamp[~wild], value[~wild], stamp[wild]


def displacement_spikes(stamp: np.ndarray, value: np.ndarray) -> np.ndarray:
    """(n,) bool, the samples of spikes of a displacement (n,) m at rising stamps (n,) ns, all finite."""
    return _spikes(stamp, value, _LEAST) | _dropouts(stamp, value)


def force_spikes(stamp: np.ndarray, value: np.ndarray) -> np.ndarray:
    """(n,) bool, the samples of spikes of a force (n,) N at rising stamps (n,) ns, all finite."""
    return _spikes(stamp, value, _OUTSIDE * usual_range(value))


def usual_range(value: np.ndarray) -> float:
    """From the lowest to the highest of finite values (n,), without the outermost thousandth; 0 without values."""
    return float(np.ptp(np.quantile(value, [0.001, 0.999]))) if value.size else 0.0


def _dropouts(stamp: np.ndarray, value: np.ndarray) -> np.ndarray:
    """(n,) bool, runs of impossible displacements that come back."""
    found = np.zeros(value.size, bool)
    verdict, dt = Admission(DEFAULT_MAX_GAP).block(stamp, value)
    used = value.copy()
    keep_possible(value, verdict, dt, np.zeros(STATE_SIZE), used)
    impossible = (used != value) & (verdict < DUPLICATE)
    if np.count_nonzero(impossible) > _ANOTHER_UNIT * value.size:
        return found
    edges = np.flatnonzero(np.diff(impossible, prepend=False, append=False))
    for first, last in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        if 0 < first and last < value.size:
            out = np.abs(value[first : last + 1] - value[first - 1])
            # Until some samples follow each other the first ones that are back are not believed.
            found[first:last] = (out[:-1] > _RETURN * out.max()) & (out[-1] < _RETURN * out.max())
    return found


def _spikes(stamp: np.ndarray, value: np.ndarray, least: float) -> np.ndarray:
    found = np.zeros(value.size, bool)
    steps, bend = np.abs(np.diff(value)), np.abs(np.diff(value, 2))
    least = max(least, _STEPS * float(np.min(steps, where=steps > 0.0, initial=np.inf)))
    for length in range(1, _LONGEST + 1):
        count = value.size - length - 3
        if count < 2 * _NEARBY:
            break
        bends = np.maximum(bend[:count], bend[1 + length : 1 + length + count])  # where a run begins, or after it
        for first in _first_of_runs(stamp, value, 2 + np.flatnonzero(bends >= 0.5 * least), length, least):
            found[first : first + length] = True
    return found


def _first_of_runs(stamp: np.ndarray, value: np.ndarray, first: np.ndarray, length: int, least: float) -> Iterator[int]:
    """Of positions (k,), those of the first samples of spikes of a length."""
    before, after = first - 1, first + length
    nearest = _distances(stamp, value, first, length).min(axis=0)
    course = np.maximum(_off(stamp, value, before - 1, before, after), _off(stamp, value, before, after, after + 1))
    for k in np.flatnonzero(nearest > np.maximum(_FAR * course, least)).tolist():
        if nearest[k] > _FAR * _nearby(stamp, value, int(first[k]), length):
            yield int(first[k])


def _nearby(stamp: np.ndarray, value: np.ndarray, first: int, length: int) -> float:
    """How far runs nearby are off that have no sample or neighbour in common with one, on the side where it is more.

    A part of them may be further off, because spikes come in bursts.
    """
    apart = length + 2
    sides = np.arange(first - _NEARBY, first - apart), np.arange(first + apart, first + _NEARBY)
    inside = (side[(side >= 1) & (side < value.size - length)] for side in sides)
    far = [_distances(stamp, value, side, length).max(axis=0) for side in inside if side.size]
    return max((float(np.quantile(one, _MOST)) for one in far), default=np.inf)


def _distances(stamp: np.ndarray, value: np.ndarray, first: np.ndarray, length: int) -> np.ndarray:
    """(length, k) distances of the samples of runs from the lines between the neighbours of each run."""
    return np.stack([_off(stamp, value, first - 1, first + k, first + length) for k in range(length)])


def _off(stamp: np.ndarray, value: np.ndarray, left: np.ndarray, place: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Distance of samples from the lines between two others each."""
    share = (stamp[place] - stamp[left]) / np.maximum(stamp[right] - stamp[left], 1)
    return np.abs(value[place] - value[left] - share * (value[right] - value[left]))
