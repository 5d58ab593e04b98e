"""Real-coded genetic algorithm with the bounds as constraints, over all recordings at once; the end is polished.

    minimise  G = sum over recordings of (1/N) sum (F(t) - F_measured(t))^2,      lower <= q <= upper

Tournament selection, simulated binary crossover, polynomial mutation, and the best always survive (pymoo's
``GA``). The first generation contains the model's values, values of the data's size, and points spread over
the bounds. Bounds far apart of one sign are crossed by ratio, others evenly. Parameters in which the force is
linear are solved for in each individual. A population finds the right valley and creeps in it, so its best is
led to the valley's floor by the trust-region steps of ``least_squares``; the evolution runs on excerpts of
the data, the polish on all of it.

Source: HIS piecewise model, section 4.4, eq. (6), Table 2; Deb and Agrawal 1995 (crossover and mutation).
"""

import numpy as np

from damper_estimator.identification.methods.contract import Method, MethodOptions, Solution
from damper_estimator.identification.methods.least_squares import refine
from damper_estimator.identification.population import Scale, evolve, first_generation
from damper_estimator.identification.problem import Problem

_POPULATION, _GENERATIONS = 60, 60
_REPORT = 10  # generations between two lines of progress


def search(
    problem: Problem, sketch: Problem, candidates: np.ndarray, size: np.ndarray, method_options: MethodOptions
) -> Solution:
    """See the module; raises InputError where pymoo is not installed."""
    if problem.searched.size == 0:
        return Solution(problem.point(problem.start), True, problem.evaluations)
    scale = Scale(problem.lower[problem.searched], problem.upper[problem.searched])
    population = method_options.population or _POPULATION
    start = first_generation(scale, candidates, population, method_options.seed)
    generations = method_options.generations or _GENERATIONS
    worst = 1e3 * sketch.power

    def costs(shares: np.ndarray) -> np.ndarray:
        every = np.array([[sketch.point(values).cost] for values in scale.values(shares)])
        return np.where(np.isfinite(every), every, worst)

    def report(generation: int, best: np.ndarray) -> None:
        if generation % _REPORT == 0:
            method_options.progress(f"generation {generation} of {generations}: best cost {best.min():.4g}")

    shares, found = evolve("ga", costs, start, generations, method_options.seed, report)
    best = scale.values(shares)[int(np.argmin(found[:, 0]))]
    point, converged = refine(problem, problem.clipped(best), size)
    share = sketch.samples / problem.samples
    return Solution(point, converged, problem.evaluations + round(sketch.evaluations * share))


METHOD = Method(search=search)
