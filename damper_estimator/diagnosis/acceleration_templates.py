"""What the coefficient of acceleration over velocity may be: a mass, a shift in time, a spring in series, a valve.

With F' the slope of the model's force over velocity, a mass m has the coefficient m; a force that is late by t,
F(t) - t dF/dt, has -t F'(v); a spring k in series, which takes F'(v)/k dF/dt away, has -F'(v)^2 / k; the mass behind a
valve acts only while that is open.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.diagnosis.atlas_terms import View
from damper_estimator.diagnosis.curve_regression import Regression
from damper_estimator.numerics import hats

_OPENINGS = (0.15, 0.3, 0.5)  # of the driven speed; knots of the curve


@dataclass(frozen=True)
class Template:
    """A form of a curve, scaled to fit best beside all other curves.

    Attributes:
        name: ``mass``, ``shift``, ``series`` or ``valve``.
        value: (k,) at the curve's points.
        size: mass in kg; delay of the force in s; opening speed in m/s; NaN for ``series``, which has a stiffness for
            each direction.
        explains: share of the squared error on unseen data, beside all other curves.
    """

    name: str
    value: tuple[float, ...]
    size: float
    explains: float


def templates_of(
    whole: Regression,
    own: np.ndarray,
    beside: np.ndarray,
    scale: np.ndarray,
    knots: np.ndarray,
    seen: Sequence[View],
) -> tuple[Template, ...]:
    """The templates of the coefficient of acceleration, the one that explains most first.

    Args:
        whole: the regression with all columns (c,).
        own: (c,) bool, the columns of that coefficient.
        beside: (c,) bool, the columns beside which a template counts.
        scale: (c,) kg per coefficient of a column.
        knots: (k,) m/s.
        seen: the fitted recordings.
    """
    columns = np.eye(own.size)
    others = whole.mixed(columns[:, beside])
    used = scale[own] > 0.0
    best: dict[str, tuple[float, Template]] = {}
    for name, shape, size in _shapes(knots, seen):
        mix = columns[:, own][:, used] @ (shape[used] / scale[own][used, None])
        sizes = np.sqrt(np.maximum(np.diag(whole.fit.mixed(mix).normal), 1e-300) / whole.fit.normal.max())
        trial, counted = (whole.mixed(np.hstack([columns[:, those], mix / sizes])) for those in (~own, beside))
        factors = trial.solved()[0][-sizes.size :] / sizes
        known = {"mass": float(factors[0]), "shift": -float(factors[0])}.get(name, size)
        template = Template(name, tuple((shape @ factors).tolist()), known, others.gain(counted.left))
        if name not in best or counted.left_fit < best[name][0]:
            best[name] = counted.left_fit, template
    return tuple(sorted((template for _, template in best.values()), key=lambda one: -one.explains))


def _shapes(knots: np.ndarray, seen: Sequence[View]) -> Iterator[tuple[str, np.ndarray, float]]:
    """Name, (k, p) shapes that are scaled separately, and an opening speed."""
    slope, square = (_over_velocity(knots, seen, power) for power in (1, 2))
    sides = 0.5 * (1.0 + np.outer(np.sign(knots), (1.0, -1.0)))
    yield "mass", np.ones((knots.size, 1)), float("nan")
    yield "shift", slope[:, None], float("nan")
    yield "series", square[:, None] * sides, float("nan")
    for opening in _OPENINGS:
        speed = opening * float(np.abs(knots).max())
        yield "valve", (np.abs(knots) > 0.999 * speed)[:, None] * sides, speed


def _over_velocity(knots: np.ndarray, seen: Sequence[View], power: int) -> np.ndarray:
    """(k,) a power of the model's slope as a curve over velocity."""
    shape = np.concatenate([np.array(hats(view.v, knots)) for view in seen], axis=1)
    slope = np.concatenate([view.slope**power for view in seen])
    normal = shape @ shape.T + 1e-9 * shape.shape[1] * np.eye(knots.size)
    return np.linalg.solve(normal, shape @ slope)
