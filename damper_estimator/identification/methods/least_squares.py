"""Trust-region least squares between bounds, with the linear parameters solved for (variable projection).

    minimise  sum over rows of (c(q) + Phi(q) p - F)^2,      lower <= q, p <= upper

Each step solves the linearised problem in q and p together inside a box: the bounds, cut by a trust region that is
proportional to each parameter's size; p is then solved for exactly at the new q. Several starts are tried on
excerpts of the data, at the rate that the band asks for, until two of them agree; the best is refined on all of it at
that rate, and finished on all samples. Source: Golub and Pereyra 2003
(variable projection), Kaufman 1975 (the step); Lozoya-Santos et al. identify by the trust region as well.
"""

from collections.abc import Callable

import numpy as np

from damper_estimator.identification.methods.contract import Method, MethodOptions, Solution
from damper_estimator.identification.methods.remaining import Remaining
from damper_estimator.identification.problem import Point, Problem
from damper_estimator.numerics import bounded_least_squares

_ITERATIONS = 60
_GAIN = 1e-8  # of the cost: a promised gain below this is a hundredth of a standard error or less
_SKETCH_GAIN = 1e-5  # the same while starts are compared
_THINNED_GAIN = 1e-6  # the same on thinned data, and on all data after them: a twentieth of a standard error
_MOVE = 1e-7  # of a parameter's size
_WIDEST = 1e6  # of the sizes: no parameter has further to go
_CREEP = 1e-3  # of the cost: a smaller gain in two steps is slow
_PERFECT = 1e-22  # of the force's square: rounding
_STARTS = 5
_USUAL = 8  # iterations on all data
_AGREE = 1e-3  # of the cost: two ends are the same
_SKETCH_ITERATIONS = 25
_AT_BOUND = 1e-9  # of the distance of the bounds


def search(
    problem: Problem, sketch: Problem, candidates: np.ndarray, size: np.ndarray, method_options: MethodOptions
) -> Solution:
    """See the module; deterministic: the seed acts on the candidates only."""
    if problem.searched.size == 0:
        return Solution(problem.point(problem.start), True, problem.evaluations)
    thinned = problem.thinned()
    parts = {id(part): part for part in (sketch, thinned, problem)}.values()
    remaining, each = Remaining(method_options.progress), problem.searched.size + 2

    def report(text: str, left: float) -> None:
        """``left``: expected remaining iterations, in iterations on all data."""
        remaining(text, sum(part.evaluations * part.samples for part in parts), left * each * problem.samples)

    start = best_start(sketch, candidates, size, lambda text: report(text, _USUAL))
    near = released(thinned, start, candidates[0])
    if thinned is not problem:
        near = refine(thinned, near, size, gain=method_options.gain or _THINNED_GAIN)[0].searched
    if problem.point(near).cost > problem.point(start).cost:
        near = start  # the samples between the thinned ones decide
    gain = method_options.gain or (_GAIN if thinned is problem else _THINNED_GAIN)

    def finish(begin: np.ndarray) -> tuple[Point, bool]:
        return refine(
            problem, begin, size, gain=gain,
            report=lambda k: report(f"iteration {k + 1} on all samples", max(_USUAL - k, 1)),
        )  # fmt: skip

    point, converged = finish(near)
    freed = released(problem, point.searched, candidates[0])
    if freed is not point.searched:
        point, converged = finish(freed)
    shorter = [part for part in (sketch, thinned) if part is not problem]
    elsewhere = sum(part.evaluations * part.samples / problem.samples for part in shorter)
    return Solution(point, converged, problem.evaluations + round(elsewhere))


def best_start(
    sketch: Problem,
    candidates: np.ndarray,
    size: np.ndarray,
    report: Callable[[str], None] = lambda text: None,
) -> np.ndarray:
    """The end of the best of several searches on the excerpts; the model's values are always tried."""
    if len(candidates) == 1:
        return candidates[0]
    costs = np.array([sketch.point(candidate).cost for candidate in candidates])
    order = [0, *(int(i) for i in np.argsort(costs, kind="stable") if i != 0)]
    ends: list[Point] = []
    for number, i in enumerate(order[:_STARTS], 1):
        report(f"start {number} of at most {_STARTS}")
        if np.isfinite(costs[i]):
            ends.append(refine(sketch, candidates[i], size, _SKETCH_ITERATIONS, _SKETCH_GAIN)[0])
        ends.sort(key=lambda end: end.cost)
        if len(ends) > 1 and ends[1].cost <= ends[0].cost * (1.0 + _AGREE):
            break
    return ends[0].searched if ends else candidates[0]


def released(problem: Problem, values: np.ndarray, model: np.ndarray) -> np.ndarray:
    """The searched values; those at a bound are put back to the model's where that is better.

    Excerpts, and a search far from its end, may drive a parameter to where it no longer acts: a lag of no time.
    """
    low, high = problem.lower[problem.searched], problem.upper[problem.searched]
    at_bound = np.minimum(values - low, high - values) <= _AT_BOUND * (high - low)
    least = float("inf")
    for j in np.flatnonzero(at_bound & (np.abs(values - model) > _AT_BOUND * (high - low))):
        least = min(least, problem.point(values).cost)
        back = values.copy()
        back[j] = model[j]
        cost = problem.point(back).cost
        if cost < (1.0 - _AGREE) * least:
            least, values = cost, back
    return values


def refine(
    problem: Problem,
    start: np.ndarray,
    size: np.ndarray,
    iterations: int = _ITERATIONS,
    gain: float = _GAIN,
    report: Callable[[int], None] = lambda iteration: None,
) -> tuple[Point, bool]:
    """The local minimum reached from ``start``, and whether the search converged.

    Args:
        start: (q,) between the bounds.
        size: (q,) magnitude of each parameter; below a tenth of it a parameter moves as if it were that large.
        gain: share of the cost; the search ends where a step promises less.
        report: is called with the number of each iteration.
    """
    point = problem.point(start)
    if not np.isfinite(point.cost):
        return point, False
    perfect = _PERFECT * problem.power
    radius, passed = 1.0, [point]
    for iteration in range(iterations):
        report(iteration)
        passed = _leap(problem, passed)
        point = passed[-1]
        scale = np.maximum(np.abs(point.searched), 0.1 * size)
        reduced = problem.linearised(point, scale).reduced
        if not np.isfinite(reduced).all():
            return point, False
        is_failed = False
        while True:
            step, promised = _step(problem, point, reduced, radius * scale)
            length = float(np.max(np.abs(step) / scale))
            promises_little, is_limited = promised <= gain * point.cost, length > 0.9 * radius
            if promises_little and is_limited and not is_failed and radius < _WIDEST:
                radius *= 10.0  # a minimum may lie beyond it
                continue
            if promises_little or point.cost <= perfect or length <= _MOVE:
                return point, True
            trial = problem.point(problem.clipped(point.searched + step))
            ratio = (point.cost - trial.cost) / promised
            if ratio < 0.25:
                is_failed = True
                radius = 0.25 * min(radius, length)
            elif ratio > 0.7 and is_limited:
                radius *= 3.0
            if ratio > 1e-4:
                passed = [*passed[-2:], trial]
                break
    return passed[-1], False


def _leap(problem: Problem, passed: list[Point]) -> list[Point]:
    """The points passed; where the search creeps along a bent valley, a better one far along it instead."""
    point = passed[-1]
    if len(passed) < 3 or passed[0].cost - point.cost > _CREEP * point.cost:
        return passed
    stride = point.searched - passed[0].searched
    while (trial := problem.point(problem.clipped(point.searched + stride))).cost < point.cost:
        point, stride = trial, 2.0 * stride
    return passed if point is passed[-1] else [point]


def _step(problem: Problem, point: Point, reduced: np.ndarray, reach: np.ndarray) -> tuple[np.ndarray, float]:
    """Step (q,) of the searched parameters within ``reach``, and the gain that the linearised problem promises."""
    lower = np.concatenate(
        [
            np.maximum(problem.lower[problem.searched] - point.searched, -reach),
            problem.lower[problem.solved] - point.solved,
        ]
    )
    upper = np.concatenate(
        [
            np.minimum(problem.upper[problem.searched] - point.searched, reach),
            problem.upper[problem.solved] - point.solved,
        ]
    )
    count = lower.size
    step = bounded_least_squares(
        reduced[:, :count], -reduced[:, count], lower, upper, np.clip(np.zeros(count), lower, upper)
    )
    left = reduced[:, :count] @ step + reduced[:, count]
    return step[: point.searched.size], 0.5 * float(reduced[:, count] @ reduced[:, count] - left @ left)


METHOD = Method(search=search)
