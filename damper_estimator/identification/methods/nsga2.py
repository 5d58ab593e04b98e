"""NSGA-II over groups of excitations: a Pareto front, of which one point becomes the model.

    e_g(x) = mean over the excitations i of group g of e_i(x) / e_i(x_0),    e_i = (1/N) sum (F(x, t) - F_measured)^2

with x_0 the model's own values, so each objective is 1 at the start. All free parameters are searched between
their bounds, the linear ones as well: solving for them would settle the trade between the groups. The first
generation holds the model's own values, the least-squares solution over all groups and over each, values of
the data's size, and points between the bounds. The point that becomes the model is chosen by ``wishes.pick``;
the default is the front's knee.

Source: Gao et al., eqs. (7), (9), section 3.2.2; Deb et al. 2000 (pymoo's ``NSGA2``).
"""

from dataclasses import replace

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.identification.excited import Excited
from damper_estimator.identification.front import Front, non_dominated
from damper_estimator.identification.methods.contract import Method, Solution, Wishes
from damper_estimator.identification.methods.least_squares import refine
from damper_estimator.identification.population import Scale, evolve, first_generation
from damper_estimator.identification.problem import Problem

_POPULATION, _GENERATIONS = 100, 100
_REPORT = 10  # generations between two lines of progress
_WORST = 100.0  # objective from which on worse is not told apart; also where there is no finite force
_LEAD_ITERATIONS, _LEAD_GAIN = 15, 1e-4  # of the least-squares solutions that the first generation holds


def search(problem: Problem, sketch: Problem, candidates: np.ndarray, size: np.ndarray, wishes: Wishes) -> Solution:
    """See the module; raises InputError where pymoo is missing, or the recordings cannot be grouped as asked."""
    free = np.array(problem.free)
    if wishes.front is None:
        front, evaluations = _evolved(problem, candidates, size, wishes)
        ran = ""
    else:
        front, evaluations = _checked(wishes.front, problem), 0
        ran = "no search was made; "
    row = front.row(wishes.pick)
    vector = problem.vector(problem.start, np.zeros(problem.solved.size))
    vector[free] = np.clip(front.values[row], problem.lower[free], problem.upper[free])
    point = problem.point(vector[problem.searched], vector[problem.solved])
    errors = ", ".join(f"{g} {e:.3g}" for g, e in zip(front.groups, front.objectives[row], strict=True))
    remark = (
        f"{ran}point {row} of {len(front.values)} on the front ({wishes.pick}) was taken, with errors relative to "
        f"the start of {errors}; standard errors are those of the model there, as if all recordings counted alike"
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


def _evolved(problem: Problem, candidates: np.ndarray, size: np.ndarray, wishes: Wishes) -> tuple[Front, int]:
    """The front, and the runs of the model over all data that it took, or their equal."""
    chosen = Excited(problem, wishes.groups)
    small = chosen.problem
    free = np.array(small.free)
    start = _whole(small, small.start)
    before = [np.maximum(own, np.finfo(float).tiny) for own in chosen.errors(start[None, :])[0]]
    counts = ", ".join(f"{group} {len(own)}" for group, own in zip(chosen.groups, chosen.sizes, strict=True))
    wishes.progress(f"excitations by group: {counts}")
    scale = Scale(small.lower[free], small.upper[free])
    generations = wishes.generations or _GENERATIONS
    runs = 0

    def objectives(shares: np.ndarray) -> np.ndarray:
        nonlocal runs
        runs += len(shares)
        own = _objectives(chosen, before, scale.values(shares))
        # Ratios are spread over the front by their logarithms; that leaves alone which is better.
        return np.log(np.maximum(own, np.finfo(float).tiny))

    def told(generation: int, found: np.ndarray) -> None:
        if generation % _REPORT == 0:
            best = ", ".join(f"{g} {np.exp(e):.3g}" for g, e in zip(chosen.groups, found.min(axis=0), strict=True))
            wishes.progress(f"generation {generation} of {generations}: best errors relative to the start: {best}")

    known = np.array([start[free], *_leads(chosen, before, candidates, size)])
    spread = np.array([_whole(small, own, projected=True)[free] for own in candidates[1:]]).reshape(-1, free.size)
    population = wishes.population or _POPULATION
    first = first_generation(scale, np.vstack([known, spread]), population, wishes.seed)
    shares, found = evolve("nsga2", objectives, first, generations, wishes.seed, told)
    # A crowded front drops inner points: what was known before comes back where nothing is better.
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
        excitations=tuple(len(own) for own in chosen.sizes),
    )
    share = small.size / problem.size
    return front, round((runs + small.evaluations) * share)


def _whole(problem: Problem, searched: np.ndarray, projected: bool = False) -> np.ndarray:
    """(slots,) with the model's own linear parameters, or those that suit the searched ones best."""
    own = np.array([problem.slots[i].value for i in problem.solved])
    return problem.vector(searched, problem.point(searched).solved if projected else own)


def _objectives(chosen: Excited, before: list[np.ndarray], values: np.ndarray) -> list[list[float]]:
    """For each set of the free parameters (n, p) the objectives."""
    problem = chosen.problem
    vectors = np.tile(problem.vector(problem.start, np.zeros(problem.solved.size)), (len(values), 1))
    vectors[:, list(problem.free)] = values
    return [_relative(own, before) for own in chosen.errors(vectors)]


def _relative(errors: list[np.ndarray], before: list[np.ndarray]) -> list[float]:
    if not all(np.isfinite(own).all() for own in errors):
        return [_WORST] * len(errors)
    return [min(float(np.mean(own / reference)), _WORST) for own, reference in zip(errors, before, strict=True)]


def _leads(chosen: Excited, before: list[np.ndarray], candidates: np.ndarray, size: np.ndarray) -> list[np.ndarray]:
    """Free parameters of the least-squares solutions over all groups and over each, with the objectives' weights."""
    problem = chosen.problem
    free = np.array(problem.free)
    start = min(candidates, key=lambda own: problem.point(own).cost)
    found = []
    for wanted in [range(len(chosen.groups)), *([k] for k in range(len(chosen.groups)))]:
        weights = [np.zeros(own.size) for own in chosen.sizes]
        for k in wanted:
            weights[k] = 1.0 / (before[k] * chosen.sizes[k] * chosen.sizes[k].size)
        total = sum(float(own @ sizes) for own, sizes in zip(weights, chosen.sizes, strict=True))
        weighted = chosen.weighted([own * (problem.size / total) for own in weights])
        point = weighted.point(start)
        if start.size:
            point, _ = refine(weighted, start, size, _LEAD_ITERATIONS, _LEAD_GAIN)
        found.append(problem.vector(point.searched, point.solved)[free])
        start = point.searched if len(found) == 1 else start
    return found


METHOD = Method(search=search, several=True)
