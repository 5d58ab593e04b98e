"""What was measured on one or several dampers, whether it came from a bag, a bench file or arrays."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.recordings import Part, write_part
from damper_estimator.signals import Measurement, SignalMap, check_force
from damper_estimator.workflows.arrays import Arrays, part_from_arrays, part_from_dataframe
from damper_estimator.workflows.tables import html_table, sample_table

if TYPE_CHECKING:
    import pandas

Source = Path | Part
"""A recording on the disk, or a test that lies in memory."""

_FIRST = 1_000_000_000  # ns since 1970, where a recording may begin


@dataclass(frozen=True, repr=False, eq=False)
class Recording:
    """One or several recordings of the same dampers; ``damper_estimator.read`` and ``from_arrays`` make it.

    Several recordings are pooled by all that works on them. Units are SI; displacement is positive in extension, force
    positive where it resists extension.

    Attributes:
        sources: where each recording comes from.
        signal_map: how raw values became SI units, with an entry for every damper of the recordings.
        measurements: by damper, one for each recording that has it.
        chosen: dampers that were asked for by name; empty where all were read.
        window: (from, to) in s since the start, what was read.
        notes: what the reading left out, one sentence each.
    """

    sources: tuple[Source, ...]
    signal_map: SignalMap
    measurements: Mapping[str, tuple[Measurement, ...]]
    chosen: tuple[str, ...] = ()
    window: tuple[float, float] = (0.0, float("inf"))
    notes: tuple[str, ...] = ()

    @classmethod
    def from_arrays(
        cls,
        time: np.ndarray | Sequence[float],
        displacement: Arrays,
        *,
        force: Arrays | None = None,
        command: Arrays | None = None,
        temperature: Arrays | None = None,
        pressure: Arrays | None = None,
        acceleration: Arrays | None = None,
        damper: str = "damper",
        name: str = "arrays",
        signals: str | Path | SignalMap | None = None,
    ) -> Recording:
        """A recording from samples in memory; they pass the same checks and filters as those of a bag.

        Args:
            time: (n,) s, rising; it may have gaps.
            displacement: (n,) m, positive in extension. Several dampers: a mapping of arrays by damper.
            force: (n,) N, positive where it resists extension; a mapping where ``displacement`` is one.
            command, temperature, pressure, acceleration: (n,) A, deg C, Pa, m/s^2, or a number that holds throughout;
                the same. A slow channel may hold NaN where it was not sampled.
            damper: name of the damper, where it is one.
            name: of the recording, for tables and errors.
            signals: signal map (path or object) with the filter, spring rate, offsets; topics and fields are ignored.

        Raises:
            InputError: one line; arrays of other shapes, time that does not rise, values that are not finite, and
                values that cannot be in the unit (a displacement in mm).
        """
        channels = {
            "displacement": displacement, "force": force, "command": command, "temperature": temperature,
            "pressure": pressure, "acceleration": acceleration,
        }  # fmt: skip
        part = part_from_arrays(time, {role: own for role, own in channels.items() if own is not None}, damper, name)
        return _of_part(part, signals)

    @classmethod
    def from_dataframe(
        cls,
        frame: pandas.DataFrame,
        *,
        time: str | None = None,
        columns: Mapping[str, str] | None = None,
        damper: str = "damper",
        name: str = "dataframe",
        signals: str | Path | SignalMap | None = None,
    ) -> Recording:
        """A recording from the columns of a pandas data frame.

        Args:
            frame: columns named ``displacement``, ``force``, ``command``, ``temperature``, ``pressure``,
                ``acceleration`` are taken; others are ignored.
            time: column with the time in s; None takes the column ``time``, or the index where there is none.
            columns: for each role the column that holds it, where it is named otherwise.
            damper, name, signals: as in ``from_arrays``.

        Raises:
            InputError: as ``from_arrays``, and for columns that are not there.
        """
        return _of_part(part_from_dataframe(frame, time, columns or {}, damper, name), signals)

    @property
    def dampers(self) -> tuple[str, ...]:
        """Names of the dampers."""
        return tuple(self.measurements)

    @property
    def names(self) -> tuple[str, ...]:
        """Paths, or names, of the recordings."""
        return tuple(source_name(source) for source in self.sources)

    def of(self, damper: str) -> Recording:
        """The recording of one of its dampers.

        Raises:
            InputError: where it has no such damper.
        """
        if damper not in self.measurements:
            raise InputError(f"{self.names[0]}: has no damper {damper!r}; it has {', '.join(self.dampers)}")
        return replace(self, measurements={damper: self.measurements[damper]})

    def each(self) -> Iterator[tuple[str, Recording]]:
        """Each damper and the recording of it alone."""
        return ((damper, self.of(damper)) for damper in self.dampers)

    def where_force(self) -> Recording:
        """The recording without what has no measured force; ``notes`` tell what is left out.

        Raises:
            InputError: where a damper that was chosen by name has none.
        """
        kept: dict[str, tuple[Measurement, ...]] = {}
        notes = list(self.notes)
        for damper, measurements in self.measurements.items():
            for own in measurements if damper in self.chosen else ():
                check_force(own)
            notes += [
                f"{own.recording}: the force of {damper} was not measured; left out"
                for own in measurements
                if own.force is None
            ]
            with_force = tuple(own for own in measurements if own.force is not None)
            if with_force:
                kept[damper] = with_force
        return replace(self, measurements=kept, notes=tuple(notes))

    def with_force(self, use: str) -> Recording:
        """The same for a ``use`` that needs a force, such as ``fit``.

        Raises:
            InputError: also where no damper has one.
        """
        found = self.where_force()
        if not found.measurements:
            raise no_force(self.names[0], use)
        return found

    def save(self, path: str | Path) -> Path:
        """Writes what lies in memory as a recording (``.mcap``) with the default topics.

        Times that begin before the first second of 1970 are moved there: a recording cannot hold them.

        Raises:
            InputError: for several recordings, or one that is a file already.
        """
        (source,) = self.sources if len(self.sources) == 1 else (None,)
        if not isinstance(source, Part):
            raise InputError(
                f"{path}: only a recording from arrays or a bench file can be saved; copy the file instead"
            )
        write_part(storable(source), Path(path))
        return Path(path)

    def to_dataframe(self, damper: str | None = None) -> pandas.DataFrame:
        """The filtered samples of one damper as a table: time, displacement, velocity, acceleration, force, ...

        Raises:
            InputError: where pandas is missing, or the recording has several dampers and none is named.
        """
        if damper is None and len(self.dampers) != 1:
            raise InputError(f"{self.names[0]}: has dampers {', '.join(self.dampers)}; name one")
        (measurements,) = self.of(damper or self.dampers[0]).measurements.values()
        return sample_table(measurements)

    def to_dict(self) -> dict[str, object]:
        """What is in it: bags, and for each damper samples, seconds, and whether a force was measured."""
        return {"bags": list(self.names), "dampers": {damper: _facts(own) for damper, own in self.measurements.items()}}

    def __repr__(self) -> str:
        told = "; ".join(f"{damper}: {_in_words(own)}" for damper, own in self.measurements.items())
        return f"Recording({', '.join(self.names)}; {told or 'no damper'})"

    def _repr_html_(self) -> str:
        rows = [[damper, _in_words(own)] for damper, own in self.measurements.items()]
        return html_table(", ".join(self.names), ("damper", "samples"), rows)


def storable(part: Part) -> Part:
    """The part with times that a recording can hold: slow channels are logged a little before the first sample."""
    early = _FIRST - int(part.stamps[0])
    return part if early <= 0 else replace(part, stamps=part.stamps + early)


def checked(given: object) -> Recording:
    """What was given in place of a recording, if it is one.

    Raises:
        InputError: for a path, or anything else.
    """
    if not isinstance(given, Recording):
        raise InputError(f"{given!r:.80}: is not a recording; read it first: read(path), or Recording.from_arrays(...)")
    return given


def source_name(source: Source) -> str:
    """Path of a recording, or the name of what lies in memory."""
    if isinstance(source, Path):
        return str(source)
    return str(source.source) if source.parts == 1 else f"{source.source} (part {source.number})"


def in_words(recordings: Sequence[str]) -> str:
    """Recordings for a title."""
    return recordings[0].rpartition("/")[2] if len(recordings) == 1 else f"{len(recordings)} recordings"


def no_force(recording: str, use: str) -> InputError:
    """The error where no damper has a measured force."""
    return InputError(f"{recording}: no damper has a measured force; {use} needs one (name its topic in a signal map)")


def _of_part(part: Part, signals: str | Path | SignalMap | None) -> Recording:
    from damper_estimator.workflows.reading import read_parts_in_memory

    return read_parts_in_memory([part], signals)


def _facts(measurements: Sequence[Measurement]) -> dict[str, object]:
    return {
        "samples": sum(len(own.kinematics) for own in measurements),
        "seconds": float(sum(own.kinematics.dt.sum() for own in measurements)),
        "force": any(own.force is not None for own in measurements),
    }


def _in_words(measurements: Sequence[Measurement]) -> str:
    facts = _facts(measurements)
    force = "" if facts["force"] else ", no force"
    return f"{facts['samples']} samples in {facts['seconds']:.4g} s{force}"
