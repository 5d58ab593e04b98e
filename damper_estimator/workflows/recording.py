"""Measurements of one or several dampers from a bag, a bench file or arrays."""

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
"""A recording on the disk, or a test in memory."""

_FIRST = 1_000_000_000  # ns since 1970, earliest time at which a recording can begin


@dataclass(frozen=True, repr=False, eq=False)
class Recording:
    """One or several recordings of the same dampers; from ``damper_estimator.read`` or ``from_arrays``.

    Several recordings are pooled in every analysis. Units are SI; displacement is positive in extension, force
    positive where it resists extension.

    Attributes:
        sources: origin of each recording.
        signal_map: conversion of raw values to SI units, with an entry for every damper of the recordings.
        measurements: by damper, one for each recording of it.
        chosen: dampers requested by name; empty for all.
        window: (from, to) in s since the start.
        notes: omissions while reading, one sentence each.
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
            command, temperature, pressure, acceleration: (n,) A, deg C, Pa, m/s^2, or a constant; or a mapping
                of these. A slow channel may have NaN between its samples.
            damper: name of a single damper.
            name: of the recording, for tables and errors.
            signals: signal map (path or object) with the filter, spring rate, offsets; topics and fields are ignored.

        Raises:
            InputError: for wrong shapes, time that does not rise, values that are not finite, and values that are
                impossible in the unit (a displacement in mm).
        """
        channels = {
            "displacement": displacement, "force": force, "command": command, "temperature": temperature,
            "pressure": pressure, "acceleration": acceleration,
        }  # fmt: skip
        part = part_from_arrays(
            time, {role: values for role, values in channels.items() if values is not None}, damper, name
        )
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
                ``acceleration`` are used; others are ignored.
            time: column with the time in s; None for the column ``time``, or the index if there is none.
            columns: name of the column by role, if different from the role.
            damper, name, signals: as in ``from_arrays``.

        Raises:
            InputError: as ``from_arrays``, and for missing columns.
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
            InputError: if it has no such damper.
        """
        if damper not in self.measurements:
            raise InputError(f"{self.names[0]}: has no damper {damper!r}; it has {', '.join(self.dampers)}")
        return replace(self, measurements={damper: self.measurements[damper]})

    def each(self) -> Iterator[tuple[str, Recording]]:
        """Each damper with its own recording."""
        return ((damper, self.of(damper)) for damper in self.dampers)

    def where_force(self) -> Recording:
        """The parts of the recording with a measured force; ``notes`` list the others.

        Raises:
            InputError: if a damper chosen by name has none, or if that of a damper was never measured at the same time
                as its displacement.
        """
        kept: dict[str, tuple[Measurement, ...]] = {}
        notes = list(self.notes)
        for damper, measurements in self.measurements.items():
            for measurement in measurements if damper in self.chosen else ():
                check_force(measurement)
            notes += [
                f"{measurement.recording}: the force of {damper} was not measured; left out"
                for measurement in measurements
                if measurement.force is None
            ]
            with_force = tuple(measurement for measurement in measurements if measurement.force is not None)
            if with_force and not any(measurement.judged.any() for measurement in with_force):
                for measurement in with_force:
                    check_force(measurement)
            if with_force:
                kept[damper] = with_force
        return replace(self, measurements=kept, notes=tuple(notes))

    def with_force(self, use: str) -> Recording:
        """As ``where_force``, for a ``use`` that requires a force, such as ``fit``.

        Raises:
            InputError: also if no damper has one.
        """
        found = self.where_force()
        if not found.measurements:
            raise no_force_error(self.names[0], use)
        return found

    def save(self, path: str | Path) -> Path:
        """Writes a recording in memory as a file (``.mcap``) with the default topics.

        Times before the first second of 1970, which a file cannot represent, are shifted there.

        Raises:
            InputError: for several recordings, or one that is already a file.
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
            InputError: if pandas is missing, or the recording has several dampers and none is named.
        """
        if damper is None and len(self.dampers) != 1:
            raise InputError(f"{self.names[0]}: has dampers {', '.join(self.dampers)}; name one")
        (measurements,) = self.of(damper or self.dampers[0]).measurements.values()
        return sample_table(measurements)

    def to_dict(self) -> dict[str, object]:
        """Contents: bags, and for each damper samples, seconds, and whether a force was measured."""
        return {
            "bags": list(self.names),
            "dampers": {damper: _facts(measurements) for damper, measurements in self.measurements.items()},
        }

    def __repr__(self) -> str:
        dampers = "; ".join(
            f"{damper}: {_in_words(measurements)}" for damper, measurements in self.measurements.items()
        )
        return f"Recording({', '.join(self.names)}; {dampers or 'no damper'})"

    def _repr_html_(self) -> str:
        rows = [[damper, _in_words(measurements)] for damper, measurements in self.measurements.items()]
        return html_table(", ".join(self.names), ("damper", "samples"), rows)


def storable(part: Part) -> Part:
    """The part with times that a file can represent: slow channels are logged shortly before the first sample."""
    early = _FIRST - int(part.stamps[0])
    return part if early <= 0 else replace(part, stamps=part.stamps + early)


def checked(given: object) -> Recording:
    """The argument itself if it is a recording.

    Raises:
        InputError: for a path, or anything else.
    """
    if not isinstance(given, Recording):
        raise InputError(f"{given!r:.80}: is not a recording; read it first: read(path), or Recording.from_arrays(...)")
    return given


def source_name(source: Source) -> str:
    """Path of a recording, or name of a test in memory."""
    if isinstance(source, Path):
        return str(source)
    return str(source.source) if source.parts == 1 else f"{source.source} (part {source.number})"


def in_words(recordings: Sequence[str]) -> str:
    """Recordings as text for a title."""
    return recordings[0].rpartition("/")[2] if len(recordings) == 1 else f"{len(recordings)} recordings"


def no_force_error(recording: str, use: str) -> InputError:
    """The error if no damper has a measured force."""
    return InputError(f"{recording}: no damper has a measured force; {use} needs one (name its topic in a signal map)")


def _of_part(part: Part, signals: str | Path | SignalMap | None) -> Recording:
    from damper_estimator.workflows.reading import read_parts_in_memory

    return read_parts_in_memory([part], signals)


def _facts(measurements: Sequence[Measurement]) -> dict[str, object]:
    return {
        "samples": sum(len(measurement.kinematics) for measurement in measurements),
        "seconds": float(sum(measurement.kinematics.dt.sum() for measurement in measurements)),
        "force": any(measurement.force is not None for measurement in measurements),
    }


def _in_words(measurements: Sequence[Measurement]) -> str:
    facts = _facts(measurements)
    force = "" if facts["force"] else ", no force"
    return f"{facts['samples']} samples in {facts['seconds']:.4g} s{force}"
