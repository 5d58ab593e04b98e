"""What a page has opened: the recordings of one damper, read once, and the parts of them that are judged."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from damper_estimator.diagnosis import all_divided, corrected
from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel
from damper_estimator.signals import DamperSignals, Measurement, SignalMap, load_signal_map
from damper_estimator.studio.captured_warnings import captured_warnings
from damper_estimator.studio.folder import Folder
from damper_estimator.studio.worker_process import Progress
from damper_estimator.workflows import Case, open_reader, read

MOST_JUDGED = 200_000  # samples that regions, noise and effects are looked for in
_PASSAGES = 20  # that a longer recording is judged on


Stretch = tuple[int, float, float]
"""Index of a recording, start and stop in s since its first sample."""


@dataclass(frozen=True)
class Choice:
    """What a user wants to see; names are relative to the studio's folder.

    Attributes:
        fit, unseen: recordings to find parameters on, and to judge on (none: 40 % of each of ``fit``).
        damper: its name; "" for the first.
        signals: the signal map; "" for the default topics.
        start, stop: s from the start, None where all is used.
        left_out: stretches that nothing is fitted to or judged on.
    """

    fit: tuple[str, ...]
    unseen: tuple[str, ...] = ()
    damper: str = ""
    signals: str = ""
    start: float | None = None
    stop: float | None = None
    left_out: tuple[Stretch, ...] = ()


@dataclass(frozen=True)
class Passage:
    """A measurement and where it lies: the index of its recording, and s since that one's first sample."""

    measurement: Measurement
    recording: int
    begin: float


@dataclass(frozen=True)
class Stage:
    """What was read for a choice.

    Attributes:
        damper: its name.
        signal_map: with every damper of the recordings.
        whole: one measurement per recording, those of ``fit`` first.
        fit, unseen: what parameters are found on, and what is judged on.
        judged: samples of which regions are shown: all of ``whole``, or passages of it where it is long.
        warnings: what the reading said, such as that a recording is cut off.
        as_read: the same with nothing left out; None where nothing is.
    """

    choice: Choice
    damper: str
    signal_map: SignalMap
    whole: tuple[Measurement, ...]
    fit: tuple[Measurement, ...]
    unseen: tuple[Measurement, ...]
    judged: tuple[Passage, ...]
    warnings: tuple[str, ...] = ()
    as_read: "Stage | None" = None

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the recordings."""
        return (*self.choice.fit, *self.choice.unseen)

    @property
    def signals(self) -> DamperSignals:
        """The damper's entry of the signal map, as read."""
        return self.signal_map.dampers[self.damper]

    @cached_property
    def note(self) -> str:
        """What a user should know about what is judged; "" where that is all."""
        if len(self.judged) == len(self.whole):
            return ""
        seconds = float(np.sum([p.measurement.kinematics.dt.sum() for p in self.judged]))
        return (
            f"Long recordings: figures and error measures are of all samples; regions, noise floor, diagnosis and "
            f"identification use {len(self.judged)} passages spread evenly over them, {seconds:.0f} s in all."
        )

    def case(self, model: DamperModel) -> Case:
        """A model to be judged on what is open."""
        return Case(self.damper, model, self.fit, self.unseen)

    def without(self, left_out: Sequence[Stretch]) -> "Stage":
        """The stage as it was read, less stretches that are neither fitted to nor judged on.

        Raises:
            InputError: where too little would be left.
        """
        read = self.as_read or self
        choice = replace(read.choice, left_out=tuple(left_out))
        if not left_out:
            return replace(read, choice=choice)
        whole = tuple(_less(m, m, i, left_out) for i, m in enumerate(read.whole))
        index = {m.recording: i for i, m in enumerate(read.whole)}

        def parts(given: Sequence[Measurement]) -> tuple[Measurement, ...]:
            cut = [_less(m, read.whole[index[m.recording]], index[m.recording], left_out) for m in given]
            return tuple(m for m in cut if m.judged.any())

        fit, unseen = parts(read.fit), parts(read.unseen)
        passages = (replace(p, measurement=m[0]) for p in read.judged if (m := parts([p.measurement])))
        if not (fit and unseen and all(m.judged.any() for m in whole)):
            raise InputError("nothing would be left to fit to, or to judge on; leave out less")
        return replace(read, choice=choice, whole=whole, fit=fit, unseen=unseen, judged=tuple(passages), as_read=read)

    def emptied(self) -> "Stage":
        """What was opened without its samples, which take hundreds of megabytes of a long recording."""
        return replace(self, whole=(), fit=(), unseen=(), judged=(), as_read=None)

    def corrected(self, signals: DamperSignals) -> "Stage":
        """The stage as it would have been read with another entry of the signal map."""
        if signals == self.signals:
            return self
        return replace(
            self,
            signal_map=self.signal_map.with_entry(self.damper, signals),
            whole=tuple(corrected(m, signals) for m in self.whole),
            fit=tuple(corrected(m, signals) for m in self.fit),
            unseen=tuple(corrected(m, signals) for m in self.unseen),
            judged=tuple(replace(p, measurement=corrected(p.measurement, signals)) for p in self.judged),
        )


def dampers_in(folder: Folder, recordings: Sequence[str], signals: str) -> list[str]:
    """Names of the dampers that recordings hold.

    Raises:
        InputError: for a recording or a map that cannot be read.
    """
    if not recordings:
        return []
    with open_reader([folder.existing(name) for name in recordings], _signal_map(folder, signals)) as reader:
        return list(reader.dampers)


def opened(folder: Folder, choice: Choice, progress: Progress) -> Stage:
    """Reads the recordings of a choice.

    Raises:
        InputError: for what is missing, damaged or holds no force of the damper.
    """
    if not choice.fit:
        raise InputError("choose at least one recording")
    given = _signal_map(folder, choice.signals)
    damper = choice.damper or dampers_in(folder, choice.fit[:1], choice.signals)[0]
    recordings, warnings = [], []
    names = (*choice.fit, *choice.unseen)
    for number, name in enumerate(names):
        progress(f"reading {name}", number / len(names))
        with captured_warnings() as read_warnings:
            path = folder.existing(name)
            recording = read(path, signals=given, dampers=damper, start=choice.start, stop=choice.stop)
            recordings.append(recording.with_force("the studio"))
        warnings += read_warnings
    whole = [recording.measurements[damper][0] for recording in recordings]
    count = len(choice.fit)
    passages = [_passages(m, i, MOST_JUDGED // len(whole)) for i, m in enumerate(whole)]
    fit = [p.measurement for passage in passages[:count] for p in passage]
    unseen = [p.measurement for passage in passages[count:] for p in passage]
    if not unseen:
        fit, unseen = all_divided(fit)
    judged = tuple(p for passage in passages for p in passage)
    read_all = Stage(
        choice, damper, recordings[0].signal_map, tuple(whole), tuple(fit), tuple(unseen), judged, tuple(warnings)
    )
    return read_all.without(choice.left_out)


def _less(part: Measurement, whole: Measurement, index: int, left_out: Sequence[Stretch]) -> Measurement:
    """A part of a recording with the samples of some stretches not judged."""
    time = (part.kinematics.stamp - whole.kinematics.stamp[0]) * 1e-9
    judged = part.judged.copy()
    for recording, start, stop in left_out:
        if recording == index:
            judged[slice(*np.searchsorted(time, [start, stop]))] = False
    return replace(part, judged=judged)


def _signal_map(folder: Folder, name: str) -> SignalMap:
    return load_signal_map(folder.existing(name) if name else None)


def _passages(measurement: Measurement, recording: int, most: int) -> list[Passage]:
    """The whole measurement, or passages of equal length spread evenly over it with ``most`` samples in all."""
    size = len(measurement.kinematics)
    if size <= most:
        return [Passage(measurement, recording, 0.0)]
    length, time = most // _PASSAGES, measurement.kinematics.time
    starts = np.linspace(0, size - length, _PASSAGES).astype(int).tolist()
    return [
        Passage(part, recording, float(time[i] - time[0]))
        for i in starts
        if (part := measurement.part(i, i + length)).judged.any()
    ]
