"""Finds where a sensor ran into the end of its range and was cut off, and how far a filter carries that."""

import numpy as np

_RUN = 4  # equal samples at an extreme, where the signal else changes with every sample
_OVERSHOOT = 16.0  # quanta by which the slope at a run's ends, kept up, would have passed the extreme
_PLATEAU = 0.8  # share of the samples of one sign; a force that rests there longer is level by itself, as friction is
_REACH = 8.0  # time constants of a filter's slowest mode: e^-4 of the envelope is left


def clipped(value: np.ndarray) -> np.ndarray:
    """(m,) bool: samples of ``value`` (m,) that sit at its largest or smallest value because it was cut off there.

    A coarse but unclipped signal also rests on its extremes at its turning points. There its parabola leaves the last
    quantum slowly; an extreme is a limit only where some run at it has ends whose slope, kept up, would have overshot
    by several quanta. Then every sample at it is cut off.
    """
    found = np.zeros(value.size, bool)
    steps = np.abs(np.diff(value))
    quantum = float(steps[steps > 0.0].min()) if np.any(steps > 0.0) else 0.0
    if quantum <= 0.0:
        return found
    middle = 0.5 * (float(value.max()) + float(value.min()))
    for extreme in (value.max(), value.min()):
        at = value == extreme
        side = np.count_nonzero(value > middle if extreme > middle else value < middle)
        if np.count_nonzero(at) <= _PLATEAU * side and _cut_off(value, at, quantum):
            found |= at
    return found


def _cut_off(value: np.ndarray, at: np.ndarray, quantum: float) -> bool:
    """Whether some run of ``at`` has steep ends."""
    edges = np.flatnonzero(np.diff(at.astype(np.int8), prepend=0, append=0))
    first, last = edges[::2], edges[1::2]
    held = int(np.median(np.diff(np.flatnonzero(np.diff(value)), prepend=-1)))  # a logger may repeat every value
    long = last - first >= _RUN * held
    return any(
        _slope_at(value, a, b, 3 * held) * (b - a) > _OVERSHOOT * quantum
        for a, b in zip(first[long].tolist(), last[long].tolist(), strict=True)
    )


def _slope_at(value: np.ndarray, first: int, last: int, reach: int) -> float:
    """Mean change per sample just before and after the run ``first`` to ``last``; the smaller of the two."""
    slopes = []
    if first >= reach:
        slopes.append(abs(float(value[first] - value[first - reach])) / reach)
    if last + reach <= value.size:
        slopes.append(abs(float(value[last - 1] - value[last - 1 + reach])) / reach)
    return min(slopes, default=0.0)


def touched(stamp: np.ndarray, spoiled: np.ndarray, cutoff: float, band: float) -> np.ndarray:
    """(n,) bool: samples whose filtered force a spoiled gauge sample has touched.

    The causal filter at ``cutoff`` carries it forward, the zero-phase one at ``band`` both ways; each until its
    envelope, exp(-pi f t), is down to 2 %.

    Args:
        stamp: (n,) ns, rising.
        spoiled: (k,) ns, rising.
        cutoff, band: Hz; 0 for none.
    """
    if not spoiled.size:
        return np.zeros(stamp.size, bool)
    own, both = (_REACH / (2.0 * np.pi * f) if f > 0.0 else 0.0 for f in (cutoff, band))
    edges = np.zeros(stamp.size + 1, np.int64)
    np.add.at(edges, np.searchsorted(stamp, spoiled - round(both * 1e9)), 1)
    np.add.at(edges, np.searchsorted(stamp, spoiled + round((own + both) * 1e9), side="right"), -1)
    return np.cumsum(edges[:-1]) > 0
