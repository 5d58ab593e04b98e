"""Column maps: the meaning of the columns of a bench or logger file (`config/columns/*.yaml`)."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path

import yaml

from damper_estimator.errors import InputError
from damper_estimator.recordings.column_rules import check_map
from damper_estimator.recordings.library_errors import explained
from damper_estimator.share import share_path

_SEPARATORS = {"tab": "\t", "comma": ",", "semicolon": ";", "space": None}
_FOLDER = "config/columns"
_SOURCES = frozenset({"column", "value", "values", "rate", "interval", "pause", "restart"})


@dataclass(frozen=True)
class Channel:
    """The source of a channel: a ``column``, or constant ``values`` (one for all parts, or one per part).

    value in ``unit`` = scale * number in the file + offset.
    """

    column: str | int | None
    values: tuple[float, ...]
    scale: float
    offset: float
    unit: str


@dataclass(frozen=True)
class Clock:
    """The times of the rows: a column (numbers in ``unit``, or dates of ``format``), or a fixed rate in Hz.

    ``rate`` and ``interval`` are numbers, or the label of the header line with the number.
    """

    column: str | int | None = None
    unit: str = "s"
    format: str | None = None
    rate: float | str | None = None
    interval: float | str | None = None


@dataclass(frozen=True)
class Split:
    """The beginning of a new part: at rows whose text ``column`` is one of ``equals``, after a longer ``pause`` in s,
    or where the time restarts.
    """

    column: str | int | None = None
    equals: tuple[str, ...] = ()
    pause: float | None = None
    restart: bool = False


@dataclass(frozen=True)
class TextFormat:
    """The layout of a text file; None if it is detected. ``separator`` ``""`` is any white space; with ``blocks``
    several tables follow each other, and the lines without numbers between them are skipped.
    """

    separator: str | None = None
    decimal: str | None = None
    skip: int = 0
    titles: int | None = None
    blocks: bool = False


@dataclass(frozen=True)
class ColumnMap:
    """The rules that turn one file into recordings.

    Attributes:
        dampers: channels by damper, then by quantity.
        trim: rest (s) to keep at both ends; None keeps all.
        center: the position that becomes displacement 0: at ``rest``, in the ``middle`` of the stroke, or None.
        name: template of the recordings' names.
    """

    dampers: Mapping[str, Mapping[str, Channel]]
    clock: Clock
    split: Split = field(default_factory=Split)
    trim: float | None = None
    center: str | None = None
    name: str | None = None
    text: TextFormat = field(default_factory=TextFormat)


@dataclass(frozen=True, eq=False)
class ColumnMaps:
    """A column map file: rules for all files, and differences by file name."""

    path: Path
    content: Mapping

    def for_file(self, name: str) -> ColumnMap:
        """The map of one file; of several matching patterns, later ones take precedence.

        Raises:
            InputError: if something necessary is missing for all files and for this one.
        """
        merged = {key: value for key, value in self.content.items() if key != "files"}
        for pattern, differences in (self.content.get("files") or {}).items():
            if fnmatchcase(name, pattern):
                merged = _merged(merged, differences or {})
        complaints = check_map(merged, complete=True)
        if complaints:
            raise InputError(
                f"{self.path}: for {name}: {'; '.join(complaints)}; complete the map, or add it under files"
            )
        return _column_map(merged)


def column_map_of(content: object, where: str) -> ColumnMap:
    """A column map from its content; ``where`` names it in errors.

    Raises:
        InputError: with all its faults.
    """
    complaints = check_map(content, complete=True)
    if complaints:
        raise InputError(f"{where}: {'; '.join(complaints)}; config/columns/example.yaml explains every key")
    return _column_map(content)


def load_column_maps(path: str | Path) -> ColumnMaps:
    """Reads a column map: a YAML file, or the name of one in ``config/columns``.

    Raises:
        InputError: if it cannot be read, has unknown keys or wrong values (all of them at once).
    """
    path = Path(path)
    if not path.suffix and not path.exists():
        path = share_path(_FOLDER) / f"{path.name}.yaml"
    with explained(path, "give a column map (YAML; config/columns/example.yaml explains it)"):
        content = yaml.load(path.read_text(encoding="utf-8"), _Loader)
    complaints = check_map(content, complete=False)
    if complaints:
        raise InputError(f"{path}: {'; '.join(complaints)}; config/columns/example.yaml explains every key")
    return ColumnMaps(path, content)


class _Loader(yaml.SafeLoader):
    """Reads 1e-3 as a number; YAML 1.1 requires 1.0e-3; final."""


_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"[-+]?\d+(\.\d*)?[eE][-+]?\d+$"), list("-+0123456789")
)


def _merged(base: Mapping, differences: Mapping) -> dict:
    """Differences over base, key by key; a new source (such as a column) replaces the old one (such as a constant)."""
    replaced = _SOURCES if _SOURCES & differences.keys() else frozenset()
    result = {key: value for key, value in base.items() if key not in replaced}
    for key, value in differences.items():
        both = isinstance(value, Mapping) and isinstance(result.get(key), Mapping)
        result[key] = _merged(result[key], value) if both else value
    return result


def _column_map(content: Mapping) -> ColumnMap:
    clock = dict(content.get("time") or {})
    for key in ("rate", "interval"):
        if isinstance(clock.get(key), Mapping):
            clock[key] = clock[key]["line"]
    split = dict(content.get("split") or {})
    equals = split.get("equals", ())
    split["equals"] = tuple(str(text) for text in equals) if isinstance(equals, list) else (str(equals),)
    trim = content.get("trim_rest") or None
    return ColumnMap(
        {
            damper: {name: _channel(entry) for name, entry in channels.items()}
            for damper, channels in content["dampers"].items()
        },
        Clock(**clock),
        Split(**split) if {"column", "pause", "restart"} & split.keys() else Split(),
        float(trim["margin"]) if isinstance(trim, Mapping) else trim and 0.2,
        content.get("center") or None,
        content.get("name"),
        _text_format(content.get("text") or {}),
    )


def _channel(entry: Mapping) -> Channel:
    values = entry.get("values", entry.get("value", ()))
    values = tuple(float(value) for value in (values if isinstance(values, list | tuple) else (values,)))
    scale, offset = float(entry.get("scale", 1.0)), float(entry.get("offset", 0.0))
    return Channel(entry.get("column"), values, scale, offset, str(entry["unit"]))


def _text_format(entry: Mapping) -> TextFormat:
    separator = entry.get("separator")
    if separator is not None:
        separator = _SEPARATORS.get(separator, separator) or ""
    return TextFormat(
        separator, entry.get("decimal"), int(entry.get("skip", 0)), entry.get("titles"), bool(entry.get("blocks"))
    )
