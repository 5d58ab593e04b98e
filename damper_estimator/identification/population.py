"""Evolution of a population of parameter sets between bounds, shared by the genetic methods."""

from collections.abc import Callable

import numpy as np

from damper_estimator.errors import InputError

_DECADES = 30.0  # upper over lower bound: from which a parameter is searched by ratio
_OPEN_BELOW = 1e-4  # of the upper bound, stands for a lower bound of zero on a ratio scale
_MISSING = "this method needs pymoo, which is not installed; install it: pip install 'pymoo>=0.6.1'"


class Scale:
    """Maps parameters between their bounds to shares from 0 to 1: by ratio between distant bounds, otherwise evenly."""

    def __init__(self, lower: np.ndarray, upper: np.ndarray):
        """``lower`` and ``upper`` (p,)."""
        sign = np.where(upper <= 0.0, -1.0, 1.0)
        smallest = np.where(upper <= 0.0, -upper, lower)
        largest = np.where(upper <= 0.0, -lower, upper)
        self._lower, self._upper, self._sign = lower, upper, sign
        self._low = np.maximum(smallest, _OPEN_BELOW * largest)
        self._high = largest
        self._ratio = (smallest >= 0.0) & (largest > _DECADES * self._low)

    def values(self, shares: np.ndarray) -> np.ndarray:
        """Parameters (k, p) at shares (k, p)."""
        even = self._lower + shares * (self._upper - self._lower)
        with np.errstate(all="ignore"):
            # A share of zero is the bound itself, also where that is zero.
            ratio = self._sign * self._low * (self._high / self._low) ** shares
        chosen = np.where(self._ratio & (shares > 0.0), ratio, even)
        return np.clip(chosen, self._lower, self._upper)

    def shares(self, values: np.ndarray) -> np.ndarray:
        """Shares (k, p) of parameters (k, p)."""
        span = np.where(self._upper > self._lower, self._upper - self._lower, 1.0)
        even = (values - self._lower) / span
        with np.errstate(all="ignore"):
            ratio = np.log(np.abs(values) / self._low) / np.log(self._high / self._low)
        return np.clip(np.where(self._ratio, np.nan_to_num(ratio, neginf=0.0), even), 0.0, 1.0)


def first_generation(scale: Scale, candidates: np.ndarray, count: int, seed: int) -> np.ndarray:
    """Shares (count, p): the candidates (s, p), at most half of all, and points spread at random between the bounds."""
    given = scale.shares(candidates[: max(count // 2, 1)])
    random = np.random.default_rng(seed).uniform(size=(count - len(given), given.shape[1]))
    return np.vstack([given, random])


def evolve(
    kind: str,
    objectives: Callable[[np.ndarray], np.ndarray],
    start: np.ndarray,
    generations: int,
    seed: int,
    report: Callable[[int, np.ndarray], None],
) -> tuple[np.ndarray, np.ndarray]:
    """Final non-dominated shares (k, p) and their objectives (k, g).

    Args:
        kind: ``ga`` for one objective, ``nsga2`` for several.
        objectives: shares (n, p) to (n, g), finite.
        start: (n, p), whose length is the population's.
        report: called after each generation with its number and its objectives (n, g).

    Raises:
        InputError: where pymoo is missing; says how to install it.
    """
    try:
        from pymoo.algorithms.moo.nsga2 import NSGA2
        from pymoo.algorithms.soo.nonconvex.ga import GA
        from pymoo.core.problem import Problem
        from pymoo.util.nds.non_dominated_sorting import NonDominatedSorting
    except ImportError as error:
        raise InputError(_MISSING) from error
    count = objectives(start[:1]).shape[1]
    problem = Problem(n_var=start.shape[1], n_obj=count, xl=0.0, xu=1.0)
    algorithm = (NSGA2 if kind == "nsga2" else GA)(pop_size=len(start), sampling=start, eliminate_duplicates=True)
    algorithm.setup(problem, termination=("n_gen", generations), seed=seed, verbose=False)
    for generation in range(1, generations + 1):
        offspring = algorithm.ask()
        if offspring is None or len(offspring) == 0:
            break
        offspring.set("F", objectives(offspring.get("X")))
        algorithm.tell(infills=offspring)
        report(generation, algorithm.pop.get("F"))
    shares, found = algorithm.pop.get("X"), algorithm.pop.get("F")
    kept = NonDominatedSorting().do(found, only_non_dominated_front=True)
    return shares[kept], found[kept]
