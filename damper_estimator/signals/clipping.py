"""Finds where a sensor was clipped at the end of its range, and how far a filter spreads the error."""

import numpy as np

_RUN = 4  # equal samples at an extreme of a signal that otherwise changes with every sample
_OVERSHOOT = 6.0  # quanta by which a parabola with the slopes at a run's ends rises above it
_PLATEAU = 0.8  # share of the samples of one sign; a force that rests there longer is really constant, as friction
_REACH = 8.0  # time constants of a filter's slowest mode, after which e^-4 of the envelope is left


def clipped(value: np.ndarray) -> np.ndarray:
    """(m,) bool: samples of ``value`` (m,) at its largest or smallest value because it was clipped there.

    A coarse but unclipped signal also rests on its extremes at its turning points. There its parabola leaves the last
    quantum slowly; an extreme is a limit only if the parabola with the slopes at the ends of some run at it rises above
    it by several quanta. Then every sample at it is clipped.
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
        if np.count_nonzero(at) <= _PLATEAU * side and _has_steep_run(value, at, quantum):
            found |= at
    return found


def _has_steep_run(value: np.ndarray, at: np.ndarray, quantum: float) -> bool:
    """Whether some run of ``at`` has steep ends."""
    edges = np.flatnonzero(np.diff(at.astype(np.int8), prepend=0, append=0))
    first, last = edges[::2], edges[1::2]
    if (last - first).max(initial=0) < _RUN:
        return False
    repeats = int(np.median(np.diff(np.flatnonzero(np.diff(value)), prepend=-1)))  # a logger can repeat every value
    long = last - first >= _RUN * repeats
    reach = 3 * repeats
    return any(
        _rise(_slope_at(value, a, b, reach), b - a, reach) > _OVERSHOOT * quantum
        for a, b in zip(first[long].tolist(), last[long].tolist(), strict=True)
    )


def _rise(slope: float, length: int, reach: int) -> float:
    """By how much a parabola rises above a run of so many samples, beyond whose ends its mean slope over ``reach``
    samples is ``slope``.
    """
    half = 0.5 * length
    return 0.5 * slope * half**2 / (half + 0.5 * reach)


def _slope_at(value: np.ndarray, first: int, last: int, reach: int) -> float:
    """Mean change per sample just before and after the run ``first`` to ``last``; the smaller of the two."""
    slopes = []
    if first >= reach:
        slopes.append(abs(float(value[first] - value[first - reach])) / reach)
    if last + reach <= value.size:
        slopes.append(abs(float(value[last - 1] - value[last - 1 + reach])) / reach)
    return min(slopes, default=0.0)


def touched(stamp: np.ndarray, spoiled: np.ndarray, cutoff: float, band: float) -> np.ndarray:
    """(n,) bool: samples whose filtered force contains the error of a spoiled gauge sample.

    The causal filter at ``cutoff`` spreads it forward, the zero-phase one at ``band`` both ways; each until its
    envelope, exp(-pi f t), has decayed to 2 %.

    Args:
        stamp: (n,) ns, rising.
        spoiled: (k,) ns, rising.
        cutoff, band: Hz; 0 for none.
    """
    if not spoiled.size:
        return np.zeros(stamp.size, bool)
    causal, both = (_REACH / (2.0 * np.pi * f) if f > 0.0 else 0.0 for f in (cutoff, band))
    edges = np.zeros(stamp.size + 1, np.int64)
    np.add.at(edges, np.searchsorted(stamp, spoiled - round(both * 1e9)), 1)
    np.add.at(edges, np.searchsorted(stamp, spoiled + round((causal + both) * 1e9), side="right"), -1)
    return np.cumsum(edges[:-1]) > 0
