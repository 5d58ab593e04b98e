"""What a worker holds in a joint fit: recordings made ready, and the sums that it answers with.

Every answer is made from one recording alone and put together in the order of the recordings, so it does not matter
who holds which. Who holds one no longer, or never did, reads it anew.
"""

from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import yaml
from distributed import get_worker

from damper_estimator.errors import InputError
from damper_estimator.identification.excitations import Split, cycles_of, excitations_in
from damper_estimator.identification.excited import residual, spread_weights
from damper_estimator.identification.fit import judged_rows
from damper_estimator.identification.problem import Linearised, Problem, by_recording
from damper_estimator.identification.rows import Rows, excerpts, moments, motion_moments
from damper_estimator.model import DamperModel, Slot, parse_model
from damper_estimator.recordings import open_bag
from damper_estimator.signals import Measurement, load_signal_map, measure
from damper_estimator.signals.cycles import Cycle

_KEPT = 0.4  # of the worker's memory for recordings made ready
_COPIES = 4.0  # bytes that a recording takes beside those of its kinematics, over these
_PROBLEMS = 2  # sets of unknowns that are remembered for each recording


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
class Chosen:
    """The excitations of the recordings, for a search with several objectives.

    Attributes:
        given, split: as in ``excitations_in``.
        weights: by source and group, of the rows of each excitation (e,); None counts all alike.
    """

    given: Mapping[str, Sequence[str]]
    split: Split
    weights: Mapping[Source, Sequence[np.ndarray]] | None = None


@dataclass(frozen=True)
class Unknown:
    """What is identified, and on how much.

    Attributes:
        key: tells one from another.
        model: with the start values, as the text of its file: compiled effects do not travel well.
        free, slots: as in ``Problem``.
        samples, total: excerpts of about so many samples of the total; 0 for all.
        chosen: excitations, in place of excerpts.
    """

    key: str
    model: str
    free: tuple[int, ...]
    slots: tuple[Slot, ...]
    samples: int = 0
    total: int = 0
    chosen: Chosen | None = None


@dataclass(frozen=True)
class Place:
    """Where the rows are linearised: searched (q,) and solved (p,) parameters, and the magnitude (q,) of the former."""

    searched: np.ndarray
    solved: np.ndarray
    size: np.ndarray


class Held:
    """One recording made ready; final.

    Attributes:
        measurement: as it was read.
        rows: of its usable parts.
    """

    def __init__(self, source: Source, model: DamperModel) -> None:
        self._source = source
        with open_bag(source.recording) as bag:
            signal_map = load_signal_map(source.signals or None)
            self.measurement = measure(bag, signal_map, source.damper, source.start, source.stop)
        self.rows = judged_rows(model, [self.measurement], [1.0])
        self._problems: OrderedDict[str, Problem | None] = OrderedDict()

    @property
    def size(self) -> float:
        """Bytes, about."""
        return (1.0 + _COPIES) * self.measurement.kinematics.block.nbytes

    @property
    def used(self) -> list[Measurement]:
        """The parts that are identified on."""
        return [own.measurement for own in self.rows]

    def problem(self, unknown: Unknown) -> Problem | None:
        """The problem on this recording's rows; None where excerpts leave it none."""
        if unknown.key not in self._problems:
            self._problems[unknown.key] = self._made(unknown)
            while len(self._problems) > _PROBLEMS:
                self._problems.popitem(last=False)
        return self._problems[unknown.key]

    def _made(self, unknown: Unknown) -> Problem | None:
        chosen = unknown.chosen
        found = None if chosen is None else excitations_in(self.rows, chosen.given, chosen.split)
        rows = found.rows if found else self._excerpts(unknown) if unknown.samples else self.rows
        if not rows:
            return None
        own = Problem(model_of(unknown.model), rows, unknown.free, slots=unknown.slots)
        if chosen is None or chosen.weights is None:
            return own
        return own.weighted(spread_weights(found.members, chosen.weights[self._source], own.size))

    def _excerpts(self, unknown: Unknown) -> list[Rows]:
        rows = []
        for own in self.rows:
            share = unknown.samples * len(own.measurement.kinematics) // unknown.total
            rows += [own.part(part) for part in excerpts(own.measurement, share)]
        return [own for own in rows if own.picks.size]


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
        samples: of the usable parts; ``judged`` of them count, ``lost`` judged ones are in no usable part.
        rows: how many; ``power`` is the sum of their squared targets.
        filters: cutoff and band, Hz.
        moments: ``rows.motion_moments`` of each part.
    """

    samples: int
    judged: int
    lost: int
    rows: int
    power: float
    filters: tuple[float, float]
    moments: list[np.ndarray]


def summary(held: Held) -> Summary:
    """What is known of a recording before the search."""
    judged = sum(int(m.judged.sum()) for m in held.used)
    return Summary(
        samples=sum(len(m.kinematics) for m in held.used),
        judged=judged,
        lost=int(held.measurement.judged.sum()) - judged,
        rows=sum(own.picks.size for own in held.rows),
        power=sum(float(own.target @ own.target) for own in held.rows),
        filters=(held.measurement.cutoff, held.measurement.band),
        moments=[motion_moments(m) for m in held.used],
    )


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


def point_sums(held: Held, unknown: Unknown, searched: np.ndarray, solved: np.ndarray) -> np.ndarray:
    """Triangles (.., p + 1) of the columns and the target less what is there without them."""
    problem = held.problem(unknown)
    if problem is None:
        return np.zeros((0, solved.size + 1))
    point = problem.point(searched, np.zeros_like(solved))
    return by_recording(problem.rows, np.column_stack([point.columns, -point.residual]))


def linear_sums(held: Held, unknown: Unknown, place: Place) -> np.ndarray:
    """Triangles (.., q + p + 1) of the rows' differences, columns and residual."""
    problem = held.problem(unknown)
    if problem is None:
        return np.zeros((0, place.searched.size + place.solved.size + 1))
    near = _near(problem, place)
    return by_recording(problem.rows, np.column_stack([near.jacobian, near.residual]))


def noise_sums(held: Held, unknown: Unknown, place: Place, weights: np.ndarray) -> tuple[np.ndarray, float]:
    """``Linearised.noise`` of this recording; ``weights`` (q + p, d) are zero for silent parameters."""
    near = _near(held.problem(unknown), place)
    # What is silent is judged over all recordings.
    return replace(near, silent=np.zeros_like(near.silent)).noise(weights)


def _near(problem: Problem, place: Place) -> Linearised:
    return problem.linearised(problem.point(place.searched, place.solved), place.size)


def error_sums(held: Held, text: str) -> np.ndarray:
    """(2, 3) moments of the error in band, N, and of the force, over the judged samples at full rate."""
    model, errors, forces = model_of(text), [], []
    for m in held.used:
        measured = m.in_band(m.force)[m.judged]
        errors.append(m.in_band(model.force(m.kinematics.block))[m.judged] - measured)
        forces.append(measured)
    return np.array([moments(np.concatenate(errors)), moments(np.concatenate(forces))])


def cycles(held: Held) -> list[tuple[Cycle, ...]]:
    """Whole judged cycles of each part."""
    return cycles_of(held.rows)


def excited_sizes(held: Held, chosen: Chosen) -> tuple[list[np.ndarray], int]:
    """For each group the number of rows (e,) of each excitation, and of all."""
    found = excitations_in(held.rows, chosen.given, chosen.split)
    sizes = [np.array([own.size for own in group], int) for group in found.members]
    return sizes, sum(own.picks.size for own in found.rows)


def excited_errors(held: Held, unknown: Unknown, vectors: np.ndarray) -> list[list[np.ndarray]]:
    """For each vector (slots,) of values, and each group, the mean squared error (e,) of each excitation."""
    problem, chosen = held.problem(unknown), unknown.chosen
    found = excitations_in(held.rows, chosen.given, chosen.split)
    if problem is None:
        return [[np.zeros(0) for _ in found.groups] for _ in vectors]
    return [found.errors(residual(problem, vector)) for vector in vectors]
