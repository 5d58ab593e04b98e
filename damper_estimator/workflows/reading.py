"""Reads bags, bench files and samples in memory, by damper."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path

from damper_estimator.errors import InputError
from damper_estimator.model import compile_loops_ahead
from damper_estimator.recordings import Bag, Part, load_column_maps, open_bag, read_parts
from damper_estimator.signals import (
    DamperSignals,
    Measurement,
    SignalMap,
    load_signal_map,
    measure,
    measured,
    part_channels,
    signals_for,
)
from damper_estimator.workflows.recording import Recording, Source, source_name

PathLikes = str | PathLike[str] | Sequence[str | PathLike[str]]


@dataclass(frozen=True)
class OpenedSource:
    """An opened recording, its signal map with an entry for each of its dampers, and a function that reads one."""

    source: Source
    signal_map: SignalMap
    measure: Callable[[SignalMap, str], Measurement]


@dataclass(frozen=True)
class Reader:
    """Opened recordings that are read damper by damper; ``open_reader`` returns one.

    Attributes:
        sources: the recordings, in order.
        signal_map: with an entry for every damper of the recordings; if several recordings have one, that of the first.
        dampers: names to read, in order of appearance.
        chosen: those requested by name.
        window: (from, to) in s since the start.
    """

    sources: tuple[OpenedSource, ...]
    signal_map: SignalMap
    dampers: tuple[str, ...]
    chosen: tuple[str, ...]
    window: tuple[float, float]

    def damper(self, name: str) -> Recording:
        """Reads one damper from all recordings that have it; a measured force is not required.

        Raises:
            InputError: if a recording lacks a channel that the map names, and if the window is empty.
        """
        having = [source for source in self.sources if name in source.signal_map.dampers]
        lacking = [source_name(source.source) for source in self.sources if name not in source.signal_map.dampers]
        return Recording(
            sources=tuple(source.source for source in having),
            signal_map=self.signal_map,
            measurements={name: tuple(source.measure(source.signal_map, name) for source in having)},
            chosen=self.chosen,
            window=self.window,
            notes=tuple(f"{path}: has no damper {name}; left out" for path in lacking if name in self.chosen),
        )

    def all_dampers(self) -> Recording:
        """Reads all dampers; errors as ``damper``."""
        recordings = [self.damper(name) for name in self.dampers]
        return Recording(
            sources=tuple(
                source.source for source in self.sources if set(source.signal_map.dampers) & set(self.dampers)
            ),
            signal_map=self.signal_map,
            measurements={
                name: recording.measurements[name] for name, recording in zip(self.dampers, recordings, strict=True)
            },
            chosen=self.chosen,
            window=self.window,
            notes=tuple(note for recording in recordings for note in recording.notes),
        )


@contextmanager
def open_reader(
    paths: Sequence[Path],
    signal_map: SignalMap,
    dampers: Sequence[str] = (),
    start: float | None = None,
    stop: float | None = None,
    columns: str | Path | None = None,
) -> Iterator[Reader]:
    """Opens recordings for reading damper by damper.

    Args:
        paths: ``.mcap`` files, rosbag2 folders, or, with ``columns``, bench files.
        dampers: names; empty for all.
        start, stop: s since the start; None for no limit.
        columns: column map of bench files, a path or a name of ``config/columns``.

    Raises:
        InputError: for an unreadable recording, and for a damper that is in none of them.
    """
    window = (0.0 if start is None else start, float("inf") if stop is None else stop)
    with ExitStack() as stack:
        if columns is None:
            bags = [stack.enter_context(open_bag(path)) for path in paths]
            sources = [OpenedSource(bag.path, signals_for(bag, signal_map), _of_bag(bag, window)) for bag in bags]
            yield _reader(sources, dampers, window)
        else:
            yield _reader([_in_memory(part, signal_map, window) for part in _parts(paths, columns)], dampers, window)


def read(
    paths: PathLikes,
    *,
    signals: str | PathLike[str] | SignalMap | None = None,
    columns: str | PathLike[str] | None = None,
    dampers: str | Sequence[str] = (),
    start: float | None = None,
    stop: float | None = None,
) -> Recording:
    """Reads recordings: bags (``.mcap`` or a rosbag2 folder) or, with a column map, bench and logger files.

    Several recordings are pooled in every analysis. Slow channels, force and the map's corrections are read as the
    command line does; samples pass the filter of the signal map (third-order Butterworth, 60 Hz by default).

    Args:
        paths: one recording or several.
        signals: signal map (path or object); not needed for the default topics.
        columns: column map of a CSV, text or MAT file: a path, or the name of one in ``config/columns``.
        dampers: name or names; empty for all.
        start, stop: s since the start; None for no limit.

    Returns:
        The recording with all dampers, including those without a measured force.

    Raises:
        InputError: one line: the file, what is wrong, what to do.
    """
    compile_loops_ahead()
    given = [paths] if isinstance(paths, (str, PathLike)) else list(paths)
    if not given:
        raise InputError("no recordings to read; name a file or a rosbag2 folder")
    chosen = [dampers] if isinstance(dampers, str) else list(dampers)
    columns = None if columns is None else str(columns)
    with open_reader([Path(path) for path in given], signal_map_of(signals), chosen, start, stop, columns) as reader:
        return reader.all_dampers()


def read_parts_in_memory(parts: Sequence[Part], signals: str | PathLike[str] | SignalMap | None = None) -> Recording:
    """The recording of tests in memory."""
    window, signal_map = (0.0, float("inf")), signal_map_of(signals)
    return _reader([_in_memory(part, signal_map, window) for part in parts], (), window).all_dampers()


def signal_map_of(signals: str | PathLike[str] | SignalMap | None) -> SignalMap:
    """A signal map from its path; None for the default one.

    Raises:
        InputError: if the file is unusable.
    """
    return signals if isinstance(signals, SignalMap) else load_signal_map(None if signals is None else Path(signals))


def _reader(sources: Sequence[OpenedSource], requested: Sequence[str], window: tuple[float, float]) -> Reader:
    entries: dict[str, DamperSignals] = {}
    for source in sources:
        entries |= {name: signals for name, signals in source.signal_map.dampers.items() if name not in entries}
    missing = [name for name in requested if name not in entries]
    if missing:
        given = sources[0].signal_map.where
        where = given if given != SignalMap().where else source_name(sources[0].source)
        raise InputError(f"{where}: has no damper {missing[0]!r}; it has {', '.join(entries)}")
    dampers = tuple(name for name in entries if not requested or name in requested)
    return Reader(tuple(sources), replace(sources[0].signal_map, dampers=entries), dampers, tuple(requested), window)


def _of_bag(bag: Bag, window: tuple[float, float]) -> Callable[[SignalMap, str], Measurement]:
    return lambda signal_map, damper: measure(bag, signal_map, damper, *window, force_wanted=False)


def _in_memory(part: Part, given: SignalMap, window: tuple[float, float]) -> OpenedSource:
    signal_map, name = given.with_dampers(list(part.dampers)), source_name(part)
    present = replace(signal_map, dampers={k: entry for k, entry in signal_map.dampers.items() if k in part.dampers})
    if not present.dampers:
        raise InputError(
            f"{given.where}: names dampers {', '.join(given.dampers)}, but {name} has {', '.join(part.dampers)}"
        )

    def measure_part(used_map: SignalMap, damper: str) -> Measurement:
        channels = part_channels(part, damper, used_map.dampers[damper].channels())
        return measured(name, damper, channels, used_map, *window)

    return OpenedSource(part, present, measure_part)


def _parts(paths: Sequence[Path], columns: str | Path) -> list[Part]:
    maps = load_column_maps(columns)
    return [part for path in paths for part in read_parts(path, maps.for_file(path.name))]
