"""Bands of operation, cut by the ranges of the data.

Speed and direction, stroke, acceleration, time after reversals, frequency and amplitude of the half cycle, time since
the start, command, temperature.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from damper_estimator.validation.trace import Pool

_LEVELS = 8  # a command with no more values than this is treated as steps


@dataclass(frozen=True)
class Bands:
    """One quantity cut into bands.

    Attributes:
        axis: the quantity that is cut.
        direction: rebound, compression, or "" for both.
        value: (n,) of the pool; NaN belongs to no band.
        edges: (k + 1,) rising; the outer ones may be infinite.
        words: (low, high) to words.
        inside: (n,) bool, the samples that the bands are about.
        within: whether a band must stand out among these samples too, not only among all.
    """

    axis: str
    direction: str
    value: np.ndarray
    edges: np.ndarray
    words: Callable[[float, float], str]
    inside: np.ndarray
    within: bool = False


def all_bands(pool: Pool) -> list[Bands]:
    """Every cut that the pool's channels allow."""
    everywhere = np.ones(pool.velocity.size, bool)
    speed, size = np.abs(pool.velocity), np.abs(pool.acceleration)
    bands = [Bands("velocity", "", speed, _decades(speed), _range("speed", "m/s"), everywhere)]
    bands += _reversals(pool, "", everywhere)
    directions = {"rebound": pool.velocity > 0.0, "compression": pool.velocity < 0.0}
    for direction, inside in directions.items():
        if inside.any():
            cut = _decades(speed[inside])
            bands.append(Bands("velocity", direction, speed, cut, _range(direction, "m/s"), inside))
            bands += _reversals(pool, direction, inside)
    bands.append(_even("displacement", pool.displacement, 6, _range("displacement", "mm", 1e3), everywhere))
    bands.append(Bands("acceleration", "", size, _decades(size), _range("acceleration", "m/s^2"), everywhere))
    bands.append(_octaves("frequency", pool.frequency, _range("motion", "Hz"), everywhere))
    bands.append(_octaves("amplitude", pool.amplitude, _range("amplitude", "mm", 1e3), everywhere))
    bands.append(_even("time", pool.elapsed, 6, _time, everywhere))
    bands += _command(pool, everywhere)
    warm = pool.temperature[np.isfinite(pool.temperature)]
    if warm.size and np.ptp(warm) > 1.0:
        bands.append(_even("temperature", pool.temperature, 5, _range("temperature", "deg C"), everywhere))
    return [cut for cut in bands if cut.edges.size > 2]


def directions(pool: Pool) -> Bands:
    """Rebound and compression, to narrow another region down."""
    edges = np.array([-np.inf, 0.0, np.inf])
    return Bands("direction", "", pool.velocity, edges, _direction, np.ones(pool.velocity.size, bool))


def _direction(low: float, high: float) -> str:
    return "rebound" if low == 0.0 else "compression"


def _octaves(axis: str, value: np.ndarray, words: Callable[[float, float], str], inside: np.ndarray) -> Bands:
    """Edges 1, 2, 5, 10, ... within all but the hundredth at either end."""
    known = value[np.isfinite(value) & (value > 0.0)]
    low, high = np.quantile(known, [0.01, 0.99]) if known.size else (1.0, 1.0)
    powers = 10.0 ** np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1.0)
    series = np.outer(powers, [1.0, 2.0, 5.0]).ravel()
    return Bands(axis, "", value, np.array([0.0, *series[(series > low) & (series < high)], np.inf]), words, inside)


def _decades(size: np.ndarray) -> np.ndarray:
    """Edges 1, 2, 5, 10, ... from a fiftieth of the largest up to it; the largest without its last thousandth."""
    top = float(np.quantile(size, 0.999)) if size.size else 0.0
    if top <= 0.0:
        return np.array([0.0, np.inf])
    powers = 10.0 ** np.arange(np.floor(np.log10(top / 50.0)), np.ceil(np.log10(top)) + 1.0)
    series = np.outer(powers, [1.0, 2.0, 5.0]).ravel()
    return np.array([0.0, *series[(series >= top / 50.0) & (series <= 0.8 * top)], np.inf])


def _even(axis: str, value: np.ndarray, count: int, words: Callable[[float, float], str], inside: np.ndarray) -> Bands:
    """Bands of one width between the extremes, rounded to readable numbers."""
    finite = value[np.isfinite(value)]
    low, high = float(finite.min()), float(finite.max())
    if high <= low:
        return Bands(axis, "", value, np.array([-np.inf, np.inf]), words, inside)
    unit = 10.0 ** np.floor(np.log10((high - low) / count))
    edges = np.unique(np.round(np.linspace(low, high, count + 1)[1:-1] / unit, 1) * unit)
    return Bands(axis, "", value, np.array([-np.inf, *edges, np.inf]), words, inside)


def _reversals(pool: Pool, direction: str, inside: np.ndarray) -> list[Bands]:
    since = pool.since_reversal
    known = since[np.isfinite(since)]
    if not known.size:
        return []
    # The mean of the time since a reversal is half the time between two.
    between = 2.0 * float(np.median(known))
    edges = np.array([0.0, *(float(f"{between * share:.1g}") for share in (0.05, 0.1, 0.2, 0.4)), np.inf])

    which = f"{direction}, " if direction else ""

    def words(low: float, high: float) -> str:
        if low <= 0.0:
            return f"{which}first {1e3 * high:.3g} ms after a reversal"
        if not np.isfinite(high):
            return f"{which}more than {1e3 * low:.3g} ms after a reversal"
        return f"{which}{1e3 * low:.3g} to {1e3 * high:.3g} ms after a reversal"

    return [Bands("reversal", direction, since, np.unique(edges), words, inside, within=True)]


def _command(pool: Pool, inside: np.ndarray) -> list[Bands]:
    known = np.unique(pool.command[np.isfinite(pool.command)])
    if known.size < 2:
        return []
    if known.size > _LEVELS:
        return [_even("command", pool.command, 4, _range("command", "A"), inside)]
    edges = np.array([-np.inf, *((known[1:] + known[:-1]) / 2.0), np.inf])

    def words(low: float, high: float) -> str:
        levels = known[(known > low) & (known <= high)]
        return f"command {', '.join(f'{level:.3g}' for level in levels)} A"

    return [Bands("command", "", pool.command, edges, words, inside)]


def _time(low: float, high: float) -> str:
    if not np.isfinite(high):
        return f"after {low:.3g} s"
    return f"the first {high:.3g} s" if not np.isfinite(low) else f"{low:.3g} to {high:.3g} s after the start"


def _range(subject: str, unit: str, factor: float = 1.0) -> Callable[[float, float], str]:
    def words(low: float, high: float) -> str:
        if not np.isfinite(high) and low == 0.0:
            return subject
        if not np.isfinite(high):
            return f"{subject} above {factor * low:.3g} {unit}"
        if not np.isfinite(low) or (low == 0.0 and subject != "displacement"):
            return f"{subject} below {factor * high:.3g} {unit}"
        return f"{subject} between {factor * low:.3g} and {factor * high:.3g} {unit}"

    return words
