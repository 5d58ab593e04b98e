"""The least-squares problem of a fit: parameters that are searched or solved for, and the error they leave.

For given searched parameters q the force in band is c(q) + Phi(q) p with the linear parameters p, which are solved
for between their bounds (variable projection). Every part of the model is run anew only when a parameter changes on
which it depends.
"""

from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.identification.bounded import bounded_least_squares
from damper_estimator.identification.rows import Rows
from damper_estimator.identification.terms import Term, terms
from damper_estimator.model import DamperModel

_KEPT = 4  # settings of the parameters for which a term's columns are remembered
_STEP = 1e-5  # of a parameter's size: well above the tolerance to which compliances are solved

_SILENT = 1e-7  # of the measured force


@dataclass(frozen=True)
class Point:
    """Where a search is.

    Attributes:
        searched: (q,) values.
        solved: (p,) values of the linear parameters, best for ``searched``.
        residual: (m,) rows, modelled less measured, N times root weight.
        columns: (m, p) what one unit of each linear parameter adds.
        cost: half the sum of squares; infinite where the model gave no finite force.
    """

    searched: np.ndarray
    solved: np.ndarray
    residual: np.ndarray
    columns: np.ndarray
    cost: float


class Problem:
    """A model's free parameters against the rows of some measurements.

    Attributes:
        model: with the start values.
        rows: of every measurement.
        searched, solved: positions in ``model.slots`` of the free parameters that are searched, and solved for.
        lower, upper: (slots,) bounds of all slots.
        target: (m,) rows of the measured force.
        evaluations: how often the model was run so far, or a part of it, over all rows.
    """

    def __init__(self, model: DamperModel, rows: Sequence[Rows], free: Sequence[int]):
        """``free``: positions in ``model.slots``."""
        self.model = model
        self.rows = tuple(rows)
        self.free = tuple(free)
        self.target = np.concatenate([own.target for own in self.rows])
        self.lower = np.array([slot.parameter.lower for slot in model.slots])
        self.upper = np.array([slot.parameter.upper for slot in model.slots])
        self.evaluations = 0
        self._terms = terms(model)
        linear = {slot for term in self._terms for slot in term.linear}
        self.searched = np.array([slot for slot in self.free if slot not in linear], int)
        self.solved = np.array([slot for slot in self.free if slot in linear], int)
        self._start = np.array([slot.value for slot in model.slots])
        self._cache: list[OrderedDict] = [OrderedDict() for _ in self._terms]

    @property
    def start(self) -> np.ndarray:
        """(q,) the model's own values of the searched parameters, between their bounds."""
        return self.clipped(self._start[self.searched])

    def clipped(self, searched: np.ndarray) -> np.ndarray:
        """(q,) between the bounds."""
        return np.clip(searched, self.lower[self.searched], self.upper[self.searched])

    def vector(self, searched: np.ndarray, solved: np.ndarray) -> np.ndarray:
        """(slots,) values of all slots."""
        values = self._start.copy()
        values[self.searched], values[self.solved] = searched, solved
        return values

    def point(self, searched: np.ndarray) -> Point:
        """The best that can be done with these values of the searched parameters."""
        self.evaluations += 1
        values = self.vector(searched, self._start[self.solved])
        constant, columns = np.zeros(self.target.size), np.zeros((self.target.size, self.solved.size))
        for i, term in enumerate(self._terms):
            own_constant, own_columns, places = self._columns(i, term, values)
            constant += own_constant
            columns[:, places] = own_columns
        if not (np.isfinite(constant).all() and np.isfinite(columns).all()):
            return Point(searched, values[self.solved], constant, columns, float("inf"))
        low, high = self.lower[self.solved], self.upper[self.solved]
        reference = np.clip(values[self.solved], low, high)
        solved = bounded_least_squares(columns, self.target - constant, low, high, reference)
        residual = constant + columns @ solved - self.target
        return Point(searched, solved, residual, columns, 0.5 * float(residual @ residual))

    def jacobian(self, point: Point, size: np.ndarray) -> np.ndarray:
        """(m, q) derivative of the rows by the searched parameters, the linear ones held; one-sided differences.

        A parameter that changes the force by less than a ten-millionth over its own size has a derivative of zero:
        the rest is rounding.

        Args:
            size: (q,) magnitude of each parameter, to which the step is in proportion.
        """
        values = self.vector(point.searched, point.solved)
        before = [self._force_at(i, term, point) for i, term in enumerate(self._terms)]
        derivative = np.zeros((self.target.size, self.searched.size))
        for j, slot in enumerate(self.searched):
            step = _STEP * size[j]
            if values[slot] + step > self.upper[slot]:
                step = -step
            changed = values.copy()
            changed[slot] += step
            step = changed[slot] - values[slot]
            self.evaluations += 1
            for term, force in zip(self._terms, before, strict=True):
                if slot in term.searched:
                    derivative[:, j] += (self._run(term, changed) - force) / step
        silent = np.linalg.norm(derivative, axis=0) * size < _SILENT * np.linalg.norm(self.target)
        derivative[:, silent] = 0.0
        return derivative

    def _force_at(self, i: int, term: Term, point: Point) -> np.ndarray:
        """(m,) rows of one term at a point, from what is remembered."""
        constant, columns, places = self._columns(i, term, self.vector(point.searched, self._start[self.solved]))
        return constant + columns @ point.solved[places]

    def _columns(self, i: int, term: Term, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, list[int]]:
        """A term's rows without its solved parameters (m,), per unit of each (m, k), and their places in ``solved``."""
        key = values[list(term.searched)].tobytes()
        cache = self._cache[i]
        if key in cache:
            cache.move_to_end(key)
            return cache[key]
        places = [k for k, slot in enumerate(self.solved) if slot in term.linear]
        own = self.solved[places]
        values = values.copy()
        values[own] = 0.0
        # A term with nothing but solved parameters is zero without them.
        still = not term.linear or values[list(term.linear)].any()
        constant = self._run(term, values) if still else np.zeros(self.target.size)
        columns = np.empty((self.target.size, own.size))
        values[list(term.linear)] = 0.0
        for k, slot in enumerate(own):
            values[slot] = 1.0
            columns[:, k] = self._run(term, values)
            values[slot] = 0.0
        cache[key] = constant, columns, places
        if len(cache) > _KEPT:
            cache.popitem(last=False)
        return cache[key]

    def _run(self, term: Term, values: np.ndarray) -> np.ndarray:
        """(m,) rows of one term's force."""
        model = term.model.with_vector(values[list(term.slots)])
        return np.concatenate([own.of(model.force(own.measurement.kinematics.block)) for own in self.rows])
