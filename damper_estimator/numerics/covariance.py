"""Standard errors of a least-squares fit whose residual repeats itself, and directions that the data do not determine.

    C = (J'J)^-1 (J' R J) (J'J)^-1 m_e / (m_e - k)

with J (m, k) the derivatives, R the residual's autocovariance, and m_e the effective number of samples; see
``long_run``. The last factor is the usual correction for k fitted parameters. J is scaled to columns of unit norm
and decomposed into directions (singular vectors): one without influence has no finite error.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import svd

from damper_estimator.numerics.long_run import score_covariance
from damper_estimator.numerics.triangle import triangle

_SINGULAR = 1e-5  # smallest over largest singular value: below it a direction has no influence
_INCIDENTAL = 1e-3  # of the largest share of a direction without influence: below, rounding

Noise = Callable[[np.ndarray], tuple[np.ndarray, float]]
"""Weights (k, d) to the covariance (d, d) of sum((J weights)' e), and the effective number of samples."""


@dataclass(frozen=True)
class Directions:
    """Directions in the space of k parameters, each in units of its column's norm, and their influence on the data.

    Attributes:
        norms: (k,) of the Jacobian's columns.
        singular: (k,) influence of each direction.
        vectors: (k, k), a direction per row.
        deviation: (k,) standard deviation along each; infinite where it has no influence.
        spread: (k,) standard error of each parameter, from the directions that have influence.
    """

    norms: np.ndarray
    singular: np.ndarray
    vectors: np.ndarray
    deviation: np.ndarray
    spread: np.ndarray

    @property
    def undetermined(self) -> np.ndarray:
        """(k,) bool: parameters without influence, or that take part in a direction without influence."""
        silent = np.abs(self.vectors[np.isinf(self.deviation)])
        involved = silent > _INCIDENTAL * silent.max(axis=1, keepdims=True, initial=0.0)
        return involved.any(axis=0) | (self.norms == 0.0)


def directions(jacobian: np.ndarray, noise: Noise) -> Directions:
    """Of the parameters whose derivatives, or the triangle of these, are the columns (m, k) of ``jacobian``."""
    count = jacobian.shape[1]
    if count == 0:
        return Directions(np.zeros(0), np.zeros(0), np.zeros((0, 0)), np.zeros(0), np.zeros(0))
    norms = np.linalg.norm(jacobian, axis=0)
    scale = np.where(norms > 0.0, norms, 1.0)
    # NumPy's divide-and-conquer method does not always converge where columns are alike.
    _, singular, vectors = svd(triangle(jacobian / scale), lapack_driver="gesvd")
    singular = np.pad(singular, (0, count - singular.size))  # fewer rows than parameters
    known = singular > _SINGULAR * singular[0]
    weights = vectors[known].T / singular[known] ** 2 / scale[:, None]
    total, effective = noise(weights)
    covariance = total * effective / max(effective - count, 1.0)
    deviation = np.full(count, np.inf)
    deviation[known] = np.sqrt(np.diag(covariance))
    spread = np.sqrt((vectors[known].T @ covariance * vectors[known].T).sum(axis=1)) / scale
    return Directions(norms, singular, vectors, deviation, spread)


def standard_errors(
    jacobians: Sequence[np.ndarray], residuals: Sequence[np.ndarray], rates: Sequence[float]
) -> np.ndarray:
    """(k,) standard errors of parameters fitted to some recordings; NaN where the data do not determine one.

    Args:
        jacobians: (n, k) derivatives of the residual of each recording.
        residuals: (n,) of each.
        rates: Hz of each, evenly sampled.
    """

    def noise(weights: np.ndarray) -> tuple[np.ndarray, float]:
        return score_covariance(residuals, [jacobian @ weights for jacobian in jacobians], rates)

    found = directions(np.concatenate([triangle(jacobian) for jacobian in jacobians]), noise)
    return np.where(found.undetermined, np.nan, found.spread)
