"""Bench and logger files as the parts of a test: channels in SI units over time."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.recordings.bench_rest import find_motion, middle_position, rest_position
from damper_estimator.recordings.bench_table import Column, MatTable, Table, file_content
from damper_estimator.recordings.clock import Times, read_times
from damper_estimator.recordings.column_map import Channel, ColumnMap
from damper_estimator.recordings.quantities import QUANTITIES, bag_unit
from damper_estimator.recordings.text_table import TextTable

_FAST = ("displacement", "force")  # these need one number per row
_MOSTLY_TEXT = 0.5
_SUFFIXES = (".gz", ".mat", ".csv", ".tsv", ".txt", ".dat", ".asc", ".log")


@dataclass(frozen=True, eq=False)
class Part:
    """A part of a bench file that becomes one recording.

    Attributes:
        source: the file; ``number`` of ``parts`` in it, from 1.
        stamps: (n,) int64, ns.
        dampers: channels by damper and quantity: (n,) float64 (NaN: no number in the file), or one constant number.
        units: in the bag, in the same structure.
        notes: for the user.
    """

    source: Path
    number: int
    parts: int
    stamps: np.ndarray
    dampers: Mapping[str, Mapping[str, np.ndarray | float]]
    units: Mapping[str, Mapping[str, str]]
    notes: tuple[str, ...] = ()

    @property
    def stem(self) -> str:
        """The file's name without the suffixes of its format."""
        name = self.source.name
        for suffix in _SUFFIXES:
            name = name[: -len(suffix)] if name.lower().endswith(suffix) else name
        return name

    @property
    def duration(self) -> float:
        """From the first to the last sample, s."""
        return float(self.stamps[-1] - self.stamps[0]) * 1e-9

    @property
    def rate(self) -> float:
        """Samples per second, (n - 1) / duration; NaN if there is no duration."""
        return (len(self.stamps) - 1) / self.duration if self.duration > 0 else float("nan")


def read_parts(path: Path, rules: ColumnMap) -> list[Part]:
    """Reads a CSV, text or MAT file (gzip or not) and cuts it into its parts.

    Raises:
        InputError: if the file cannot be read, lacks a column, contains text instead of numbers, or its parts do not
            match the constants in the map.
    """
    table = _open_table(path, rules)
    columns = {
        (damper, name): table.numbers(channel.column)
        for damper, channels in rules.dampers.items()
        for name, channel in channels.items()
        if channel.column is not None
    }
    times = read_times(table, rules.clock)
    if len(times.seconds) != table.rows:
        raise InputError(f"{path}: {len(times.seconds)} times, but {table.rows} rows; give another time.column")
    stretches = [rows for rows in _stretches(table, rules, times) if rows.stop - rows.start > 1]
    if not stretches:
        raise InputError(f"{path}: fewer than two rows of numbers; export it again")
    return [
        _part(path, rules, times, columns, rows, number, len(stretches))
        for number, rows in enumerate(stretches, start=1)
    ]


def _open_table(path: Path, rules: ColumnMap) -> Table:
    content = file_content(path)
    if path.suffix.lower() == ".mat" or content.startswith(b"MATLAB "):
        return MatTable(path, content)
    needed = [channel.column for channels in rules.dampers.values() for channel in channels.values() if channel.column]
    named: list[Column] = [rules.split.column] if rules.split.column else []
    if rules.clock.column:
        (named if rules.clock.format else needed).append(rules.clock.column)
    return TextTable(path, content, rules.text, needed, named)


def _stretches(table: Table, rules: ColumnMap, times: Times) -> Iterator[slice]:
    """The rows of each part."""
    cuts: list[int] = []
    if rules.split.column is not None:
        cuts = [row for row, text in enumerate(table.texts(rules.split.column)) if text in rules.split.equals]
    elif rules.split.pause is not None:
        if not times.measured:
            raise InputError(
                f"{table.path}: pauses cannot be seen at a fixed rate; give time.column, or split by events"
            )
        cuts = (np.flatnonzero(np.diff(times.seconds) > rules.split.pause) + 1).tolist()
    elif rules.split.restart:
        if not times.measured:
            raise InputError(f"{table.path}: a fixed rate never restarts; give time.column, or split by events")
        cuts = (np.flatnonzero(np.diff(times.seconds) < 0.0) + 1).tolist()
    edges = sorted({0, *cuts, table.rows})
    for start, stop in pairwise(edges):
        yield slice(start, stop)


def _part(path: Path, rules: ColumnMap, times: Times, columns: Mapping, rows: slice, number: int, parts: int) -> Part:
    notes: list[str] = []
    dampers = {
        damper: {
            name: _constant(path, f"{damper}.{name}", channel, name, number, parts)
            if channel.column is None
            else _converted(columns[damper, name][rows], channel, name)
            for name, channel in channels.items()
        }
        for damper, channels in rules.dampers.items()
    }
    for damper, channels in rules.dampers.items():
        for name, channel in channels.items():
            notes += _missing(path, f"{damper}.{name}", channel.column, dampers[damper][name])
    units = {
        damper: {name: bag_unit(name, channel.unit) for name, channel in channels.items()}
        for damper, channels in rules.dampers.items()
    }
    stamps = times.stamps(rows)
    back = int((np.diff(stamps) <= 0).sum())
    if back:
        notes.append(f"{back} rows are not later than the row before")
    part = Part(path, number, parts, stamps, dampers, units, tuple(notes))
    return _centered(_trimmed(part, rules.trim), part, rules.center)


def _constant(path: Path, where: str, channel: Channel, name: str, number: int, parts: int) -> float:
    if len(channel.values) not in (1, parts):
        what = f"{len(channel.values)} values of {where}, but {parts} parts"
        raise InputError(f"{path}: {what}; give one per part in the column map, or correct split")
    return float(_converted(np.array(channel.values[number - 1 if len(channel.values) > 1 else 0]), channel, name))


def _converted(raw: np.ndarray, channel: Channel, name: str) -> np.ndarray:
    factor, offset = QUANTITIES[name].units[channel.unit]
    return factor * (channel.scale * np.where(np.isfinite(raw), raw, np.nan) + channel.offset) + offset


def _missing(path: Path, where: str, column: Column | None, values: np.ndarray | float) -> Iterator[str]:
    """Notes how many cells are no numbers; refuses columns that are mostly text, and slow channels without numbers."""
    bad = int(np.isnan(values).sum())
    if bad:
        share, name = bad / np.size(values), where.rpartition(".")[2]
        if share > _MOSTLY_TEXT and (name in _FAST or share == 1):
            what = f"{bad} of {np.size(values)} cells of column {column!r} ({where}) are no numbers"
            raise InputError(f"{path}: {what}; name another column, or text.decimal")
        yield f"{bad} cells of {where} are no numbers"


def _trimmed(part: Part, margin: float | None) -> Part:
    if margin is None:
        return part
    motions = [find_motion(channels["displacement"]) for channels in part.dampers.values()]
    start, stop = min(motion.start for motion in motions), max(motion.stop for motion in motions)
    keep = round(margin * 1e9)
    kept = (part.stamps >= part.stamps[start] - keep) & (part.stamps <= part.stamps[stop - 1] + keep)
    kept[start:stop] = True  # even if the times contradict
    return replace(part, stamps=part.stamps[kept], dampers=_each(part.dampers, lambda values: values[kept]))


def _each(dampers: Mapping, change) -> dict:
    return {
        damper: {name: change(values) if np.ndim(values) else values for name, values in channels.items()}
        for damper, channels in dampers.items()
    }


def _centered(part: Part, whole: Part, center: str | None) -> Part:
    """Subtracts the position at rest, which only the untrimmed part contains, or the middle of the stroke."""
    if center is None:
        return part
    dampers = {}
    for damper, channels in part.dampers.items():
        position = whole.dampers[damper]["displacement"]
        zero = middle_position(position) if center == "middle" else rest_position(position, find_motion(position))
        dampers[damper] = {**channels, "displacement": channels["displacement"] - zero}
    return replace(part, dampers=dampers)
