"""The rows of recordings that lie on workers: the calls of ``identification.sources`` are sent there.

Every recording answers for itself, and what comes back is put together in the order of the recordings, so it does not
matter who holds which. What travels are parameters, and triangles of the recordings' rows (Demmel et al. 2012, TSQR).
"""

from collections.abc import Mapping, Sequence
from functools import cached_property
from uuid import uuid4

import numpy as np

from damper_estimator.fleet.held import ByRecording, Parameters, View, answer, totals
from damper_estimator.fleet.shares import Shares
from damper_estimator.identification.excitations import Split
from damper_estimator.identification.sources import Place, Totals, added_up
from damper_estimator.identification.unknowns import Unknowns
from damper_estimator.model.model_files import model_yaml
from damper_estimator.signals.cycles import Cycle


class RemoteRows:
    """As ``identification.sources.RowSource``; final."""

    def __init__(self, shares: Shares, view: View | None = None) -> None:
        """``view``: which of the rows; all where left out."""
        self._shares, self._view = shares, view
        self.recordings = tuple(dict.fromkeys(own.recording for own in shares.sources))

    @cached_property
    def totals(self) -> Totals:
        """As in the protocol."""
        if self._view is None:
            return added_up([own.totals for own in self._shares.summaries])
        return added_up(self._shares.ask(totals, self._view))

    def sums(self, unknowns: Unknowns) -> "RemoteSums":
        """As in the protocol."""
        text = model_yaml(unknowns.model)
        given = Parameters(text, unknowns.given_free, unknowns.given_slots, unknowns.settings)
        return RemoteSums(self._shares, _view(self._view, "sums", given))

    def excerpts(self, samples: int, total: int) -> "RemoteRows":
        """As in the protocol."""
        return RemoteRows(self._shares, _view(self._view, "excerpts", samples, total))

    def thinned(self) -> "RemoteRows":
        """As in the protocol."""
        return RemoteRows(self._shares, _view(self._view, "thinned"))

    def cycles(self) -> list[tuple[Cycle, ...]]:
        """As in the protocol."""
        return [part for own in self._shares.ask(answer, self._view, "cycles") for part in own]

    def excitations(self, given: Mapping[str, Sequence[str]], split: Split) -> "RemoteRows":
        """As in the protocol."""
        return RemoteRows(self._shares, _view(self._view, "excitations", given, split))

    def group_sizes(self) -> list[np.ndarray]:
        """As in the protocol."""
        return [np.concatenate(group) for group in zip(*self._sizes, strict=True)]

    def weighted(self, weights: Sequence[np.ndarray]) -> "RemoteRows":
        """As in the protocol."""
        ends = [np.cumsum([own.size for own in group])[:-1] for group in zip(*self._sizes, strict=True)]
        parts = [np.split(own, end) for own, end in zip(weights, ends, strict=True)]
        each = dict(zip(self._shares.sources, zip(*parts, strict=True), strict=True))
        return RemoteRows(self._shares, _view(self._view, "weighted", ByRecording(each)))

    @cached_property
    def _sizes(self) -> list[list[np.ndarray]]:
        """``group_sizes`` of each recording."""
        return self._shares.ask(answer, self._view, "group_sizes")


class RemoteSums:
    """As ``identification.sources.RowSums``; final."""

    def __init__(self, shares: Shares, view: View) -> None:
        self._shares, self._view = shares, view

    def columns(self, searched: np.ndarray) -> np.ndarray:
        """As in the protocol."""
        return np.concatenate(self._shares.ask(answer, self._view, "columns", searched))

    def linearised(self, place: Place) -> np.ndarray:
        """As in the protocol."""
        return np.concatenate(self._shares.ask(answer, self._view, "linearised", place))

    def noise(self, place: Place, weights: np.ndarray) -> tuple[np.ndarray, float]:
        """As in the protocol."""
        parts = self._shares.ask(answer, self._view, "noise", place, weights)
        return np.sum([total for total, _ in parts], axis=0), float(sum(effective for _, effective in parts))

    def errors(self, vectors: np.ndarray) -> list[list[np.ndarray]]:
        """As in the protocol; all vectors are asked for together."""
        parts = self._shares.ask(answer, self._view, "errors", vectors)
        return [[np.concatenate(group) for group in zip(*each, strict=True)] for each in zip(*parts, strict=True)]


def _view(before: View | None, name: str, *words: object) -> View:
    return View(uuid4().hex, before, name, words)
