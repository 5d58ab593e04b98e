"""A problem on its excitations: what a search with several objectives asks of the recordings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from damper_estimator.identification.excitations import find_excitations

if TYPE_CHECKING:
    from damper_estimator.identification.problem import Problem


class Excited:
    """The excitations of a problem's recordings by group; final.

    Attributes:
        problem: on the rows of the excitations alone.
        groups: names of the objectives.
        sizes: for each group the number of rows (e,) of each excitation.
    """

    def __init__(self, problem: Problem, given: Mapping[str, Sequence[str]]) -> None:
        """``given`` as in ``find_excitations``."""
        self._chosen = find_excitations(problem.rows, given)
        self.problem = problem.on(self._chosen.rows)
        self.groups = self._chosen.groups
        self.sizes = [np.array([own.size for own in group]) for group in self._chosen.members]

    def errors(self, vectors: np.ndarray) -> list[list[np.ndarray]]:
        """For each vector (slots,) of values, and each group, the mean squared error (e,) of each excitation."""
        return [self._chosen.errors(residual(self.problem, vector)) for vector in vectors]

    def weighted(self, weights: Sequence[np.ndarray]) -> Problem:
        """The problem with the rows of each excitation counted so much (e,), for each group."""
        return self.problem.weighted(spread_weights(self._chosen.members, weights, self.problem.size))


def residual(problem: Problem, vector: np.ndarray) -> np.ndarray:
    """(m,) rows, modelled less measured, with the values (slots,)."""
    models = {own.setting: problem.model_at(vector, own.setting) for own in problem.rows}
    rows = [own.of(models[own.setting].force(own.measurement.kinematics.block)) for own in problem.rows]
    return np.concatenate(rows) - problem.target


def spread_weights(members: Sequence[Sequence[np.ndarray]], weights: Sequence[np.ndarray], size: int) -> np.ndarray:
    """(m,) weight of each of ``size`` rows from those of the excitations."""
    every = np.zeros(size)
    for group, own in zip(members, weights, strict=True):
        for positions, weight in zip(group, own, strict=True):
            every[positions] += weight
    return every
