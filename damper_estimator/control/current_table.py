"""The usual look-up table: force over velocity and current, inverted for the current.

It ignores displacement, history and the coil's lag. It is the reference for model-based feed-forward, so it is as good
as a table can be: fitted by least squares to all samples, linear between its knots.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.model.force_table import read_table

VELOCITIES = (-1.5, -1.0, -0.7, -0.5, -0.35, -0.25, -0.17, -0.1, -0.05, -0.02, 0.0, 0.02, 0.05, 0.1, 0.17, 0.25, 0.35,
              0.5, 0.7, 1.0, 1.5)  # fmt: skip
"""m/s, default knots."""

CURRENTS = (0.0, 0.5, 1.0, 1.5, 2.0)
"""A, default knots."""

_SMOOTH = 1e-3  # weight of a knot's deviation from its neighbours over that of the mean cell's samples
_KEEP = 1e-6


@dataclass(frozen=True)
class CurrentTable:
    """A force table.

    Attributes:
        velocity: (m,) m/s, rising.
        current: (k,) A, rising.
        force: (m, k) N.
    """

    velocity: np.ndarray
    current: np.ndarray
    force: np.ndarray

    def force_at(self, velocity: float, current: float) -> float:
        """Force in N, linear between the knots and constant beyond them."""
        return float(np.interp(current, self.current, self.forces(velocity)))

    def forces(self, velocity: float) -> np.ndarray:
        """Force in N at every current's knot, (k,)."""
        v = min(max(velocity, self.velocity[0]), self.velocity[-1])
        right = min(max(int(np.searchsorted(self.velocity, v)), 1), self.velocity.size - 1)
        share = (v - self.velocity[right - 1]) / (self.velocity[right] - self.velocity[right - 1])
        return self.force[right - 1] + share * (self.force[right] - self.force[right - 1])

    def current_for(self, velocity: float, wanted: float) -> float:
        """The current in A whose force at this velocity is nearest to the desired one; the smallest such. NaN if
        either is not finite.
        """
        if not (isfinite(velocity) and isfinite(wanted)):
            return float("nan")
        force, current = self.forces(velocity), self.current
        low, high = force[:-1] - wanted, force[1:] - wanted
        crossing = np.flatnonzero((low <= 0.0) != (high <= 0.0))
        if crossing.size:
            k = int(crossing[0])
            return float(current[k] + (current[k + 1] - current[k]) * low[k] / (low[k] - high[k]))
        return float(current[np.argmin(np.abs(force - wanted))])


def load_table(path: str | Path) -> CurrentTable:
    """The table of a ``force_velocity.csv``, as ``damper-estimator export --tables`` writes it; of several temperatures
    the middle one.

    Raises:
        InputError: if it is not such a table, or has fewer than two commands.
    """
    table = read_table(Path(path))
    if table.commands.size < 2:
        raise InputError(
            f"{path}: has only one command; export it from a model whose force depends on one, with --current"
        )
    return CurrentTable(table.velocity, table.commands, table.force[:, table.temperatures.size // 2].T)


def table_from_samples(
    velocity: np.ndarray,
    current: np.ndarray,
    force: np.ndarray,
    velocities: Sequence[float] = VELOCITIES,
    currents: Sequence[float] = CURRENTS,
) -> CurrentTable:
    """The table that agrees best with samples (n,), by least squares; cells without samples follow their neighbours.

    Samples shortly after a change of the current should be left out, because the coil's lag mixes currents.

    Raises:
        InputError: if there are fewer samples than cells.
    """
    v_knots, c_knots = np.asarray(velocities, float), np.asarray(currents, float)
    good = np.isfinite(velocity) & np.isfinite(current) & np.isfinite(force)
    shape = (v_knots.size, c_knots.size)
    if good.sum() < shape[0] * shape[1]:
        raise InputError(f"{int(good.sum())} samples are too few for a table of {shape[0]} x {shape[1]} forces")
    rows_v, rows_c = _hats(velocity[good], v_knots), _hats(current[good], c_knots)
    design = np.einsum("ni,nj->nij", rows_v, rows_c).reshape(good.sum(), -1)
    normal, right = design.T @ design, design.T @ force[good]
    weight = _SMOOTH * good.sum() / normal.shape[0]
    lines = np.concatenate([
        np.einsum("ai,bj->abij", _deviations(v_knots), np.eye(shape[1])).reshape(-1, normal.shape[0]),
        np.einsum("ai,bj->abij", np.eye(shape[0]), _deviations(c_knots)).reshape(-1, normal.shape[0]),
    ])  # fmt: skip
    normal = normal + weight * (lines.T @ lines) + _KEEP * weight * np.eye(normal.shape[0])
    return CurrentTable(v_knots, c_knots, np.linalg.solve(normal, right).reshape(shape))


def _hats(values: np.ndarray, knots: np.ndarray) -> np.ndarray:
    """(n, k) shares of the knots in each value, linear between them, constant beyond."""
    return np.stack([np.interp(values, knots, unit) for unit in np.eye(knots.size)], axis=1)


def _deviations(knots: np.ndarray) -> np.ndarray:
    """(k - 2, k) how far each inner knot's force lies from the straight line between its neighbours."""
    rows = np.zeros((knots.size - 2, knots.size))
    for k in range(knots.size - 2):
        share = (knots[k + 1] - knots[k]) / (knots[k + 2] - knots[k])
        rows[k, k : k + 3] = share - 1.0, 1.0, -share
    return rows
