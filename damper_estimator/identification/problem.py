"""The least-squares problem of a fit: parameters that are searched or solved for, and the remaining error.

For given searched parameters q the force in band is c(q) + Phi(q) p with the linear parameters p, which are
solved for between their bounds (variable projection). The rows stay with their source; the problem has only their
sums.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.identification.row_sources import Place, RowSource, RowSums
from damper_estimator.identification.rows import natural_sizes
from damper_estimator.identification.unknowns import Settings, Unknowns
from damper_estimator.model import DamperModel, Slot
from damper_estimator.numerics import bounded_least_squares, triangle

_SILENT = 1e-7  # of the measured force


@dataclass(frozen=True)
class Point:
    """The position of a search.

    Attributes:
        searched: (q,) values.
        solved: (p,) values of the linear parameters, best for ``searched``.
        cost: half the sum of the squared rows, modelled less measured, N times root weight; infinite where the model
            gave no finite force.
    """

    searched: np.ndarray
    solved: np.ndarray
    cost: float


@dataclass(frozen=True)
class Linearised:
    """The rows near a point: their derivative by searched and solved parameters, and the residual.

    A parameter that changes the force by less than a ten-millionth over its size has a derivative of zero: the
    rest is rounding.

    Attributes:
        reduced: (q + p + 1, q + p + 1) or fewer rows: all that the rows say, the residual last; see ``triangle``.
        silent: (q,) bool.
        place, sums: where, and of which rows.
    """

    reduced: np.ndarray
    silent: np.ndarray
    place: Place
    sums: RowSums

    def noise(self, weights: np.ndarray) -> tuple[np.ndarray, float]:
        """``numerics.score_covariance`` (d, d) and effective samples, for directions ``weights`` (q + p, d)."""
        return self.sums.noise(self.place, _without(self.silent, weights))


class Problem(Unknowns):
    """A model's free parameters against the rows of a source; final.

    Attributes:
        source: of the rows.
        size: number of rows.
        samples: on which the model is run for them.
        power: sum of the squares of the target.
        recordings: where the rows come from.
        evaluations: how often the model was run so far, or a part of it, over all rows.
    """

    def __init__(
        self,
        model: DamperModel,
        source: RowSource,
        free: Sequence[int],
        settings: Settings | None = None,
        slots: Sequence[Slot] | None = None,
    ):
        """``free``: positions in ``model.slots``; ``slots``: the model's, where some have narrower bounds than their
        declaration.
        """
        super().__init__(model, free, settings, slots)
        self.source, self.recordings = source, source.recordings
        self.size, self.power = source.totals.rows, source.totals.power
        self.samples = source.totals.samples
        self.evaluations = 0
        # Not of itself: a reference cycle would keep the cached columns alive.
        self._sums = source.sums(Unknowns(model, free, settings, slots))

    def on(self, source: RowSource) -> "Problem":
        """The same problem on other rows."""
        return Problem(self.model, source, self.given_free, self.settings, self.given_slots)

    def natural_sizes(self) -> tuple[float, float, float]:
        """See ``rows.natural_sizes``."""
        return natural_sizes(self.source.totals.moments)

    def excerpts(self, samples: int) -> "Problem":
        """The same problem on excerpts of its data, in equal shares of about so many samples; itself where it is
        small.
        """
        if self.samples <= samples:
            return self
        part = self.source.excerpts(samples, self.samples)
        return self.on(part) if part.totals.rows else self

    def thinned(self) -> "Problem":
        """The same problem at the rate that the band asks for; itself where the data have no more."""
        part = self.source.thinned()
        return self.on(part) if part.totals.rows and part.totals.samples < self.samples else self

    def point(self, searched: np.ndarray, solved: np.ndarray | None = None) -> Point:
        """The point of least cost with these searched parameters; with ``solved`` given, the point with those."""
        self.evaluations += 1
        rows = self._sums.columns(searched)
        start = self.start_vector[self.solved]
        if not np.isfinite(rows).all():
            return Point(searched, start, float("inf"))
        columns, target = rows[:, :-1], rows[:, -1]
        if solved is None:
            low, high = self.lower[self.solved], self.upper[self.solved]
            solved = bounded_least_squares(columns, target, low, high, np.clip(start, low, high))
        residual = columns @ solved - target
        return Point(searched, solved, 0.5 * float(residual @ residual))

    def linearised(self, point: Point, size: np.ndarray) -> Linearised:
        """The rows near a point; ``size`` (q,) is the magnitude of each parameter, to which steps are in proportion."""
        self.evaluations += self.searched.size
        place = Place(point.searched, point.solved, size)
        rows = self._sums.linearised(place)
        influence = np.linalg.norm(rows[:, : size.size], axis=0) * size
        silent = influence < _SILENT * np.sqrt(self.power)
        return Linearised(triangle(_without(silent, rows.T).T), silent, place, self._sums)

    def errors(self, vectors: np.ndarray) -> list[list[np.ndarray]]:
        """See ``RowSums.errors``."""
        return self._sums.errors(vectors)


def _without(silent: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Weights (k, d) with zeros for the silent parameters, the first q of k."""
    return np.where(np.pad(silent, (0, len(weights) - silent.size))[:, None], 0.0, weights)
