"""NSGA-II over groups of excitations: a Pareto front, of which one point becomes the model.

    e_g(x) = mean over the excitations i of group g of e_i(x) / e_i(x_0),    e_i = (1/N) sum (F(x, t) - F_measured)^2

with x_0 the model's values, so each objective is 1 at the start. All free parameters are searched between
their bounds, the linear ones as well: solving for them would settle the trade between the groups. The first
generation holds the model's values, the least-squares solution over all groups and over each, values of
the data's size, and points between the bounds. The point that becomes the model is chosen by ``method_options.pick``;
the default is the front's knee.

Source: Gao et al., eqs. (7), (9), section 3.2.2; Deb et al. 2000 (pymoo's ``NSGA2``).
"""

from dataclasses import replace

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.identification.excitation_problem import ExcitationProblem
from damper_estimator.identification.methods.contract import Method, MethodOptions, Solution
from damper_estimator.identification.methods.least_squares import refine
from damper_estimator.identification.pareto_front import Front, non_dominated
from damper_estimator.identification.population import Scale, evolve, first_generation
from damper_estimator.identification.problem import Problem

_POPULATION, _GENERATIONS = 100, 100
_REPORT = 10  # generations between two lines of progress
_WORST = 100.0  # largest objective, above which all are equal; also without a finite force
_LEAD_ITERATIONS, _LEAD_GAIN = 15, 1e-4  # of the least-squares solutions that the first generation holds


def search(
    problem: Problem, sketch: Problem, candidates: np.ndarray, size: np.ndarray, method_options: MethodOptions
) -> Solution:
    """See the module; raises InputError where pymoo is missing, or the recordings cannot be grouped as asked."""
    free = np.array(problem.free)
    if method_options.front is None:
        front, evaluations = _evolved(problem, candidates, size, method_options)
        ran = ""
    else:
        front, evaluations = _checked(method_options.front, problem), 0
        ran = "no search was made; "
    row = front.row(method_options.pick)
    vector = problem.vector(problem.start, np.zeros(problem.solved.size))
    vector[free] = np.clip(front.values[row], problem.lower[free], problem.upper[free])
    point = problem.point(vector[problem.searched], vector[problem.solved])
    errors = ", ".join(f"{g} {e:.3g}" for g, e in zip(front.groups, front.objectives[row], strict=True))
    remark = (
        f"{ran}point {row} of {len(front.values)} on the front ({method_options.pick}) was taken, with errors relative "
        f"to the start of {errors}; standard errors are those of the model there, as if all recordings counted alike"
    )
    return Solution(point, True, evaluations + problem.evaluations, remark, replace(front, picked=row))


def _checked(front: Front, problem: Problem) -> Front:
    names = tuple(problem.slots[i].address for i in problem.free)
    if front.names != names:
        raise InputError(
            f"the front holds {', '.join(front.names)}, but to identify are {', '.join(names)}; "
            "give the options it was made with"
        )
    return front


def _evolved(
    problem: Problem, candidates: np.ndarray, size: np.ndarray, method_options: MethodOptions
) -> tuple[Front, int]:
    """The front, and its cost in runs of the model over all data."""
    chosen = ExcitationProblem(problem, method_options.groups)
    small = chosen.problem
    free = np.array(small.free)
    start = _whole(small, small.start)
    before = [np.maximum(errors, np.finfo(float).tiny) for errors in chosen.errors(start[None, :])[0]]
    counts = ", ".join(f"{group} {len(sizes)}" for group, sizes in zip(chosen.groups, chosen.sizes, strict=True))
    method_options.progress(f"excitations by group: {counts}")
    scale = Scale(small.lower[free], small.upper[free])
    generations = method_options.generations or _GENERATIONS
    runs = 0

    def objectives(shares: np.ndarray) -> np.ndarray:
        nonlocal runs
        runs += len(shares)
        ratios = _objectives(chosen, before, scale.values(shares))
        # Logarithms spread the ratios over the front and keep their order.
        return np.log(np.maximum(ratios, np.finfo(float).tiny))

    def report(generation: int, found: np.ndarray) -> None:
        if generation % _REPORT == 0:
            best = ", ".join(f"{g} {np.exp(e):.3g}" for g, e in zip(chosen.groups, found.min(axis=0), strict=True))
            method_options.progress(
                f"generation {generation} of {generations}: best errors relative to the start: {best}"
            )

    known = np.array([start[free], *_leads(chosen, before, candidates, size)])
    spread = np.array([_whole(small, candidate, projected=True)[free] for candidate in candidates[1:]]).reshape(
        -1, free.size
    )
    population = method_options.population or _POPULATION
    first = first_generation(scale, np.vstack([known, spread]), population, method_options.seed)
    shares, found = evolve("nsga2", objectives, first, generations, method_options.seed, report)
    # A crowded front drops inner points: the solutions known before return where nothing is better.
    shares = np.unique(np.vstack([shares, scale.shares(known)]), axis=0)
    found = np.exp(objectives(shares))
    kept = non_dominated(found)
    shares, found = shares[kept], found[kept]
    order = np.lexsort(found.T[::-1])
    front = Front(
        names=tuple(small.slots[i].address for i in free),
        groups=chosen.groups,
        values=scale.values(shares)[order],
        objectives=found[order],
        excitations=tuple(len(sizes) for sizes in chosen.sizes),
    )
    share = small.size / problem.size
    return front, round((runs + small.evaluations) * share)


def _whole(problem: Problem, searched: np.ndarray, projected: bool = False) -> np.ndarray:
    """(slots,) with the model's linear parameters, or those that suit the searched ones best."""
    linear = np.array([problem.slots[i].value for i in problem.solved])
    return problem.vector(searched, problem.point(searched).solved if projected else linear)


def _objectives(chosen: ExcitationProblem, before: list[np.ndarray], values: np.ndarray) -> list[list[float]]:
    """For each set of the free parameters (n, p) the objectives."""
    problem = chosen.problem
    vectors = np.tile(problem.vector(problem.start, np.zeros(problem.solved.size)), (len(values), 1))
    vectors[:, list(problem.free)] = values
    return [_relative(errors, before) for errors in chosen.errors(vectors)]


def _relative(errors: list[np.ndarray], before: list[np.ndarray]) -> list[float]:
    if not all(np.isfinite(group).all() for group in errors):
        return [_WORST] * len(errors)
    return [min(float(np.mean(group / reference)), _WORST) for group, reference in zip(errors, before, strict=True)]


def _leads(
    chosen: ExcitationProblem, before: list[np.ndarray], candidates: np.ndarray, size: np.ndarray
) -> list[np.ndarray]:
    """Free parameters of the least-squares solutions over all groups and over each, with the objectives' weights."""
    problem = chosen.problem
    free = np.array(problem.free)
    start = min(candidates, key=lambda candidate: problem.point(candidate).cost)
    found = []
    for wanted in [range(len(chosen.groups)), *([k] for k in range(len(chosen.groups)))]:
        weights = [np.zeros(sizes.size) for sizes in chosen.sizes]
        for k in wanted:
            weights[k] = 1.0 / (before[k] * chosen.sizes[k] * chosen.sizes[k].size)
        total = sum(float(counts @ sizes) for counts, sizes in zip(weights, chosen.sizes, strict=True))
        weighted = chosen.weighted([counts * (problem.size / total) for counts in weights])
        point = weighted.point(start)
        if start.size:
            point, _ = refine(weighted, start, size, _LEAD_ITERATIONS, _LEAD_GAIN)
        found.append(problem.vector(point.searched, point.solved)[free])
        start = point.searched if len(found) == 1 else start
    return found


METHOD = Method(search=search, several=True)
