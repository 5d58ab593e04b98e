"""Hooke and Jeeves' direct search with an external penalty on the bounds, from several starts; needs no derivatives.

    minimise  f(u) = log(cost(q) / cost_0) + w sum(max(0, (q_low - q) / s, (q - q_high) / s)^2),      q = q_0 + s u

Exploration tries one parameter after the other, a step up and a step down; a pattern move then repeats what
the whole round gained, and steps are halved where nothing gains. Each parameter's step is in proportion to
its size s. Outside the bounds the model is run at the nearest bound and the penalty leads back; w grows as
the steps shrink, so the end lies inside. Parameters in which the force is linear are solved for at each
point, as in ``least_squares``. The starts are tried on excerpts of the data, the best is finished on all of
it. It is the choice where derivatives fail: dead bands, switches, delays.

Source: Hooke and Jeeves 1961; the black-box paper's identification (there with three starts; external
penalty); Lozoya-Santos et al., where derivatives fail.
"""

from collections.abc import Callable

import numpy as np

from damper_estimator.identification.methods.contract import Method, MethodOptions, Solution
from damper_estimator.identification.problem import Problem

_STARTS = 3
_FIRST_STEP = 0.25  # of a parameter's size
_SKETCH_STEP = 1e-3  # at which the trial of a start ends
_LAST_STEP = 1e-6  # where the search ends
_FIRST_PENALTY = 10.0  # per square of a size beyond the bound
_PENALTY_GROWTH = 10.0  # per halving of the steps: a bound that the cost presses against is met at the end
_MOST = 400  # evaluations per searched parameter


def search(
    problem: Problem, sketch: Problem, candidates: np.ndarray, size: np.ndarray, method_options: MethodOptions
) -> Solution:
    """See the module; deterministic: the seed acts on the candidates only."""
    if problem.searched.size == 0:
        return Solution(problem.point(problem.start), True, problem.evaluations)
    costs = np.array([sketch.point(candidate).cost for candidate in candidates])
    # The model's values are always tried.
    order = [0, *(int(i) for i in np.argsort(costs, kind="stable") if i != 0)][:_STARTS]
    ends = []
    for number, i in enumerate(i for i in order if np.isfinite(costs[i])):
        ends.append(descend(sketch, candidates[i], size, _FIRST_STEP, _SKETCH_STEP))
        method_options.progress(
            f"start {number + 1}: cost {sketch.point(sketch.clipped(ends[-1][0])).cost / costs[0]:.3g}"
        )
    if not ends:
        return Solution(problem.point(problem.start), False, problem.evaluations)
    best = min((end[0] for end in ends), key=lambda end: sketch.point(sketch.clipped(end)).cost)
    end, converged = descend(problem, best, size, 8.0 * _SKETCH_STEP, _LAST_STEP)
    share = sketch.samples / problem.samples
    point = problem.point(problem.clipped(end))
    return Solution(point, converged, problem.evaluations + round(sketch.evaluations * share))


def descend(problem: Problem, start: np.ndarray, size: np.ndarray, step: float, last: float) -> tuple[np.ndarray, bool]:
    """The end (q,) of one search, and whether its steps shrank to ``last``; steps are shares of ``size`` (q,)."""
    scale = np.maximum(np.abs(start), 0.1 * size)
    lower, upper = problem.lower[problem.searched], problem.upper[problem.searched]
    reference = max(problem.point(problem.clipped(start)).cost, np.finfo(float).tiny)
    penalty, budget = _FIRST_PENALTY, problem.evaluations + _MOST * start.size

    def objective(u: np.ndarray) -> float:
        values = start + scale * u
        beyond = np.maximum(0.0, np.maximum(lower - values, values - upper)) / scale
        cost = problem.point(np.clip(values, lower, upper)).cost
        # The logarithm keeps the penalty in proportion to the cost, however far the search has come.
        return float(np.log(max(cost, 1e-30 * reference) / reference) + penalty * (beyond @ beyond))

    base = np.zeros(start.size)
    value = objective(base)
    while step > last and problem.evaluations < budget:
        found, better = _explored(objective, base, value, step)
        if better < value:
            base, value = _followed(objective, base, found, better, step)
        else:
            step, penalty = 0.5 * step, penalty * _PENALTY_GROWTH
            value = objective(base)
    return np.clip(start + scale * base, lower, upper), step <= last


def _explored(
    objective: Callable[[np.ndarray], float], base: np.ndarray, value: float, step: float
) -> tuple[np.ndarray, float]:
    """The best point next to ``base``, one parameter after the other."""
    point = base.copy()
    for j in range(point.size):
        for change in (step, -step):
            trial = point.copy()
            trial[j] += change
            cost = objective(trial)
            if cost < value:
                point, value = trial, cost
                break
    return point, value


def _followed(
    objective: Callable[[np.ndarray], float], base: np.ndarray, point: np.ndarray, value: float, step: float
) -> tuple[np.ndarray, float]:
    """Pattern moves from ``base`` through ``point`` for as long as each gains."""
    while True:
        ahead = 2.0 * point - base
        found, better = _explored(objective, ahead, objective(ahead), step)
        if better >= value or np.array_equal(found, point):
            return point, value
        base, point, value = point, found, better


METHOD = Method(search=search)
