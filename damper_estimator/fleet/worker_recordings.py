"""Recordings that a worker keeps in memory during a joint fit, and the queries that it answers about each.

A worker without a recording in memory reads it.
"""

from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import yaml
from distributed import get_worker

from damper_estimator.errors import InputError
from damper_estimator.identification.error_bound import worst_errors
from damper_estimator.identification.fit import judged_rows
from damper_estimator.identification.local_rows import LocalRows, LocalSums
from damper_estimator.identification.row_sources import Totals
from damper_estimator.identification.rows import moments
from damper_estimator.identification.unknowns import Settings, Unknowns
from damper_estimator.model import DamperModel, Slot, parse_model
from damper_estimator.signals import Measurement
from damper_estimator.workflows import read

_MEMORY_SHARE = 0.4  # of the worker's memory for prepared recordings
_COPIES = 4.0  # memory of a recording besides its kinematics, over that of the kinematics
_VIEWS = 6  # cached for each recording


@dataclass(frozen=True)
class Source:
    """A damper of a recording; ``start`` and ``stop`` in s as in ``measure``; ``checksum`` of the contents."""

    recording: str
    damper: str
    signals: str
    start: float
    stop: float
    checksum: str


@dataclass(frozen=True)
class Parameters:
    """The unknowns of a fit in a form that can be sent to workers.

    Attributes:
        model: with the start values, as the text of its file: compiled effects are expensive to send.
        free, slots, settings: as in ``Unknowns``.
    """

    model: str
    free: tuple[int, ...]
    slots: tuple[Slot, ...]
    settings: Settings | None = None

    def unknowns(self) -> Unknowns:
        """The unknowns as an object of this process."""
        return Unknowns(model_of(self.model), self.free, self.settings, self.slots)


@dataclass(frozen=True)
class ByRecording:
    """An argument whose value differs between recordings."""

    values: Mapping[Source, object]


@dataclass(frozen=True)
class View:
    """Some of a recording's rows, or their sums: a method call on another view.

    Attributes:
        key: identifies the view.
        before: the view whose method is called; None for all rows of the recording.
        name, arguments: of the method of ``LocalRows`` that returns the view.
    """

    key: str
    before: "View | None"
    name: str
    arguments: tuple[object, ...]


class PreparedRecording:
    """One recording prepared for the fit; final.

    Attributes:
        measurement: the samples.
        rows: of its usable parts.
    """

    def __init__(self, source: Source, model: DamperModel) -> None:
        self._source = source
        recording = read(
            source.recording, signals=source.signals or None, dampers=source.damper,
            start=source.start, stop=source.stop,
        )  # fmt: skip
        (self.measurement,) = recording.with_force("fit").measurements[source.damper]
        self.rows = LocalRows(judged_rows(model, [self.measurement], [1.0]))
        self._views: OrderedDict[str, LocalRows | LocalSums] = OrderedDict()

    @property
    def size(self) -> float:
        """Approximate memory, bytes."""
        return (1.0 + _COPIES) * self.measurement.kinematics.block.nbytes

    @property
    def used(self) -> list[Measurement]:
        """The parts that are used for identification."""
        return [row.measurement for row in self.rows.rows]

    def view(self, view: View | None) -> LocalRows | LocalSums:
        """A view of this recording; the last few are cached."""
        if view is None:
            return self.rows
        if view.key in self._views:
            self._views.move_to_end(view.key)
        else:
            arguments = [self._local(argument) for argument in view.arguments]
            self._views[view.key] = getattr(self.view(view.before), view.name)(*arguments)
            while len(self._views) > _VIEWS:
                self._views.popitem(last=False)
        return self._views[view.key]

    def _local(self, argument: object) -> object:
        """An argument of a call as this recording needs it."""
        if isinstance(argument, Parameters):
            return argument.unknowns()
        return argument.values[self._source] if isinstance(argument, ByRecording) else argument


_prepared: OrderedDict[tuple[Source, str], PreparedRecording] = OrderedDict()


@lru_cache(maxsize=8)
def model_of(text: str) -> DamperModel:
    """The model whose file has this text."""
    return parse_model(yaml.safe_load(text), "the model of the fit")


def answers(sources: Sequence[Source], model: str, query: Callable, arguments: Sequence) -> list:
    """``query(recording, *arguments)`` for each source, in their order; an ``InputError`` for an unusable one.

    Args:
        model: text of the model to be fitted; it decides which parts of a recording are usable.
    """
    results = []
    for source in sources:
        try:
            results.append(query(_prepare(source, model), *arguments))
        except InputError as error:
            results.append(error)
    return results


def _prepare(source: Source, model: str) -> PreparedRecording:
    if (source, model) in _prepared:
        _prepared.move_to_end((source, model))
        return _prepared[source, model]
    prepared = PreparedRecording(source, model_of(model))
    _prepared[source, model] = prepared
    available = _MEMORY_SHARE * (get_worker().memory_manager.memory_limit or np.inf)
    while len(_prepared) > 1 and sum(other.size for other in _prepared.values()) > available:
        _prepared.popitem(last=False)
    return prepared


@dataclass(frozen=True)
class Summary:
    """Sums and settings of a recording.

    Attributes:
        totals: of the usable parts.
        lost: judged samples outside all usable parts.
        filters: cutoff and band, Hz.
    """

    totals: Totals
    lost: int
    filters: tuple[float, float]


def summary(recording: PreparedRecording) -> Summary:
    """Facts about a recording that the search needs at its start."""
    judged = sum(int(m.judged.sum()) for m in recording.used)
    return Summary(
        totals=recording.rows.totals,
        lost=int(recording.measurement.judged.sum()) - judged,
        filters=(recording.measurement.cutoff, recording.measurement.band),
    )


def evaluate(recording: PreparedRecording, view: View | None, name: str, *arguments: object) -> object:
    """The result of a view's method."""
    return getattr(recording.view(view), name)(*arguments)


def totals(recording: PreparedRecording, view: View | None) -> Totals:
    """Totals of a view's rows."""
    rows = recording.view(view)
    assert isinstance(rows, LocalRows)
    return rows.totals


def channel_range(recording: PreparedRecording, row: int) -> tuple[int, float, float]:
    """Number of finite judged samples of a row of the block, the smallest and the largest."""
    values = _channel(recording, row)
    return values.size, *((float(values.min()), float(values.max())) if values.size else (np.inf, -np.inf))


def channel_below(recording: PreparedRecording, row: int, edges: np.ndarray) -> np.ndarray:
    """(k,) number of these samples below each edge."""
    return np.searchsorted(np.sort(_channel(recording, row)), edges)


def _channel(recording: PreparedRecording, row: int) -> np.ndarray:
    values = np.concatenate([m.kinematics.block[row, m.judged] for m in recording.used])
    return values[np.isfinite(values)]


def largest_errors(recording: PreparedRecording, text: str) -> np.ndarray:
    """(b,) N, ``identification.error_bound.worst_errors`` of the usable parts of the recording."""
    return worst_errors(model_of(text), recording.used)


def error_sums(recording: PreparedRecording, text: str) -> np.ndarray:
    """(2, 3) moments of the error in band, N, and of the force, over the judged samples at full rate."""
    model, errors, forces = model_of(text), [], []
    for m in recording.used:
        measured = m.in_band(m.force)[m.judged]
        errors.append(m.in_band(model.force(m.kinematics.block))[m.judged] - measured)
        forces.append(measured)
    return np.array([moments(np.concatenate(errors)), moments(np.concatenate(forces))])
