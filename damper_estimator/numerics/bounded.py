"""Linear least squares between bounds, robust where columns are zero or alike."""

import numpy as np

from damper_estimator.numerics.triangle import triangle

_RIDGE = 1e-7  # of a column's norm: far below the influence of data, enough where there is none
_SILENT = 1e-12  # of the largest column: such a column has no influence at all


def bounded_least_squares(
    columns: np.ndarray, target: np.ndarray, lower: np.ndarray, upper: np.ndarray, reference: np.ndarray
) -> np.ndarray:
    """The p that minimises |columns p - target|^2 with lower <= p <= upper.

    Where the data do not determine p, it stays next to ``reference``: a ridge of 1e-7 of each column's norm keeps
    it there.

    Args:
        columns: (m, k).
        target: (m,).
        lower, upper, reference: (k,).

    Returns:
        (k,)
    """
    count = columns.shape[1]
    if count == 0:
        return np.zeros(0)
    reduced = triangle(np.column_stack([columns, target]))
    norms = np.sqrt((reduced[:, :count] ** 2).sum(axis=0))
    scale = np.where(norms > _SILENT * norms.max(), norms, 1.0 if norms.max() == 0.0 else norms.max())
    matrix = np.vstack([reduced[:, :count] / scale, _RIDGE * np.eye(count)])
    # Solved for the step away from the reference, which the ridge then keeps small.
    step_target = np.concatenate([reduced[:, count] - reduced[:, :count] @ reference, np.zeros(count)])
    low, high = (lower - reference) * scale, (upper - reference) * scale
    solved = triangle(np.column_stack([matrix, step_target]))
    step = np.linalg.solve(solved[:count, :count], solved[:count, count])
    if ((step < low) | (step > high)).any():
        step = _between(matrix, step_target, low, high)
    return np.clip(reference + step / scale, lower, upper)


def _between(matrix: np.ndarray, target: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    # Imported when needed: bounds are seldom active, and the import takes a third of a second.
    from scipy.optimize import lsq_linear

    # Bounds that coincide leave nothing to choose.
    open_ = high > low
    step = low.copy()
    rest = target - matrix[:, ~open_] @ low[~open_]
    if open_.any():
        step[open_] = lsq_linear(
            matrix[:, open_], rest, (low[open_], high[open_]), method="bvls", max_iter=10 * low.size
        ).x
    return step
