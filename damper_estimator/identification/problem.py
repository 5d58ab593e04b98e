"""The least-squares problem of a fit: parameters that are searched or solved for, and the error they leave.

For given searched parameters q the force in band is c(q) + Phi(q) p with the linear parameters p, which are
solved for between their bounds (variable projection). Every part of the model is run anew only when a
parameter changes on which it depends.
"""

from collections import OrderedDict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from damper_estimator.identification.excited import Excited
from damper_estimator.identification.rows import Rows, excerpts, motion_moments, natural_sizes
from damper_estimator.identification.terms import Term
from damper_estimator.identification.unknowns import Settings, Unknowns
from damper_estimator.model import DamperModel, Slot
from damper_estimator.numerics import bounded_least_squares, score_covariance, stepped, triangle

_KEPT = 4  # settings of the parameters for which a term's columns are remembered

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


@dataclass(frozen=True)
class Linearised:
    """The rows near a point: their derivative by searched and solved parameters, and what is left.

    A parameter that changes the force by less than a ten-millionth over its own size has a derivative of zero: the
    rest is rounding.

    Attributes:
        jacobian: (m, q + p), of which the first q columns are one-sided differences.
        residual: (m,).
        rows: that they belong to.
        silent: (q,) bool.
    """

    jacobian: np.ndarray
    residual: np.ndarray
    rows: tuple[Rows, ...]
    silent: np.ndarray

    @cached_property
    def reduced(self) -> np.ndarray:
        """(q + p + 1, q + p + 1) or fewer rows: all that the rows say, the residual last; see ``triangle``."""
        return loudly_reduced(by_recording(self.rows, np.column_stack([self.jacobian, self.residual])), self.silent)

    def noise(self, weights: np.ndarray) -> tuple[np.ndarray, float]:
        """See ``numerics.score_covariance``: (d, d) and effective samples, for directions ``weights`` (q + p, d)."""
        ends = np.cumsum([own.picks.size for own in self.rows])[:-1]
        scores = self.jacobian @ without(self.silent, weights)
        rates = [own.rate for own in self.rows]
        return score_covariance(np.split(self.residual, ends), np.split(scores, ends), rates)


class Problem(Unknowns):
    """A model's free parameters against the rows of some measurements; final.

    Attributes:
        rows: of every measurement.
        target: (m,) rows of the measured force.
        evaluations: how often the model was run so far, or a part of it, over all rows.
    """

    def __init__(
        self,
        model: DamperModel,
        rows: Sequence[Rows],
        free: Sequence[int],
        settings: Settings | None = None,
        slots: Sequence[Slot] | None = None,
    ):
        """In a joint fit the rows come in order of their ``setting``.

        Args:
            free: positions in ``model.slots``.
            slots: the model's, where some have narrower bounds than their declaration.
        """
        super().__init__(model, free, settings, slots)
        self.rows = tuple(rows)
        self.target = np.concatenate([own.target for own in self.rows])
        self.evaluations = 0
        self._parts = [_Part(term, k, self.places[k], part) for k, part in self._spans() for term in self._terms]
        self._cache: list[OrderedDict] = [OrderedDict() for _ in self._parts]

    @property
    def size(self) -> int:
        """Number of rows."""
        return self.target.size

    @property
    def power(self) -> float:
        """Sum of the squares of the target."""
        return float(self.target @ self.target)

    @property
    def recordings(self) -> tuple[str, ...]:
        """Where the rows come from."""
        return tuple(dict.fromkeys(own.measurement.recording for own in self.rows))

    def natural_sizes(self) -> tuple[float, float, float]:
        """See ``rows.natural_sizes``."""
        return natural_sizes([motion_moments(own.measurement) for own in self.rows])

    def excerpts(self, samples: int) -> "Problem":
        """The same problem on excerpts of its data, in equal shares of about so many samples; itself where it is
        small.
        """
        total = sum(len(own.measurement.kinematics) for own in self.rows)
        if total <= samples:
            return self
        rows = []
        for own in self.rows:
            share = samples * len(own.measurement.kinematics) // total
            rows += [own.part(part) for part in excerpts(own.measurement, share)]
        rows = [own for own in rows if own.picks.size]
        return self.on(rows) if rows else self

    def on(self, rows: Sequence[Rows]) -> "Problem":
        """The same problem on other rows."""
        return Problem(self.model, rows, self._given, self.settings, self._given_slots)

    def weighted(self, weight: np.ndarray) -> "Problem":
        """The same problem with each row's squared error counted ``weight`` (m,) times as much."""
        rows, first = [], 0
        for own in self.rows:
            share = np.zeros(own.weight.size)
            share[own.picks] = own.weight[own.picks] * weight[first : first + own.picks.size]
            first += own.picks.size
            rows.append(own.weighing(share))
        return self.on(rows)

    def excited(self, given: Mapping[str, Sequence[str]]) -> Excited:
        """The excitations of its recordings, for a search with several objectives."""
        return Excited(self, given)

    def _spans(self) -> list[tuple[int, slice]]:
        """The settings that have rows, with their part of the residual."""
        ends = np.cumsum([own.picks.size for own in self.rows])
        spans: dict[int, slice] = {}
        for own, end in zip(self.rows, ends.tolist(), strict=True):
            first = spans[own.setting].start if own.setting in spans else end - own.picks.size
            spans[own.setting] = slice(first, end)
        return list(spans.items())

    def point(self, searched: np.ndarray, solved: np.ndarray | None = None) -> Point:
        """The best that can be done with these searched parameters; with ``solved`` given, how it is with those."""
        self.evaluations += 1
        values = self.vector(searched, self._start[self.solved])
        constant, columns = np.zeros(self.target.size), np.zeros((self.target.size, self.solved.size))
        for i, part in enumerate(self._parts):
            own_constant, own_columns, places = self._columns(i, part, values)
            constant[part.span] += own_constant
            columns[part.span, places] += own_columns
        if not (np.isfinite(constant).all() and np.isfinite(columns).all()):
            return Point(searched, values[self.solved], constant, columns, float("inf"))
        if solved is None:
            low, high = self.lower[self.solved], self.upper[self.solved]
            reference = np.clip(values[self.solved], low, high)
            reduced = by_recording(self.rows, np.column_stack([columns, self.target - constant]))
            solved = bounded_least_squares(reduced[:, :-1], reduced[:, -1], low, high, reference)
        residual = constant + columns @ solved - self.target
        return Point(searched, solved, residual, columns, 0.5 * float(residual @ residual))

    def linearised(self, point: Point, size: np.ndarray) -> Linearised:
        """The rows near a point; ``size`` (q,) is the magnitude of each parameter, to which steps are in proportion."""
        derivative = self.differences(point, size)
        silent = is_silent(derivative, size, self.power)
        return Linearised(np.column_stack([derivative, point.columns]), point.residual, self.rows, silent)

    def differences(self, point: Point, size: np.ndarray) -> np.ndarray:
        """(m, q) one-sided differences of the rows by the searched parameters, the linear ones held."""
        values = self.vector(point.searched, point.solved)
        before = [self._force_at(i, part, point) for i, part in enumerate(self._parts)]
        derivative = np.zeros((self.target.size, self.searched.size))
        for j, slot in enumerate(self.searched):
            changed, step = stepped(values, slot, size[j], self.lower[slot], self.upper[slot])
            self.evaluations += 1
            for part, force in zip(self._parts, before, strict=True):
                if slot in part.searched:
                    derivative[part.span, j] += (self._run(part, changed[part.slots]) - force) / step
        return derivative

    def _force_at(self, i: int, part: "_Part", point: Point) -> np.ndarray:
        """Rows of one part at a point, from what is remembered."""
        constant, columns, places = self._columns(i, part, self.vector(point.searched, self._start[self.solved]))
        return constant + columns @ point.solved[places]

    def _columns(self, i: int, part: "_Part", values: np.ndarray) -> tuple[np.ndarray, np.ndarray, list[int]]:
        """A part's rows without its solved parameters (r,), per unit of each (r, k), and their places in ``solved``."""
        key = values[part.searched].tobytes()
        cache = self._cache[i]
        if key in cache:
            cache.move_to_end(key)
            return cache[key]
        own = values[part.slots]
        order = {slot: k for k, slot in enumerate(part.slots.tolist())}
        places = [k for k, slot in enumerate(self.solved.tolist()) if slot in part.linear]
        linear = [order[slot] for slot in part.linear]
        mine = [order[int(self.solved[k])] for k in places]
        own[mine] = 0.0
        size = part.span.stop - part.span.start
        # A term with nothing but solved parameters is zero without them.
        still = not linear or own[linear].any()
        constant = self._run(part, own) if still else np.zeros(size)
        columns = np.empty((size, len(mine)))
        own[linear] = 0.0
        for k, slot in enumerate(mine):
            own[slot] = 1.0
            columns[:, k] = self._run(part, own)
            own[slot] = 0.0
        cache[key] = constant, columns, places
        if len(cache) > _KEPT:
            cache.popitem(last=False)
        return cache[key]

    def _run(self, part: "_Part", values: np.ndarray) -> np.ndarray:
        """Rows of one part's force with the values of its slots."""
        model = part.term.model.with_vector(values)
        rows = [own for own in self.rows if own.setting == part.setting]
        return np.concatenate([own.of(model.force(own.measurement.kinematics.block)) for own in rows])


class _Part:
    """One term of the model over the rows of one setting.

    Attributes:
        span: of the residual.
        slots: positions in the problem's slots of the term's.
        searched: those on which it depends otherwise than linearly.
        linear: those in which it is linear.
    """

    def __init__(self, term: Term, setting: int, places: np.ndarray, span: slice):
        """``places``: where the setting's values stand, by position in ``model.slots``."""
        self.term, self.setting, self.span = term, setting, span
        self.slots = places[list(term.slots)]
        self.searched = places[list(term.searched)]
        self.linear = tuple(places[list(term.linear)].tolist())


def by_recording(rows: Sequence[Rows], matrix: np.ndarray) -> np.ndarray:
    """The triangles of each recording's part of a matrix (m, k), one below the other: so sums over recordings are the
    same wherever the parts are made.
    """
    ends = np.cumsum([own.picks.size for own in rows])
    return np.concatenate([triangle(part) for part in np.split(matrix, ends[:-1])])


def is_silent(derivative: np.ndarray, size: np.ndarray, power: float) -> np.ndarray:
    """(q,) bool: parameters whose derivative (m, q), over their own size, is nothing beside the target's ``power``."""
    return np.linalg.norm(derivative, axis=0) * size < _SILENT * np.sqrt(power)


def loudly_reduced(rows: np.ndarray, silent: np.ndarray) -> np.ndarray:
    """The triangle of rows (m, k) in which silent parameters, the first q of k columns, have no part."""
    return triangle(without(silent, rows.T).T)


def without(silent: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Weights (k, d) with zeros for the silent parameters, the first q of k."""
    return np.where(np.pad(silent, (0, len(weights) - silent.size))[:, None], 0.0, weights)
