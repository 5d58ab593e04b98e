"""A channel at the stamps of another one: a fast one filtered exactly over the stamps of both, a slow one held."""

import numpy as np

from damper_estimator.signals.butterworth import low_pass
from damper_estimator.signals.channels import ChannelData
from damper_estimator.signals.kinematics import Kinematics


def at_stamps(stamp: np.ndarray, value: np.ndarray, kinematics: Kinematics, cutoff: float) -> np.ndarray:
    """(n,) a causally filtered channel, given by (m,) values at rising stamps, at the stamps of a motion."""
    filtered = np.empty(len(kinematics))
    for part in kinematics.stretches():
        wanted = kinematics.stamp[part]
        first, last = np.searchsorted(stamp, wanted[0], side="right"), np.searchsorted(stamp, wanted[-1])
        grid = _merged(wanted, stamp[first:last])
        dt = np.diff(grid, prepend=grid[0]) / 1e9
        near = slice(max(first - 1, 0), last + 1)
        on_grid = np.interp(grid - wanted[0], stamp[near] - wanted[0], value[near])
        filtered[part] = low_pass(cutoff, dt, on_grid)[np.searchsorted(grid, wanted)]
    return filtered


def in_order(data: ChannelData, skew: float) -> tuple[np.ndarray, np.ndarray]:
    """Stamps corrected for skew and values, ordered by stamp (stable), finite ones only."""
    good = np.isfinite(data.value)
    stamp, value = data.stamp[good] - round(skew * 1e9), data.value[good]
    order = np.argsort(stamp, kind="stable")
    return stamp[order], value[order]


def last_value(data: ChannelData, skew: float, stamp: np.ndarray) -> np.ndarray:
    """The last value of a slow channel at each stamp; NaN before the first."""
    channel_stamp, value = in_order(data, skew)
    index = np.searchsorted(channel_stamp, stamp, side="right") - 1
    return np.where(index >= 0, value[np.maximum(index, 0)] if value.size else np.nan, np.nan)


def _merged(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Stamps of two rising series in order, each once."""
    both = np.concatenate([first, second])
    both.sort(kind="stable")  # two runs: a merge
    return both[np.concatenate([[True], np.diff(both) > 0])]
