"""Least squares by normal equations, for columns of similar scale: regularised, or damped."""

import numpy as np

_PIECE = 64  # rows
_RIDGE = 1e-9  # of the number of rows
_LEAST_DAMPING = 1e-12  # of the trace


def normal_equations(columns: np.ndarray, target: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """C'C (k, k) and C'y (k,) of columns (r, k) and a target (r,).

    They are summed in small pieces: a library that starts threads for a product of this size takes longer to wake them
    than to multiply.
    """
    normal, right = np.zeros((columns.shape[1], columns.shape[1])), np.zeros(columns.shape[1])
    for first in range(0, target.size, _PIECE):
        piece = columns[first : first + _PIECE]
        normal += piece.T @ piece
        right += target[first : first + _PIECE] @ piece
    return normal, right


def least_squares(columns: np.ndarray, target: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Solution (k,) of columns (r, k), each of about unit mean square, and the inverse (k, k) of the normal equations.

    A ridge of 1e-9 per row determines combinations that the columns leave open.
    """
    normal, right = normal_equations(columns, target)
    normal[np.diag_indices_from(normal)] += _RIDGE * target.size
    inverse = np.linalg.inv(normal)
    return inverse @ right, inverse


def damped_step(columns: np.ndarray, residual: np.ndarray, reach: float) -> np.ndarray:
    """A Gauss-Newton step (k,) that is damped beyond about ``reach`` in each entry.

        minimise  |r + C s|^2 + mean(r^2) |s|^2 / reach^2

    Args:
        columns: (r, k) derivatives, each times its parameter's size.
        residual: (r,).
        reach: share of a parameter's size up to which derivatives are trusted.

    No step is taken from numbers that are not finite, or too large to be squared.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        normal, right = normal_equations(columns, residual)
    if not (np.isfinite(normal).all() and np.isfinite(right).all()):
        return np.zeros(columns.shape[1])
    # With columns that are alike, a decomposition into singular values does not always converge; a ridge always does.
    damping = float(np.mean(residual**2)) / reach**2 + _LEAST_DAMPING * float(np.trace(normal))
    if damping <= 0.0:
        return np.zeros(columns.shape[1])
    normal[np.diag_indices_from(normal)] += damping
    return np.linalg.solve(normal, -right)
