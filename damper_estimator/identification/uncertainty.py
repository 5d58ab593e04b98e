"""How well the data determine the parameters: standard errors, and parameters that trade off against each other.

See ``numerics.covariance``. Band-limited residuals are autocorrelated: only independent samples count. The residual is
taken as stationary within each recording; where a model lacks an effect, it is not noise alone, and the errors are
those of this excitation.
"""

from dataclasses import dataclass

import numpy as np

from damper_estimator.identification.problem import Linearised, Point, Problem
from damper_estimator.identification.ties import Ties
from damper_estimator.numerics import Directions, directions

_WEAK = 0.1  # directions below this are tested for whether the noise hides them
_HIDDEN = 0.5  # of a parameter's contribution: more uncertain than this, and the direction is not determined
_TAKES_PART = 0.2  # of the largest share in a direction, or of the hidden part: enough to be listed
_LINKED = 0.1  # correlation of two parameters in the directions without influence
_FLOOR = 0.02  # of the force: a contribution is not taken as smaller
_AT_BOUND = 1e-9  # of the distance of the bounds


@dataclass(frozen=True)
class Uncertainty:
    """How well the data determine the free parameters.

    Attributes:
        standard_error: (free,) in order of ``Problem.free``; NaN at a bound, where the data say nothing or it is
            wider than the bounds, and for the points of a table that follow others.
        at_bound: (free,) bool.
        undetermined: groups of addresses that these data cannot separate; a group of one has no influence.
        tied: addresses of the points of tables that follow others; each is a group of one in ``undetermined`` too.
    """

    standard_error: np.ndarray
    at_bound: np.ndarray
    undetermined: tuple[tuple[str, ...], ...]
    tied: tuple[str, ...] = ()


def uncertainty(problem: Problem, point: Point, linear: Linearised, ties: Ties) -> Uncertainty:
    """Standard errors and trade-offs of untied parameters at the end of a search; ``linear`` at that point."""
    every = np.array(problem.free)
    kept = ~np.isin(every, ties.tied)
    free = every[kept]
    values = problem.vector(point.searched, point.solved)[free]
    low, high = problem.lower[free], problem.upper[free]
    at_bound = np.minimum(values - low, high - values) <= _AT_BOUND * (high - low)
    basis = ties.weights[np.ix_(np.concatenate([problem.searched, problem.solved]), free)]
    whole = _directions(linear, basis)
    inner = whole if not at_bound.any() else _directions(linear, basis[:, ~at_bound])
    error = np.full(free.size, np.nan)
    blind = inner.undetermined | (inner.spread > (high - low)[~at_bound])
    error[~at_bound] = np.where(blind, np.nan, inner.spread)
    # A parameter may be at its bound only because another replaces it, so both are tested here.
    contributions = np.maximum(np.abs(values) * whole.norms, _FLOOR * np.sqrt(problem.power))
    groups = [group for group in _undetermined(whole, contributions) if len(group) > 1 or not at_bound[group[0]]]
    for group in groups:
        if at_bound[group].any():  # only the bound fixes the others of its group
            error[group] = np.nan
    addresses = [problem.slots[slot].address for slot in free]
    following = tuple(problem.slots[slot].address for slot in ties.tied)
    errors, bounded = np.full(every.size, np.nan), np.zeros(every.size, bool)
    errors[kept], bounded[kept] = error, at_bound
    undetermined = [tuple(addresses[i] for i in group) for group in groups] + [(address,) for address in following]
    return Uncertainty(errors, bounded, tuple(undetermined), following)


def _directions(linear: Linearised, basis: np.ndarray) -> Directions:
    """Of parameters, each of which moves those of the Jacobian by a column of ``basis`` (q + p, k)."""
    return directions(linear.reduced[:, :-1] @ basis, lambda weights: linear.noise(basis @ weights))


def _undetermined(known: Directions, contributions: np.ndarray) -> list[list[int]]:
    """Groups of parameters whose common direction the data do not determine, or less than the noise hides."""
    silent = np.isinf(known.deviation)
    groups = _connected(known.vectors[silent], contributions) if silent.any() else []
    weak = ~silent & (known.singular < _WEAK * known.singular.max(initial=0.0))
    for i in reversed(np.flatnonzero(weak)):
        # How much of itself each parameter must give up to move along the direction as far as the noise hides.
        hidden = known.deviation[i] * np.abs(known.vectors[i]) / contributions
        group = np.flatnonzero(hidden > _TAKES_PART * _HIDDEN).tolist()
        if hidden.max() > _HIDDEN and group not in groups:
            groups.append(group)
    return groups


def _connected(silent: np.ndarray, contributions: np.ndarray) -> list[list[int]]:
    """Parameters that move together in the space (s, k) that the data do not determine, whatever its basis."""
    projector = silent.T @ silent
    amount = np.diag(projector)
    share = amount / contributions**2
    left = [
        int(i)
        for i in np.flatnonzero((amount > _TAKES_PART**2 * amount.max()) | (share > _TAKES_PART**2 * share.max()))
    ]
    linked = projector**2 > _LINKED**2 * np.outer(amount, amount)
    groups = []
    while left:
        group = [left.pop(0)]
        for member in group:
            joined = [i for i in left if linked[member, i]]
            group += joined
            left = [i for i in left if i not in joined]
        groups.append(sorted(group))
    return groups
