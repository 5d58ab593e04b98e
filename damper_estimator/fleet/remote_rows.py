"""The rows of recordings on workers: forwards the calls of ``identification.row_sources`` to them.

Each recording answers for itself, and the answers are combined in the order of the recordings, so the result does not
depend on which worker has which recording. Only parameters and triangular factors of the recordings' rows are sent
(Demmel et al. 2012, TSQR).
"""

from collections.abc import Mapping, Sequence
from functools import cached_property
from uuid import uuid4

import numpy as np

from damper_estimator.fleet.distributed_recordings import DistributedRecordings
from damper_estimator.fleet.worker_recordings import ByRecording, Parameters, View, evaluate, totals
from damper_estimator.identification.excitations import ExcitationSplit
from damper_estimator.identification.row_sources import Place, Totals, added_up
from damper_estimator.identification.unknowns import Unknowns
from damper_estimator.model.model_files import model_yaml
from damper_estimator.signals.cycles import Cycle


class RemoteRows:
    """Implements ``identification.row_sources.RowSource``; final."""

    def __init__(self, recordings: DistributedRecordings, view: View | None = None) -> None:
        """``view``: the rows to use; None for all."""
        self._recordings, self._view = recordings, view
        self.recordings = tuple(dict.fromkeys(source.recording for source in recordings.sources))

    @cached_property
    def totals(self) -> Totals:
        """As in the protocol."""
        if self._view is None:
            return added_up([summary.totals for summary in self._recordings.summaries])
        return added_up(self._recordings.ask(totals, self._view))

    def sums(self, unknowns: Unknowns) -> "RemoteSums":
        """As in the protocol."""
        text = model_yaml(unknowns.model)
        given = Parameters(text, unknowns.given_free, unknowns.given_slots, unknowns.settings)
        return RemoteSums(self._recordings, _view(self._view, "sums", given))

    def excerpts(self, samples: int, total: int) -> "RemoteRows":
        """As in the protocol."""
        return RemoteRows(self._recordings, _view(self._view, "excerpts", samples, total))

    def thinned(self) -> "RemoteRows":
        """As in the protocol."""
        return RemoteRows(self._recordings, _view(self._view, "thinned"))

    def cycles(self) -> list[tuple[Cycle, ...]]:
        """As in the protocol."""
        return [cycle for parts in self._recordings.ask(evaluate, self._view, "cycles") for cycle in parts]

    def excitations(self, given: Mapping[str, Sequence[str]], split: ExcitationSplit) -> "RemoteRows":
        """As in the protocol."""
        return RemoteRows(self._recordings, _view(self._view, "excitations", given, split))

    def group_sizes(self) -> list[np.ndarray]:
        """As in the protocol."""
        return [np.concatenate(group) for group in zip(*self._sizes, strict=True)]

    def weighted(self, weights: Sequence[np.ndarray]) -> "RemoteRows":
        """As in the protocol."""
        ends = [np.cumsum([sizes.size for sizes in group])[:-1] for group in zip(*self._sizes, strict=True)]
        parts = [np.split(weight, end) for weight, end in zip(weights, ends, strict=True)]
        each = dict(zip(self._recordings.sources, zip(*parts, strict=True), strict=True))
        return RemoteRows(self._recordings, _view(self._view, "weighted", ByRecording(each)))

    @cached_property
    def _sizes(self) -> list[list[np.ndarray]]:
        """``group_sizes`` of each recording."""
        return self._recordings.ask(evaluate, self._view, "group_sizes")


class RemoteSums:
    """Implements ``identification.row_sources.RowSums``; final."""

    def __init__(self, recordings: DistributedRecordings, view: View) -> None:
        self._recordings, self._view = recordings, view

    def columns(self, searched: np.ndarray) -> np.ndarray:
        """As in the protocol."""
        return np.concatenate(self._recordings.ask(evaluate, self._view, "columns", searched))

    def linearised(self, place: Place) -> np.ndarray:
        """As in the protocol."""
        return np.concatenate(self._recordings.ask(evaluate, self._view, "linearised", place))

    def noise(self, place: Place, weights: np.ndarray) -> tuple[np.ndarray, float]:
        """As in the protocol."""
        parts = self._recordings.ask(evaluate, self._view, "noise", place, weights)
        return np.sum([total for total, _ in parts], axis=0), float(sum(effective for _, effective in parts))

    def errors(self, vectors: np.ndarray) -> list[list[np.ndarray]]:
        """As in the protocol; one query for all vectors."""
        parts = self._recordings.ask(evaluate, self._view, "errors", vectors)
        return [[np.concatenate(group) for group in zip(*each, strict=True)] for each in zip(*parts, strict=True)]


def _view(before: View | None, name: str, *arguments: object) -> View:
    return View(uuid4().hex, before, name, arguments)
