"""What a worker holds in a joint fit: recordings made ready, and what it answers about each.

A worker that holds a recording no longer, or never did, reads it.
"""

from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import yaml
from distributed import get_worker

from damper_estimator.errors import InputError
from damper_estimator.identification.fit import judged_rows
from damper_estimator.identification.local import LocalRows, LocalSums
from damper_estimator.identification.record import force_stddev
from damper_estimator.identification.rows import moments
from damper_estimator.identification.sources import Totals
from damper_estimator.identification.unknowns import Settings, Unknowns
from damper_estimator.model import DamperModel, Slot, parse_model
from damper_estimator.signals import Measurement
from damper_estimator.workflows import read

_KEPT = 0.4  # of the worker's memory for recordings made ready
_COPIES = 4.0  # bytes that a recording takes beside those of its kinematics, over these
_VIEWS = 6  # that are remembered for each recording


@dataclass(frozen=True)
class Source:
    """A damper of a recording; ``start`` and ``stop`` in s as in ``measure``, ``checksum`` of the contents."""

    recording: str
    damper: str
    signals: str
    start: float
    stop: float
    checksum: str


@dataclass(frozen=True)
class Parameters:
    """The unknowns of a fit, as they travel.

    Attributes:
        model: with the start values, as the text of its file: compiled effects do not travel well.
        free, slots, settings: as in ``Unknowns``.
    """

    model: str
    free: tuple[int, ...]
    slots: tuple[Slot, ...]
    settings: Settings | None = None

    def unknowns(self) -> Unknowns:
        """The same here."""
        return Unknowns(model_of(self.model), self.free, self.settings, self.slots)


@dataclass(frozen=True)
class ByRecording:
    """A word of a call that every recording has a value of its own for."""

    values: Mapping[Source, object]


@dataclass(frozen=True)
class View:
    """Some of a recording's rows, or what they add up to: a call, and the view whose method is called.

    Attributes:
        key: tells one from another.
        before: None for all rows of the recording.
        name, words: of a method of ``LocalRows`` that gives the view.
    """

    key: str
    before: "View | None"
    name: str
    words: tuple[object, ...]


class Held:
    """One recording made ready; final.

    Attributes:
        measurement: as it was read.
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
        """Bytes, about."""
        return (1.0 + _COPIES) * self.measurement.kinematics.block.nbytes

    @property
    def used(self) -> list[Measurement]:
        """The parts that are identified on."""
        return [own.measurement for own in self.rows.rows]

    def view(self, view: View | None) -> LocalRows | LocalSums:
        """What a view shows of this recording; the last few are remembered."""
        if view is None:
            return self.rows
        if view.key in self._views:
            self._views.move_to_end(view.key)
        else:
            words = [self._here(word) for word in view.words]
            self._views[view.key] = getattr(self.view(view.before), view.name)(*words)
            while len(self._views) > _VIEWS:
                self._views.popitem(last=False)
        return self._views[view.key]

    def _here(self, word: object) -> object:
        """A word of a call as this recording takes it."""
        if isinstance(word, Parameters):
            return word.unknowns()
        return word.values[self._source] if isinstance(word, ByRecording) else word


_held: OrderedDict[tuple[Source, str], Held] = OrderedDict()


@lru_cache(maxsize=8)
def model_of(text: str) -> DamperModel:
    """The model of a file's text."""
    return parse_model(yaml.safe_load(text), "the model of the fit")


def answers(sources: Sequence[Source], model: str, ask: Callable, words: Sequence) -> list:
    """``ask(held, *words)`` for each source, in their order; an ``InputError`` where one cannot be used.

    Args:
        model: text of the model that was given to be fitted; it decides what of a recording can be used.
    """
    told = []
    for source in sources:
        try:
            told.append(ask(_ready(source, model), *words))
        except InputError as error:
            told.append(error)
    return told


def _ready(source: Source, model: str) -> Held:
    if (source, model) in _held:
        _held.move_to_end((source, model))
        return _held[source, model]
    own = Held(source, model_of(model))
    _held[source, model] = own
    room = _KEPT * (get_worker().memory_manager.memory_limit or np.inf)
    while len(_held) > 1 and sum(other.size for other in _held.values()) > room:
        _held.popitem(last=False)
    return own


@dataclass(frozen=True)
class Summary:
    """What a recording adds up to.

    Attributes:
        totals: of the usable parts.
        lost: judged samples that are in no usable part.
        filters: cutoff and band, Hz.
    """

    totals: Totals
    lost: int
    filters: tuple[float, float]


def summary(held: Held) -> Summary:
    """What is known of a recording before the search."""
    judged = sum(int(m.judged.sum()) for m in held.used)
    return Summary(
        totals=held.rows.totals,
        lost=int(held.measurement.judged.sum()) - judged,
        filters=(held.measurement.cutoff, held.measurement.band),
    )


def answer(held: Held, view: View | None, name: str, *words: object) -> object:
    """What a method of a view returns."""
    return getattr(held.view(view), name)(*words)


def totals(held: Held, view: View | None) -> Totals:
    """Of a view's rows."""
    rows = held.view(view)
    assert isinstance(rows, LocalRows)
    return rows.totals


def channel_range(held: Held, row: int) -> tuple[int, float, float]:
    """Number of finite judged samples of a row of the block, the smallest and the largest."""
    values = _channel(held, row)
    return values.size, *((float(values.min()), float(values.max())) if values.size else (np.inf, -np.inf))


def channel_below(held: Held, row: int, edges: np.ndarray) -> np.ndarray:
    """(k,) how many of them are smaller than each edge."""
    return np.searchsorted(np.sort(_channel(held, row)), edges)


def _channel(held: Held, row: int) -> np.ndarray:
    values = np.concatenate([m.kinematics.block[row, m.judged] for m in held.used])
    return values[np.isfinite(values)]


def error_bound(held: Held, text: str) -> np.ndarray:
    """(1,) N, ``identification.record.force_stddev`` over what is held."""
    return np.array([force_stddev(model_of(text), held.used)])


def error_sums(held: Held, text: str) -> np.ndarray:
    """(2, 3) moments of the error in band, N, and of the force, over the judged samples at full rate."""
    model, errors, forces = model_of(text), [], []
    for m in held.used:
        measured = m.in_band(m.force)[m.judged]
        errors.append(m.in_band(model.force(m.kinematics.block))[m.judged] - measured)
        forces.append(measured)
    return np.array([moments(np.concatenate(errors)), moments(np.concatenate(forces))])
