"""A problem restricted to excitations, as a search with several objectives needs it."""

from collections.abc import Mapping, Sequence

import numpy as np

from damper_estimator.identification.excitations import excitation_split, groups_with_excitations
from damper_estimator.identification.problem import Problem


class ExcitationProblem:
    """The excitations of a problem's recordings by group; final.

    Attributes:
        problem: on the rows of the excitations alone.
        groups: names of the objectives.
        sizes: for each group the number of rows (e,) of each excitation.
    """

    def __init__(self, problem: Problem, given: Mapping[str, Sequence[str]]) -> None:
        """``given``: recordings (paths, or file names) by group; empty forms the groups from velocity and frequency.

        Raises:
            InputError: for a recording in no group, a group without recordings, or no whole cycle anywhere.
        """
        split = excitation_split(problem.source.cycles())
        source = problem.source.excitations({name: tuple(recordings) for name, recordings in given.items()}, split)
        self._sizes, groups = source.group_sizes(), tuple(given) or split.names
        self._kept = groups_with_excitations([sizes.size for sizes in self._sizes], groups, given)
        self.groups = tuple(groups[k] for k in self._kept)
        self.sizes = [self._sizes[k] for k in self._kept]
        self.problem = problem.on(source)

    def errors(self, vectors: np.ndarray) -> list[list[np.ndarray]]:
        """For each vector (slots,) of values, and each group, the mean squared error (e,) of each excitation."""
        return [[every[k] for k in self._kept] for every in self.problem.errors(vectors)]

    def weighted(self, weights: Sequence[np.ndarray]) -> Problem:
        """The problem with the rows of each excitation counted so much (e,), for each group."""
        every = [np.zeros(sizes.size) for sizes in self._sizes]
        for k, counted in zip(self._kept, weights, strict=True):
            every[k] = counted
        return self.problem.on(self.problem.source.weighted(every))
