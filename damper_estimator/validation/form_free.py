"""A form-free reference: what a linear regression explains of the measured force, without a model of the damper.

Columns are hat functions of velocity (the curve), coarse ones times command, temperature and position, times
acceleration (masses, lags and compliances), and plays over the displacement (friction), alone and times the command.
All pass the comparison's low-pass, so the solution is one least-squares problem.

The reference says how much of a force is explainable at least. It is no bound: a model of the right form may be better.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from damper_estimator.numerics import (
    COARSE_SHARES,
    FINE_SHARES,
    bounded_least_squares,
    hats,
    play,
    speed_knots,
)
from damper_estimator.signals import Measurement, columns_zero_phase
from damper_estimator.signals.layout import COMMAND, DT, TEMPERATURE, A, V, X

_PLAYS = (3e-5, 1e-4, 4e-4, 1.5e-3, 5e-3)  # m, half widths of pre-sliding
_HIGHEST = 0.999  # quantile of the speed
_LEAST_KELVIN, _LEAST_COMMAND = 1.0, 0.02
_NOTHING = 1e-9  # of the largest column: what the filter leaves of one that is zero
_RIDGE = 1e-5  # of the mean square of a column
_MOST_SAMPLES = 15_000  # of the recordings together


@dataclass(frozen=True)
class FormFree:
    """A regression of the force; ``weights`` (k,) N belong to its columns.

    Attributes:
        speed: m/s, the highest of the identification.
        middle: m, of its stroke.
        command, temperature: centre and half range; None if it did not vary.
        with_acceleration: whether it has columns with acceleration.
        plays: m, half widths of pre-sliding.
        rising: whether the curve over velocity is a sum of steps upwards, which keeps its slope from being negative.
    """

    speed: float
    middle: float
    command: tuple[float, float] | None
    temperature: tuple[float, float] | None
    with_acceleration: bool
    plays: tuple[float, ...]
    weights: np.ndarray
    rising: bool = False

    def force(self, block: np.ndarray) -> np.ndarray:
        """(n,) N on a sample block."""
        total = np.zeros(block.shape[1])
        for weight, (column, _) in zip(self.weights, self.columns(block), strict=True):
            total += weight * column
        return total

    def columns(self, block: np.ndarray) -> Iterator[tuple[np.ndarray, float]]:
        """Columns (n,) of a sample block with the least weight of each, one by one: together they need much memory.

        Friction dissipates, so the weights of plays are not negative; otherwise they would stand in for a compliance.
        """
        x, v = block[X] - self.middle, block[V]
        coarse = hats(v, speed_knots(self.speed, COARSE_SHARES))
        plays = [play(block[X], block[DT], width) for width in self.plays]
        fine = speed_knots(self.speed, FINE_SHARES)
        if self.rising:
            yield np.ones(v.size), -np.inf
            yield from ((column, 0.0) for column in _ramps(v, fine))
        else:
            yield from ((column, -np.inf) for column in hats(v, fine))
        yield from ((column, -np.inf) for column in (x, x**2 * np.sign(x)))
        yield from ((column, 0.0) for column in plays)
        yield from ((x * column, -np.inf) for column in coarse)
        if self.command is not None:
            for level in self._levels(block):
                yield from ((level * column, -np.inf) for column in coarse)
                yield from ((level * column, 0.0) for column in plays)
        if self.temperature is not None:
            share = _share(block[TEMPERATURE], self.temperature)
            yield from ((share * column, -np.inf) for column in coarse)
        if self.with_acceleration:
            yield from ((block[A] * column, -np.inf) for column in coarse)

    def shape(self, block: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """The force at every sample as a function of velocity and plays, for a velocity that is not the block's.

        Returns:
            knots (k,) m/s of piecewise linear curves, their heights (n, k) N, half widths (p,) m of the plays, what
            they hold (n, p) N, and the rest (n,) N. Acceleration is left out.
        """
        x = block[X] - self.middle
        fine, coarse = speed_knots(self.speed, FINE_SHARES), speed_knots(self.speed, COARSE_SHARES)
        knots, widths = np.union1d(fine, coarse), np.array(self.plays, float)
        weights = iter(self.weights)

        def curve(own: np.ndarray, summed: bool = False) -> np.ndarray:
            values = np.array([next(weights) for _ in own])
            return np.interp(knots, own, np.cumsum(values) if summed else values)

        def plays() -> np.ndarray:
            return np.array([next(weights) for _ in self.plays])

        base = curve(fine, self.rising)
        static = next(weights) * x + next(weights) * x**2 * np.sign(x)
        held = np.tile(plays(), (x.size, 1))
        heights = base + np.outer(x, curve(coarse))
        if self.command is not None:
            for level in self._levels(block):
                heights += np.outer(level, curve(coarse))
                held += np.outer(level, plays())
        if self.temperature is not None:
            heights += np.outer(_share(block[TEMPERATURE], self.temperature), curve(coarse))
        return knots, heights, widths, held, static

    def _levels(self, block: np.ndarray) -> list[np.ndarray]:
        """Two hat functions (n,) of the command: at its middle and its upper end."""
        assert self.command is not None
        return hats(_share(block[COMMAND], self.command), np.array([-1.0, 0.0, 1.0]))[1:]


def form_free(measurements: Sequence[Measurement], with_acceleration: bool = True, rising: bool = False) -> FormFree:
    """The regression on recordings of one damper, pooled.

    Args:
        rising: whether the curve over velocity may not fall.
    """
    empty = unfitted(measurements, with_acceleration, rising)
    every = max(sum(int(m.judged.sum()) for m in measurements) // _MOST_SAMPLES, 1)
    least = [lower for _, lower in empty.columns(measurements[0].kinematics.block[:, :1])]
    rows, forces = [], []
    for m in measurements:
        picks = np.flatnonzero(m.judged)[::every]
        columns = (column for column, _ in empty.columns(m.kinematics.block))
        rows.append(columns_zero_phase(m.band, m.kinematics.dt, columns, picks))
        forces.append(m.in_band(np.asarray(m.force))[picks])
    shown, force = np.concatenate(rows), np.concatenate(forces)
    known = np.isfinite(force) & np.isfinite(shown).all(axis=1)
    if not known.any():
        return replace(empty, weights=np.full(shown.shape[1], np.nan))
    return replace(empty, weights=_solved(shown[known], force[known], np.array(least)))


def unfitted(measurements: Sequence[Measurement], with_acceleration: bool = True, rising: bool = False) -> FormFree:
    """The regression without weights: its columns, laid out over the motion of the recordings. Arguments as in
    ``form_free``.
    """

    def pooled(row: int) -> np.ndarray:
        return np.concatenate([m.kinematics.block[row][m.judged] for m in measurements])

    x = pooled(X)
    return FormFree(
        speed=max(float(np.quantile(np.abs(pooled(V)), _HIGHEST)), 1e-6),
        middle=0.5 * float(x.min() + x.max()),
        command=_range(pooled(COMMAND), _LEAST_COMMAND),
        temperature=_range(pooled(TEMPERATURE), _LEAST_KELVIN),
        with_acceleration=with_acceleration,
        plays=_PLAYS,
        weights=np.zeros(0),
        rising=rising,
    )


def reference_error(fit: Sequence[Measurement], unseen: Sequence[Measurement]) -> float:
    """RMS error in N on unseen recordings of the regression on others; NaN without a judged sample."""
    reference = form_free(fit)
    squares, count = 0.0, 0
    for m in unseen:
        error = m.in_band(reference.force(m.kinematics.block) - np.asarray(m.force))[m.judged]
        squares, count = squares + float(error @ error), count + error.size
    return float(np.sqrt(squares / count)) if count else float("nan")


def _solved(rows: np.ndarray, force: np.ndarray, least: np.ndarray) -> np.ndarray:
    """Weights (k,) of columns (r, k), with a ridge; practically none for a column that is not driven."""
    size = np.sqrt(np.mean(rows**2, axis=0))
    size = np.maximum(size, _NOTHING * size.max() + 1e-300)
    ridge = np.sqrt(_RIDGE * len(rows)) * np.eye(size.size)
    columns, target = np.vstack([rows / size, ridge]), np.concatenate([force, np.zeros(size.size)])
    highest = np.full(size.size, np.inf)
    return bounded_least_squares(columns, target, least, highest, np.zeros(size.size)) / size


def _range(values: np.ndarray, least: float) -> tuple[float, float] | None:
    """Centre and half range; None if it is too small or unknown."""
    if not values.size or not np.isfinite(values).all():
        return None
    low, high = float(values.min()), float(values.max())
    return (0.5 * (low + high), 0.5 * (high - low)) if high - low >= least else None


def _ramps(values: np.ndarray, knots: np.ndarray) -> list[np.ndarray]:
    """(n,) from 0 at or below a knot to 1 at or above the next one."""
    return [np.clip((values - low) / (high - low), 0.0, 1.0) for low, high in zip(knots, knots[1:], strict=False)]


def _share(values: np.ndarray, ends: tuple[float, float]) -> np.ndarray:
    """-1 to 1 over the range; 0 where unknown."""
    return np.nan_to_num((values - ends[0]) / ends[1])
