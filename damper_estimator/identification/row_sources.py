"""Sources of a problem's rows, and the sums that a fit asks of them, whatever the number of rows.

A least-squares search needs only the triangle of a QR decomposition of its rows. So each recording is reduced, in its
place, to triangles (``numerics.triangle``): k + 1 numbers square for k parameters. The triangles of all recordings,
one below the other in their order, are a problem of a few rows per recording with the same solution. Nothing is
squared, so it is as exact as with all rows, and the same wherever the rows are.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from damper_estimator.identification.excitations import ExcitationSplit
from damper_estimator.identification.unknowns import Unknowns
from damper_estimator.signals.cycles import Cycle


@dataclass(frozen=True)
class Place:
    """Where the rows are linearised: searched (q,) and solved (p,) parameters, and the magnitude (q,) of the former."""

    searched: np.ndarray
    solved: np.ndarray
    size: np.ndarray


@dataclass(frozen=True)
class Totals:
    """Totals over recordings, for any model.

    Attributes:
        samples: at full rate.
        rows: how many.
        power: sum of the squares of the rows' targets.
        moments: ``rows.motion_moments`` of each recording.
    """

    samples: int
    rows: int
    power: float
    moments: tuple[np.ndarray, ...]


def added_up(parts: Sequence[Totals]) -> Totals:
    """The totals of all parts together."""
    return Totals(
        sum(part.samples for part in parts),
        sum(part.rows for part in parts),
        float(sum(part.power for part in parts)),
        tuple(moments for part in parts for moments in part.moments),
    )


class RowSums(Protocol):
    """Sums over the rows of a source with given unknowns, of which q are searched and p solved for."""

    def columns(self, searched: np.ndarray) -> np.ndarray:
        """Triangles (.., p + 1): the force of one unit of each solved parameter, and the target less the force without
        them; not finite where the model's force is not finite.
        """
        ...

    def linearised(self, place: Place) -> np.ndarray:
        """Triangles (.., q + p + 1): derivatives by all parameters, those by the searched ones as one-sided differences
        with the solved ones kept, and the residual, modelled less measured.
        """
        ...

    def noise(self, place: Place, weights: np.ndarray) -> tuple[np.ndarray, float]:
        """``numerics.score_covariance`` (d, d) and effective samples, for directions ``weights`` (q + p, d)."""
        ...

    def errors(self, vectors: np.ndarray) -> list[list[np.ndarray]]:
        """For each vector (slots,) of values, and each group of a source of excitations, the mean squared error (e,) of
        each excitation.
        """
        ...


class RowSource(Protocol):
    """The rows of some recordings, in this process or elsewhere."""

    @property
    def recordings(self) -> tuple[str, ...]:
        """Where the rows come from."""
        ...

    @property
    def totals(self) -> Totals:
        """Of all rows."""
        ...

    def sums(self, unknowns: Unknowns) -> RowSums:
        """The sums over the rows with these unknowns."""
        ...

    def excerpts(self, samples: int, total: int) -> "RowSource":
        """The rows of excerpts, of about so many samples of the ``total`` of all recordings."""
        ...

    def thinned(self) -> "RowSource":
        """The rows of the recordings at the rate that the band asks for; see ``rows.Rows.thinned``."""
        ...

    def cycles(self) -> list[tuple[Cycle, ...]]:
        """Whole judged cycles of each recording."""
        ...

    def excitations(self, given: Mapping[str, Sequence[str]], split: ExcitationSplit) -> "RowSource":
        """The rows of the excitations alone; see ``excitations.excitations_in``."""
        ...

    def group_sizes(self) -> list[np.ndarray]:
        """For each group of a source of excitations the number of rows (e,) of each."""
        ...

    def weighted(self, weights: Sequence[np.ndarray]) -> "RowSource":
        """A source of excitations with the rows of each counted so much (e,), for each group."""
        ...
