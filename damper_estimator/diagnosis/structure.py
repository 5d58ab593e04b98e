"""What is left where nothing accounts for it: mean residual over pairs of quantities, checked on unseen data."""

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from damper_estimator.diagnosis.baseline import Baseline
from damper_estimator.diagnosis.evaluation import LOW, Errors, gains
from damper_estimator.diagnosis.result import Structure
from damper_estimator.identification.rows import Rows
from damper_estimator.numerics import block_draws
from damper_estimator.signals.layout import COMMAND, TEMPERATURE, A, T, V, X

CELLS = 12  # per axis, in equal shares of the time
_LEAST = 8  # rows in a cell
_AXES = {
    X: "displacement (m)",
    V: "velocity (m/s)",
    A: "acceleration (m/s^2)",
    T: "time (s)",
    COMMAND: "command (A)",
    TEMPERATURE: "temperature (deg C)",
}


def structure(baseline: Baseline, without: Errors) -> tuple[Structure | None, float, float]:
    """The grid that predicts most of the unseen residual, with its gain there and the gain's 5 % bound."""
    best: tuple[float, float, Structure] | None = None
    drawn = block_draws(without.blocks.size)
    usable = [row for row in _AXES if _varies(baseline.data.fit, row) and _varies(baseline.data.unseen, row)]
    for pair in combinations(usable, 2):
        grid = _grid(baseline.data.fit, without.fit, pair)
        left = without.unseen - _looked_up(baseline.data.unseen, grid, pair)
        blocks = np.bincount(baseline.data.blocks, left**2)
        errors = Errors(without.fit, left, blocks)
        gain = 1.0 - errors.square / max(without.square, 1e-300)
        if best is None or gain > best[0]:
            best = (gain, float(np.percentile(gains(drawn, errors, without), LOW)), grid)
    if best is None:
        return None, 0.0, 0.0
    return best[2], best[0], best[1]


def _values(rows: Sequence[Rows], row: int) -> np.ndarray:
    return np.concatenate([part.measurement.kinematics.block[row][part.picks] for part in rows])


def _varies(rows: Sequence[Rows], row: int) -> bool:
    values = _values(rows, row)
    return bool(np.isfinite(values).all() and np.ptp(values) > 0.0)


def _grid(rows: Sequence[Rows], residual: np.ndarray, pair: tuple[int, int]) -> Structure:
    x, y = (_values(rows, row) for row in pair)
    edges = [np.unique(np.quantile(values, np.linspace(0.0, 1.0, CELLS + 1))) for values in (x, y)]
    i, j = (_cell(values, edge) for values, edge in zip((x, y), edges, strict=True))
    shape = (edges[1].size - 1, edges[0].size - 1)
    flat = j * shape[1] + i
    count = np.bincount(flat, minlength=shape[0] * shape[1])
    total = np.bincount(flat, residual, shape[0] * shape[1])
    mean = np.where(count >= _LEAST, total / np.maximum(count, 1), np.nan).reshape(shape)
    return Structure((_AXES[pair[0]], _AXES[pair[1]]), edges[0], edges[1], mean, _words(edges, mean, pair))


def _cell(values: np.ndarray, edges: np.ndarray) -> np.ndarray:
    return np.clip(np.searchsorted(edges, values, side="right") - 1, 0, edges.size - 2)


def _looked_up(rows: Sequence[Rows], grid: Structure, pair: tuple[int, int]) -> np.ndarray:
    i, j = (_cell(_values(rows, row), edges) for row, edges in zip(pair, (grid.x, grid.y), strict=True))
    return np.nan_to_num(grid.mean_n[j, i])


def _words(edges: Sequence[np.ndarray], mean: np.ndarray, pair: tuple[int, int]) -> str:
    if not np.isfinite(mean).any():
        return ""
    j, i = np.unravel_index(np.nanargmax(np.abs(mean)), mean.shape)
    names = [_AXES[row].partition(" (") for row in pair]
    where = " and ".join(
        f"{name} between {edge[k]:.2g} and {edge[k + 1]:.2g} {unit.rstrip(')')}"
        for (name, _, unit), edge, k in zip(names, edges, (i, j), strict=True)
    )
    return f"the model is {abs(mean[j, i]):.3g} N too {'high' if mean[j, i] > 0.0 else 'low'} at {where}"
