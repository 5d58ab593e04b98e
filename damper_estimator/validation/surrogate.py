"""The part of a force that the motion explains, for any damper: a smooth curve of many parts, without physics.

    F = (1 + f t) g(v, x, a, command) + zero(t)

g is made of broken lines over velocity and of low powers of the rest and vanishes at standstill in the middle of the
stroke, f lets the damper fade over the recording, and zero is a broken line over time, one for each
recording: the force at standstill and its changes that do not depend on motion. The changes are read off whole
cycles of the motion, over which a hysteresis that g does not contain cancels out.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.numerics import block_variance, least_squares
from damper_estimator.signals import Measurement, low_pass_zero_phase
from damper_estimator.signals.cycles import reversals

_ROWS_PER_BAND = 4.0  # rows per second over the band's frequency; more only repeat each other
_SPEED_KNOTS = (0.0, 0.03, 0.08, 0.17, 0.35, 0.65, 1.0)  # of the largest speed
_COMMAND_KNOTS = 4
_KNOT_SECONDS, _KNOT_CYCLES, _MOST_KNOTS = 5.0, 6, 8  # knots of the zero: least distance; most intervals
_BLOCKS = 4  # of cycles in an interval; neighbouring cycles are not independent
_BLOCK = 1.0  # s; residuals further apart are
_SLOW = 0.25  # of the frequency of the middle cycle, below which the middle of the stroke wanders


@dataclass(frozen=True)
class Zero:
    """How a recording's force changes without any motion.

    Attributes:
        knots, value: (k,) s since the first sample and N, the broken line through the means of whole cycles.
        covariance: (k, k) N^2 of its changes, from the scatter of the cycles.
    """

    knots: np.ndarray
    value: np.ndarray
    covariance: np.ndarray

    def line(self, time: np.ndarray, judged: np.ndarray) -> np.ndarray:
        """(n,) N, the movement at times (n,) in s, about its mean over the ``judged`` samples (n,) bool."""
        line = np.interp(time - time[0], self.knots, self.value)
        return line - line[judged].mean()

    def change(self) -> tuple[int, int, float, float]:
        """The knots of the largest change, in order of time, the change in N and its standard error."""
        first, last = sorted((int(self.value.argmin()), int(self.value.argmax())))
        c = self.covariance
        error = float(np.sqrt(max(c[first, first] + c[last, last] - 2.0 * c[first, last], 0.0)))
        return first, last, float(self.value[last] - self.value[first]), error


@dataclass(frozen=True)
class Surrogate:
    """A fitted curve of the motion.

    Attributes:
        rows: per recording (r,) int, samples at which the curve is evaluated.
        motion: per recording (r,) N, the part that follows the motion; 0 at standstill.
        still: per recording (r,) N, force less that: its zero, and effects that the curve does not contain.
        residual: per recording (r,) N, force less curve and zero.
        levels: N, per recording the mean of its zero.
        level_error: N, standard error common to all levels: how well standstill is known.
        zeros: how each recording's zero changes; None where there are too few cycles.
        rms_n: rms of the force about its mean.
        rest_n: rms of the residual.
    """

    rows: tuple[np.ndarray, ...]
    motion: tuple[np.ndarray, ...]
    still: tuple[np.ndarray, ...]
    residual: tuple[np.ndarray, ...]
    levels: tuple[float, ...]
    level_error: float
    zeros: tuple[Zero | None, ...]
    rms_n: float
    rest_n: float


@dataclass(frozen=True)
class _Ranges:
    """Largest speed and displacement, rms acceleration, ends of the command (NaN without one), middle of the stroke."""

    speed: float
    stroke: float
    acceleration: float
    command: tuple[float, float]
    middle: float


def surrogate(measurements: Sequence[Measurement], forces: Sequence[np.ndarray] | None = None) -> Surrogate | None:
    """Fits the curve to all recordings together; None where there is too little motion.

    Args:
        measurements: recordings of one damper.
        forces: (n,) N in band for each; the measured ones where it is None.
    """
    rows = [_rows(m) for m in measurements]
    if not rows or any(samples.size < 100 for samples in rows):
        return None
    ranges = _ranges(measurements, rows)
    if min(ranges.speed, ranges.stroke, ranges.acceleration) <= 0.0:
        return None
    given = [m.in_band(m.force) for m in measurements] if forces is None else forces
    force = np.concatenate([band_force[r] for band_force, r in zip(given, rows, strict=True)])
    cycles = [_cycles(m) for m in measurements]
    curves = np.vstack([_curves(*recording, ranges) for recording in zip(measurements, rows, cycles, strict=True)])
    middle = np.full(1, ranges.middle)
    still = _columns(np.zeros(1), middle, middle, np.zeros(1), np.full(1, np.mean(ranges.command)), ranges)
    curves -= np.concatenate(list(still))
    size = np.sqrt(np.mean(curves**2, axis=0))
    curves = curves[:, size > 1e-9 * size.max()] / size[size > 1e-9 * size.max()]
    time = [m.kinematics.time[r] - m.kinematics.time[0] for m, r in zip(measurements, rows, strict=True)]
    hats = _block_diagonal([_hats(t, _knots(t, whole)) for t, whole in zip(time, cycles, strict=True)])
    share, _ = least_squares(np.hstack([curves, hats]), force)
    late = np.concatenate([t / max(float(t[-1]), 1e-9) for t in time])
    curves = np.hstack([curves, (late * _sum(curves, share[: curves.shape[1]]))[:, None]])
    columns = np.hstack([curves, hats])
    share, inverse = least_squares(columns, force)
    motion, residual = _sum(curves, share[: curves.shape[1]]), force - _sum(columns, share)
    cuts = np.cumsum([samples.size for samples in rows])[:-1]
    rests = np.split(force - motion, cuts)
    common = np.concatenate([np.zeros(curves.shape[1]), np.full(hats.shape[1], 1.0 / hats.shape[1])])
    variance = block_variance(residual, _blocks(time))
    return Surrogate(
        rows=tuple(rows),
        motion=tuple(np.split(motion, cuts)),
        still=tuple(rests),
        residual=tuple(np.split(residual, cuts)),
        levels=tuple(float(rest.mean()) for rest in rests),
        level_error=float(np.sqrt(max(common @ inverse @ common, 0.0) * variance)),
        zeros=tuple(_zero(*recording) for recording in zip(rows, time, rests, cycles, strict=True)),
        rms_n=float(force.std()),
        rest_n=float(np.sqrt(np.mean(residual**2))),
    )


def _rows(m: Measurement) -> np.ndarray:
    rate = m.kinematics.rate
    stride = max(1, int(rate / (_ROWS_PER_BAND * m.band))) if m.band > 0.0 and np.isfinite(rate) else 1
    return np.flatnonzero(m.judged & (np.arange(m.judged.size) % stride == 0))


def _ranges(measurements: Sequence[Measurement], rows: Sequence[np.ndarray]) -> _Ranges:
    parts = [(m.kinematics, samples) for m, samples in zip(measurements, rows, strict=True)]
    x = np.concatenate([k.displacement[samples] for k, samples in parts])
    command = np.concatenate([k.command[samples] for k, samples in parts])
    return _Ranges(
        speed=max(float(np.abs(k.velocity[samples]).max()) for k, samples in parts),
        stroke=float(np.abs(x).max()),
        acceleration=float(np.sqrt(np.mean(np.concatenate([k.acceleration[samples] ** 2 for k, samples in parts])))),
        command=(float(command.min()), float(command.max())),
        middle=float(np.median(x)),
    )


def _curves(m: Measurement, rows: np.ndarray, cycles: np.ndarray, ranges: _Ranges) -> np.ndarray:
    """(r, c) columns of the motion, passed through the band as the force is."""
    k = m.kinematics
    middle = k.displacement
    if len(cycles):
        slow = _SLOW / float(np.median(k.time[cycles[:, 1]] - k.time[cycles[:, 0]]))
        middle = low_pass_zero_phase(slow, k.dt, k.displacement)
    known = np.isfinite(k.command)
    command = np.where(known, k.command, ranges.command[0])
    columns = _columns(k.velocity, k.displacement, middle, k.acceleration, command, ranges)
    in_band = [m.in_band(column)[rows] for column in columns]  # whole columns one at a time: there are dozens
    return np.stack(in_band, axis=1)


def _columns(
    v: np.ndarray, x: np.ndarray, middle: np.ndarray, a: np.ndarray, command: np.ndarray, ranges: _Ranges
) -> Iterator[np.ndarray]:
    """The terms of g, column by column. Where the middle of the cycles wanders, a hysteresis is stiff within cycles
    and not between them.
    """
    v, x, a, middle = v / ranges.speed, x / ranges.stroke, a / ranges.acceleration, middle / ranges.stroke
    steep = np.tanh(v / 0.05)
    edges = np.array([-s for s in _SPEED_KNOTS[:0:-1]] + list(_SPEED_KNOTS))
    yield from _each_hat(np.clip(v, -1.0, 1.0), edges)
    yield np.tanh(v / 0.01)
    yield np.tanh(v / 0.3)
    yield x - middle
    yield x**2
    yield x**3
    yield middle
    yield a
    yield a * np.abs(v)
    yield a * (1.0 - steep**2)
    yield x * v
    yield x * steep
    low, high = ranges.command
    if high > low:  # False without a command
        hats = _each_hat(np.clip(command, low, high), np.linspace(low, high, _COMMAND_KNOTS))
        next(hats)
        for hat in hats:
            yield from (hat * factor for factor in (np.ones_like(v), v, steep, np.tanh(v / 0.3), x))


def _sum(columns: np.ndarray, shares: np.ndarray) -> np.ndarray:
    return np.einsum("ij,j->i", columns, shares)


def _blocks(times: Sequence[np.ndarray]) -> np.ndarray:
    """(r,) int, the block that each row of all recordings belongs to."""
    blocks, first = [], 0
    for seconds in times:
        blocks.append(first + (seconds / _BLOCK).astype(int))
        first = int(blocks[-1][-1]) + 1
    return np.concatenate(blocks)


def _cycles(m: Measurement) -> np.ndarray:
    """(c, 2) first and last sample of whole cycles that are judged throughout, without overlap."""
    bad = np.concatenate([[0], np.cumsum(~m.judged)])
    found = []
    for part in m.kinematics.stretches():
        at = reversals(m.kinematics, part)[::2]
        found += [(a, b) for a, b in zip(at[:-1].tolist(), at[1:].tolist(), strict=True) if bad[b] == bad[a]]
    return np.array(found, int).reshape(-1, 2)


def _knots(time: np.ndarray, cycles: np.ndarray) -> np.ndarray:
    span = float(time[-1] - time[0])
    intervals = min(_MOST_KNOTS, int(span / _KNOT_SECONDS), len(cycles) // _KNOT_CYCLES)
    return np.linspace(time[0], time[-1], 1 + max(1, intervals))


def _zero(rows: np.ndarray, time: np.ndarray, rest: np.ndarray, cycles: np.ndarray) -> Zero | None:
    """The broken line through the means of cycles."""
    place = np.searchsorted(rows, cycles)
    place = place[place[:, 1] - place[:, 0] >= 4]
    if len(place) < 2 * _KNOT_CYCLES:
        return None
    sums, moments = (np.concatenate([[0.0], np.cumsum(values)]) for values in (rest, time))
    count = place[:, 1] - place[:, 0]
    level, middle = ((total[place[:, 1]] - total[place[:, 0]]) / count for total in (sums, moments))
    knots = _knots(middle, place)
    hats = _hats(middle, knots)
    weight = count / count.mean()
    root = np.sqrt(weight)
    value, inverse = least_squares(hats * root[:, None], root * level)
    return Zero(knots, value, inverse * _scatter(weight * (level - hats @ value), middle, knots))


def _scatter(residual: np.ndarray, time: np.ndarray, knots: np.ndarray) -> float:
    """N^2: long-run variance of residuals of cycles."""
    blocks = _BLOCKS * (knots.size - 1)
    block = np.minimum((blocks * (time - knots[0]) / (knots[-1] - knots[0])).astype(int), blocks - 1)
    return block_variance(residual, block, knots.size)


def _each_hat(value: np.ndarray, knots: np.ndarray) -> Iterator[np.ndarray]:
    """The columns (n,) of `_hats`, one by one."""
    place, share = _place(value, knots)
    for i in range(knots.size):
        yield np.where(place == i, 1.0 - share, np.where(place == i - 1, share, 0.0))


def _hats(value: np.ndarray, knots: np.ndarray) -> np.ndarray:
    """(n, k) weights of the knots between which each value lies."""
    place, share = _place(value, knots)
    hats = np.zeros((value.size, knots.size))
    rows = np.arange(value.size)
    hats[rows, place] = 1.0 - share
    hats[rows, place + 1] = share
    return hats


def _place(value: np.ndarray, knots: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n,) the knot at or before each value (the last but one at most), and (n,) how far it is to the next."""
    place = np.clip(np.searchsorted(knots, value, side="right") - 1, 0, knots.size - 2)
    return place, (value - knots[place]) / (knots[place + 1] - knots[place])


def _block_diagonal(parts: Sequence[np.ndarray]) -> np.ndarray:
    whole = np.zeros((sum(p.shape[0] for p in parts), sum(p.shape[1] for p in parts)))
    row = column = 0
    for part in parts:
        whole[row : row + part.shape[0], column : column + part.shape[1]] = part
        row, column = row + part.shape[0], column + part.shape[1]
    return whole
