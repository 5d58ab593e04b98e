"""The regression that all curves of the atlas share, by the sums of products of its columns alone."""

from dataclasses import dataclass, replace

import numpy as np

from damper_estimator.numerics import normal_equations

_REACH = 0.3  # of the force: columns that explain more are damped
_LEAST = 1e-9  # of the largest entry of the normal equations, where nothing is missing


@dataclass(frozen=True)
class Moments:
    """Of columns C (r, c) and what they are to explain, y (r,).

    Attributes:
        normal, right, square: C'C (c, c), C'y (c,) and y'y.
    """

    normal: np.ndarray
    right: np.ndarray
    square: float

    @classmethod
    def of(cls, columns: np.ndarray, missing: np.ndarray) -> "Moments":
        """Of the columns (r, c) and the missing force (r,)."""
        with np.errstate(over="ignore", invalid="ignore"):  # a model may run away
            return cls(*normal_equations(columns, missing), float(missing @ missing))

    def left(self, solution: np.ndarray) -> float:
        """Sum of squares that a solution (c,) leaves."""
        return float(self.square - 2.0 * solution @ self.right + solution @ self.normal @ solution)

    def mixed(self, mix: np.ndarray) -> "Moments":
        """Of the columns C M with M (c, d)."""
        return replace(self, normal=mix.T @ self.normal @ mix, right=mix.T @ self.right)


@dataclass(frozen=True)
class Regression:
    """Fitted rows, and unseen rows to judge on; columns are scaled to the rms of the force.

    Attributes:
        power: mean square of the fitted missing force.
    """

    fit: Moments
    unseen: Moments
    power: float

    def mixed(self, mix: np.ndarray) -> "Regression":
        """With sums of its columns, by factors (c, d)."""
        return replace(self, fit=self.fit.mixed(mix), unseen=self.unseen.mixed(mix))

    def solved(self) -> tuple[np.ndarray, np.ndarray]:
        """Coefficients (c,), and the inverse (c, c) of the regularised normal equations."""
        damping = self.power / _REACH**2 + _LEAST * float(self.fit.normal.max(initial=1.0))
        inverse = np.linalg.inv(self.fit.normal + damping * np.eye(self.fit.right.size))
        return inverse @ self.fit.right, inverse

    @property
    def is_finite(self) -> bool:
        """Whether the columns could be squared."""
        parts = (self.fit.normal, self.fit.right, self.unseen.normal, self.unseen.right)
        return all(bool(np.isfinite(part).all()) for part in parts)

    @property
    def left(self) -> float:
        """Sum of squares that is left, unseen."""
        return self.unseen.left(self.solved()[0])

    @property
    def left_fit(self) -> float:
        """The same, fitted."""
        return self.fit.left(self.solved()[0])

    def gain(self, left: float) -> float:
        """Share of the unseen squared error that these columns leave, while something beside them leaves ``left``.

        Columns that do harm on unseen data leave no more than there was.
        """
        before = max(self.unseen.square, 1e-300)
        return min(self.left / before, 1.0) - left / before

    def power_of(self, solution: np.ndarray) -> float:
        """Sum of squares of the unseen force that a solution (c,) gives."""
        return float(solution @ self.unseen.normal @ solution)
