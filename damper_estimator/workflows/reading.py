"""The one reader: bags, bench files and samples in memory, by damper."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path

from damper_estimator.errors import InputError
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
    """An opened recording, its signal map with an entry for each of its dampers, and what reads one of them."""

    source: Source
    signal_map: SignalMap
    measure: Callable[[SignalMap, str], Measurement]


@dataclass(frozen=True)
class Reader:
    """Opened recordings, of which one damper after the other is read; ``opened`` makes it.

    Attributes:
        sources: the recordings, in order.
        signal_map: with an entry for every damper of the recordings; where several have one, that of the first.
        dampers: that are to be read, in order of appearance.
        chosen: those that were asked for by name.
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
            InputError: for channels that a map names and a recording lacks, and where nothing is left in the window.
        """
        having = [own for own in self.sources if name in own.signal_map.dampers]
        lacking = [source_name(own.source) for own in self.sources if name not in own.signal_map.dampers]
        return Recording(
            sources=tuple(own.source for own in having),
            signal_map=self.signal_map,
            measurements={name: tuple(own.measure(own.signal_map, name) for own in having)},
            chosen=self.chosen,
            window=self.window,
            notes=tuple(f"{own}: has no damper {name}; left out" for own in lacking if name in self.chosen),
        )

    def every(self) -> Recording:
        """Reads all dampers; errors as ``damper``."""
        read = [self.damper(name) for name in self.dampers]
        return Recording(
            sources=tuple(own.source for own in self.sources if set(own.signal_map.dampers) & set(self.dampers)),
            signal_map=self.signal_map,
            measurements={name: own.measurements[name] for name, own in zip(self.dampers, read, strict=True)},
            chosen=self.chosen,
            window=self.window,
            notes=tuple(note for own in read for note in own.notes),
        )


@contextmanager
def opened(
    paths: Sequence[Path],
    signal_map: SignalMap,
    dampers: Sequence[str] = (),
    start: float | None = None,
    stop: float | None = None,
    columns: str | Path | None = None,
) -> Iterator[Reader]:
    """Opens recordings, to read them damper by damper.

    Args:
        paths: ``.mcap`` files, rosbag2 folders, or bench files where ``columns`` are given.
        dampers: which; empty for all.
        start, stop: s since the start; None where all is read.
        columns: column map of bench files, a path or a name of ``config/columns``.

    Raises:
        InputError: for a recording that cannot be read, and a damper that is in none of them.
    """
    window = (0.0 if start is None else start, float("inf") if stop is None else stop)
    with ExitStack() as stack:
        if columns is None:
            bags = [stack.enter_context(open_bag(path)) for path in paths]
            sources = [OpenedSource(own.path, signals_for(own, signal_map), _of_bag(own, window)) for own in bags]
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

    Several recordings are pooled by all that works on them. Slow channels, force and the map's corrections are read as
    the command line does; samples pass the filter of the signal map (third-order Butterworth, 60 Hz by default).

    Args:
        paths: one recording, or several of them.
        signals: signal map (path or object); not needed for the default topics.
        columns: column map of a CSV, text or MAT file: a path, or the name of one in ``config/columns``.
        dampers: name or names; empty for all.
        start, stop: s since the start; None where all is read.

    Returns:
        The recording, all dampers by name; dampers without a measured force are in it as well.

    Raises:
        InputError: one line; the file, what is wrong, what to do.
    """
    given = [paths] if isinstance(paths, (str, PathLike)) else list(paths)
    if not given:
        raise InputError("there are no recordings to read; name a file or a rosbag2 folder")
    chosen = [dampers] if isinstance(dampers, str) else list(dampers)
    columns = None if columns is None else str(columns)
    with opened([Path(own) for own in given], signal_map_of(signals), chosen, start, stop, columns) as reader:
        return reader.every()


def read_parts_in_memory(parts: Sequence[Part], signals: str | PathLike[str] | SignalMap | None = None) -> Recording:
    """The recording of tests that lie in memory."""
    window, signal_map = (0.0, float("inf")), signal_map_of(signals)
    return _reader([_in_memory(part, signal_map, window) for part in parts], (), window).every()


def signal_map_of(signals: str | PathLike[str] | SignalMap | None) -> SignalMap:
    """A signal map from its path; None is the default one.

    Raises:
        InputError: where the file cannot be used.
    """
    return signals if isinstance(signals, SignalMap) else load_signal_map(None if signals is None else Path(signals))


def _reader(sources: Sequence[OpenedSource], wanted: Sequence[str], window: tuple[float, float]) -> Reader:
    entries: dict[str, DamperSignals] = {}
    for own in sources:
        entries |= {name: signals for name, signals in own.signal_map.dampers.items() if name not in entries}
    missing = [name for name in wanted if name not in entries]
    if missing:
        given = sources[0].signal_map.where
        where = given if given != SignalMap().where else source_name(sources[0].source)
        raise InputError(f"{where}: has no damper {missing[0]!r}; it has {', '.join(entries)}")
    dampers = tuple(name for name in entries if not wanted or name in wanted)
    return Reader(tuple(sources), replace(sources[0].signal_map, dampers=entries), dampers, tuple(wanted), window)


def _of_bag(bag: Bag, window: tuple[float, float]) -> Callable[[SignalMap, str], Measurement]:
    return lambda signal_map, damper: measure(bag, signal_map, damper, *window, force_wanted=False)


def _in_memory(part: Part, given: SignalMap, window: tuple[float, float]) -> OpenedSource:
    signal_map, name = given.with_dampers(list(part.dampers)), source_name(part)
    there = replace(signal_map, dampers={k: own for k, own in signal_map.dampers.items() if k in part.dampers})
    if not there.dampers:
        raise InputError(
            f"{given.where}: names dampers {', '.join(given.dampers)}, but {name} has {', '.join(part.dampers)}"
        )

    def measure_part(own: SignalMap, damper: str) -> Measurement:
        channels = part_channels(part, damper, own.dampers[damper].channels())
        return measured(name, damper, channels, own, *window)

    return OpenedSource(part, there, measure_part)


def _parts(paths: Sequence[Path], columns: str | Path) -> list[Part]:
    maps = load_column_maps(columns)
    return [part for path in paths for part in read_parts(path, maps.for_file(path.name))]
