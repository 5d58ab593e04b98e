"""Ties table points that the data do not determine to those that they do; see ``model.continuation`` for how.

With G = J'J over the points of one curve or surface, each of which adds its share phi of its value to the force, the
data reach point k as far as

    r_k = G_kk / sum over k and its neighbours j of G_kj        (the mean of phi_k, weighted by itself)

because the shares of a sample add up to one: 1 where the samples lie at the point itself, 0.1 where they come a tenth
of the way from its neighbour. An error of the force there, of whatever origin, comes back 1 / r times in the point,
so it is tied where

    r_k < 2 e,        e = rms of the fit's residual over rms of the force,

and 2 e between ``LEAST`` and ``MOST``, unless tying it would cost a fifth of the residual's square: then many samples
agree on the force there. Duplicate data do not change this. On simulated dampers
an outer point was as wrong free as continued at about that reach; below, free points soon had any sign.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from damper_estimator.effects.contract import Setting
from damper_estimator.identification.knots import AXES
from damper_estimator.identification.problem import Linearised, Point, Problem
from damper_estimator.identification.unknowns import Unknowns
from damper_estimator.model import DamperModel
from damper_estimator.model.continuation import Axis, continuation
from damper_estimator.model.element import labels
from damper_estimator.numerics import bounded_least_squares
from damper_estimator.signals.layout import V

LEAST, MOST = 0.02, 0.3
_AMPLIFIED = 2.0  # e over r: half of the force's rms may come back in the point
_DEAR = 0.2  # of the residual's square
_SAME = 1e-9  # of the cost: rounding
_NOTHING = 1e-12  # of the largest influence of a point of the table


@dataclass(frozen=True)
class Table:
    """A parameter that is a table over channels.

    Attributes:
        places: positions of its points in a model's ``slots``, in the table's shape.
        axes: of that shape.
    """

    places: np.ndarray
    axes: tuple[Axis, ...]

    def continued(self, known: np.ndarray, values: np.ndarray) -> np.ndarray:
        """(n, n) weights of all points, from flat ``known`` and ``values``; see ``continuation``."""
        shape = self.places.shape
        return continuation(self.axes, known.reshape(shape), values.reshape(shape))

    def rises(self, point: int, known: np.ndarray, values: np.ndarray) -> bool:
        """Whether the force continues in the direction of damping from the known points to one outside them."""
        level = continuation(
            [replace(axis, straight=False) for axis in self.axes],
            known.reshape(self.places.shape),
            values.reshape(self.places.shape),
        )
        change = values[point] - level[point] @ values
        where = np.array(np.unravel_index(np.arange(known.size), self.places.shape))
        for axis, index in zip(self.axes, where, strict=True):
            inside = index[known]
            outside = int(index[point] > inside.max()) - int(index[point] < inside.min())
            if axis.straight and outside * change < 0.0:
                return False
        return True


def tables(model: DamperModel) -> list[Table]:
    """Every parameter of the model whose length is that of rising settings."""
    slots: dict[tuple[int, str], list[int]] = {}
    for position, slot in enumerate(model.slots):
        slots.setdefault((slot.entry, slot.parameter.name), []).append(position)
    found = []
    for entry, (_, element) in enumerate(labels(model.effects)):
        rising = {s.name: s for s in element.effect.settings if s.increasing}
        for parameter in element.effect.parameters:
            names = parameter.axes
            if names and all(name in rising for name in names):
                axes = tuple(_axis(rising[name], element.settings[name]) for name in names)
                places = np.reshape(slots[entry, parameter.name], [axis.knots.size for axis in axes])
                found.append(Table(places, axes))
    return found


def _axis(setting: Setting, knots: tuple[float, ...]) -> Axis:
    """Only along the velocity, with its sign, is it known which way a force continues."""
    return Axis(np.asarray(knots), AXES.get(setting.unit) == V and setting.lower < 0.0)


@dataclass(frozen=True)
class Ties:
    """Which slots follow which others.

    Attributes:
        tied: positions in a problem's slots.
        weights: (slots, slots): all values = weights @ values; the unit matrix except for the rows of ``tied``.
    """

    tied: tuple[int, ...]
    weights: np.ndarray


def with_inert_at_start(problem: Problem, point: Point, linear: Linearised) -> Point:
    """The point with the model's value of every parameter that has no influence, since a random search leaves an
    arbitrary one. Where the force does depend on it, the point is returned unchanged.
    """
    order = np.concatenate([problem.searched, problem.solved])
    values = problem.vector(point.searched, point.solved)
    silent = order[~linear.reduced[:, :-1].any(axis=0)]
    model_values = [problem.slots[slot].value for slot in problem.solved]
    start = np.clip(problem.vector(problem.start, np.array(model_values)), problem.lower, problem.upper)
    if (values[silent] == start[silent]).all():
        return point
    values[silent] = start[silent]
    calm = problem.point(values[problem.searched], values[problem.solved])
    return calm if calm.cost <= (1.0 + _SAME) * point.cost else point


def tied(problem: Problem, point: Point, linear: Linearised) -> Ties:
    """The points of tables that the data leave open at the end of a search; ``linear`` at that point."""
    order = np.concatenate([problem.searched, problem.solved])
    jacobian = linear.reduced[:, :-1]
    values = problem.vector(point.searched, point.solved)
    return find_ties(_tables_of(problem), values, order, jacobian.T @ jacobian, problem.power, point.cost)


def find_ties(
    every: Sequence[Table],
    values: np.ndarray,
    free: Sequence[int] | np.ndarray,
    influence: np.ndarray,
    power: float,
    cost: float,
) -> Ties:
    """The points of tables that the data leave open.

    Args:
        values: (slots,).
        free: (f,) positions that were identified; no other is tied.
        influence: (f, f) J'J.
        power: sum of the squares of the measured force.
        cost: half of the sum of squares of the residual.
    """
    left = np.sqrt(2.0 * cost / power) if power > 0.0 else 0.0
    place = np.full(values.size, -1)
    place[free] = np.arange(len(free))
    least = float(np.clip(_AMPLIFIED * left, LEAST, MOST))
    weights, found = np.eye(values.size), set()
    for table in every:
        flat = table.places.ravel()
        free_points = np.flatnonzero(place[flat] >= 0)
        columns = place[flat[free_points]]
        part = influence[np.ix_(columns, columns)]
        known = np.ones(flat.size, bool)
        known[free_points] = _reach(table, free_points, part) >= least
        known[free_points] |= _objecting(table, values[flat], known, free_points, part, _DEAR * 2.0 * cost)
        if known.any() and not known.all():
            weights[np.ix_(flat, flat)] = table.continued(known, values[flat])
            found |= set(flat[~known].tolist())
    return Ties(tuple(sorted(found)), weights)


def _objecting(
    table: Table, values: np.ndarray, known: np.ndarray, free: np.ndarray, influence: np.ndarray, dear: float
) -> np.ndarray:
    """(k,) bool: points ``free`` out of reach to which the data still object being tied: it would cost more than
    ``dear`` in squares, all known points adapting, and the force that they ask for does not fall.
    """
    objecting = np.zeros(free.size, bool)
    if not known.any():
        return objecting
    away = values - table.continued(known, values) @ values
    determined = known[free]
    for k in np.flatnonzero(~determined):
        shared = influence[determined, k]
        alone = (
            influence[k, k]
            - shared @ np.linalg.lstsq(influence[np.ix_(determined, determined)], shared, rcond=1e-10)[0]
        )
        objecting[k] = away[free[k]] ** 2 * alone > dear and table.rises(int(free[k]), known, values)
    return objecting


def _tables_of(problem: Unknowns) -> list[Table]:
    """In the problem's slots; of a table that differs between the settings of a joint fit one for each."""
    found = {}
    for table in tables(problem.model):
        for places in problem.places:
            found[places[table.places].tobytes()] = Table(places[table.places], table.axes)
    return list(found.values())


def with_ties_applied(
    problem: Problem, point: Point, linear: Linearised, ties: Ties, reach: np.ndarray | None
) -> Point:
    """The point with the ties applied.

    Args:
        linear: the rows near the point.
        reach: (q,) how far the searched parameters may move to reduce the cost, together with the solved ones;
            None moves nothing else.
    """
    values = problem.vector(point.searched, point.solved)
    start = ties.weights @ values
    found = [start]
    if reach is not None:
        order = np.concatenate([problem.searched, problem.solved])
        kept = order[~np.isin(order, ties.tied)]
        far = np.full(values.size, np.inf)
        far[problem.searched] = reach
        jacobian = linear.reduced[:, :-1]
        residual = linear.reduced[:, -1] + jacobian @ (start - values)[order]
        low = np.maximum(problem.lower - values, -far)[kept]
        high = np.minimum(problem.upper - values, far)[kept]
        step = np.zeros(values.size)
        step[kept] = bounded_least_squares(
            jacobian @ ties.weights[np.ix_(order, kept)], -residual, low, high, np.clip(np.zeros(kept.size), low, high)
        )
        found.append(ties.weights @ (values + step))
    found = [np.clip(candidate, problem.lower, problem.upper) for candidate in found]
    return min(
        (problem.point(values[problem.searched], values[problem.solved]) for values in found), key=lambda end: end.cost
    )


def _reach(table: Table, free: np.ndarray, influence: np.ndarray) -> np.ndarray:
    """(k,) how far the data reach the table's points ``free`` (k,), given their J'J (k, k)."""
    where = np.array(np.unravel_index(free, table.places.shape))
    near = (np.abs(where[:, :, None] - where[:, None, :]) <= 1).all(axis=0)
    amount = np.diag(influence)
    touched = (influence * near).sum(axis=1)
    # Where the gauge's zero is free, the shares of a table of few points may add up to nothing.
    reach = np.divide(amount, touched, out=np.ones_like(amount), where=touched > amount)
    return np.where(amount > _NOTHING * amount.max(initial=0.0), reach, 0.0)
