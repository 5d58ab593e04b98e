"""The rules of a column map: all faults at once."""

import re
from collections.abc import Callable, Iterator, Mapping
from datetime import datetime

from damper_estimator.recordings.quantities import QUANTITIES, TIME_UNITS

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_KEYS = ("dampers", "time", "text", "split", "trim_rest", "center", "name", "files")
_CHANNEL_KEYS = ("column", "value", "values", "scale", "offset", "unit")
_TIME_KEYS = ("column", "unit", "format", "rate", "interval")
_SPLIT_KEYS = ("column", "equals", "pause", "restart")
_TEXT_KEYS = ("separator", "decimal", "skip", "titles", "blocks")
_SEPARATORS = ("tab", "comma", "semicolon", "space")


def check_map(content: object, complete: bool) -> list[str]:
    """Complaints about a column map's content, none if it is correct.

    Args:
        content: of the YAML file.
        complete: whether everything necessary must be there (else it can still come from ``files``).
    """
    if not isinstance(content, Mapping):
        return ["it must be a mapping with the key dampers"]
    complaints = list(_check(content, complete))
    files = content.get("files") or {}
    if not isinstance(files, Mapping):
        complaints.append("files must map file name patterns to their differences")
        return complaints
    for pattern, differences in files.items():
        if isinstance(differences, Mapping):
            complaints += [f'files "{pattern}": {text}' for text in _check(differences, False, inside_files=True)]
        elif differences is not None:
            complaints.append(f'files "{pattern}" must be a mapping')
    return complaints


def _check(content: Mapping, complete: bool, inside_files: bool = False) -> Iterator[str]:
    yield from _unknown(content, _KEYS[:-1] if inside_files else _KEYS, "the map")
    dampers = content.get("dampers")
    if isinstance(dampers, Mapping) and dampers:
        for damper, channels in dampers.items():
            if not _NAME.fullmatch(str(damper)):
                yield f"damper {damper!r} cannot be part of a topic; use letters, digits and _"
            yield from _check_damper(f"dampers.{damper}", channels, complete)
    elif dampers is not None or complete:
        yield "dampers must map damper names to their channels"
    for key, check in (
        ("time", _check_time),
        ("split", _check_split),
        ("text", _check_text),
        ("trim_rest", _check_trim),
    ):
        if content.get(key) not in (None, False):
            yield from check(content[key])
    if complete and not content.get("time"):
        yield "time is missing: give a column, a rate or an interval"
    if content.get("center") not in (None, False, "rest", "middle"):
        yield f"center is {content['center']!r}; it can be rest or middle"
    if not isinstance(content.get("name", ""), str):
        yield "name must be text such as {stem}_{part}"


def _check_damper(where: str, channels: object, complete: bool) -> Iterator[str]:
    if not isinstance(channels, Mapping):
        yield f"{where} must map channels ({', '.join(QUANTITIES)}) to their columns"
        return
    yield from _unknown(channels, tuple(QUANTITIES), where)
    if complete and "displacement" not in channels:
        yield f"{where} has no displacement"
    for name in QUANTITIES.keys() & channels.keys():
        yield from _check_channel(f"{where}.{name}", name, channels[name], complete)


def _check_channel(where: str, quantity: str, entry: object, complete: bool) -> Iterator[str]:
    if not isinstance(entry, Mapping):
        yield f"{where} must be a mapping such as {{column: 2, unit: {next(iter(QUANTITIES[quantity].units))}}}"
        return
    yield from _unknown(entry, _CHANNEL_KEYS, where)
    sources = [key for key in ("column", "value", "values") if key in entry]
    if len(sources) > 1 or (complete and not sources):
        yield f"{where} needs one of column, value and values" + (f", not {' and '.join(sources)}" if sources else "")
    if sources and sources[0] != "column" and quantity in ("displacement", "force"):
        yield f"{where} cannot be constant; give its column"
    yield from _typed(entry, where, column=_is_column, value=_is_number, scale=_is_number, offset=_is_number)
    if "values" in entry and not (isinstance(entry["values"], list) and all(map(_is_number, entry["values"]))):
        yield f"{where}.values must be a list of numbers, one per part"
    units = QUANTITIES[quantity].units
    if "unit" in entry and str(entry["unit"]) not in units:
        yield f"{where}.unit is {entry['unit']!r}; it can be {', '.join(units)} (scale converts volts to one of them)"
    elif complete and "unit" not in entry:
        yield f"{where}.unit is missing; it can be {', '.join(units)}"


def _check_time(entry: object) -> Iterator[str]:
    if not isinstance(entry, Mapping):
        yield "time must be a mapping such as {rate: 1000} or {column: Time, unit: s}"
        return
    yield from _unknown(entry, _TIME_KEYS, "time")
    given = [key for key in ("column", "rate", "interval") if key in entry]
    if len(given) != 1:
        yield f"time needs one of column, rate and interval, not {' and '.join(given) or 'none'}"
    if "unit" in entry and str(entry["unit"]) not in TIME_UNITS:
        yield f"time.unit is {entry['unit']!r}; it can be {', '.join(TIME_UNITS)}"
    yield from _typed(entry, "time", column=_is_column, format=_is_date_format)
    for key in ("rate", "interval"):
        value = entry.get(key, 1.0)
        by_line = isinstance(value, Mapping) and set(value) == {"line"} and isinstance(value["line"], str)
        if not by_line and not (_is_number(value) and value > 0):
            yield f"time.{key} must be a positive number, or {{line: label of the header line}}"


def _check_split(entry: object) -> Iterator[str]:
    if not isinstance(entry, Mapping):
        yield "split must be a mapping such as {column: Events, equals: DAQ Resume} or {pause: 1.0}"
        return
    yield from _unknown(entry, _SPLIT_KEYS, "split")
    by_event = "column" in entry and "equals" in entry
    if by_event + ("pause" in entry) + ("restart" in entry) != 1 or ("column" in entry) != ("equals" in entry):
        yield "split needs one of column and equals, pause, or restart"
    yield from _typed(entry, "split", column=_is_column, pause=_is_positive, restart=_is_yes)


def _check_text(entry: object) -> Iterator[str]:
    if not isinstance(entry, Mapping):
        yield "text must be a mapping such as {separator: tab, decimal: ','}"
        return
    yield from _unknown(entry, _TEXT_KEYS, "text")
    separator = entry.get("separator", ",")
    if not isinstance(separator, str) or (len(separator) != 1 and separator not in _SEPARATORS):
        yield f"text.separator is {separator!r}; it can be one character, {', '.join(_SEPARATORS)}"
    if entry.get("decimal", ".") not in (".", ","):
        yield f"text.decimal is {entry['decimal']!r}; it can be '.' or ','"
    titles = lambda value: _is_count(value) and value > 0  # noqa: E731
    yield from _typed(entry, "text", skip=_is_count, titles=titles, blocks=_is_yes)


def _check_trim(entry: object) -> Iterator[str]:
    if entry is True:
        return
    if (
        not isinstance(entry, Mapping)
        or set(entry) != {"margin"}
        or not _is_number(entry["margin"])
        or entry["margin"] < 0
    ):
        yield "trim_rest can be true, or {margin: seconds of rest to keep}"


def _unknown(entry: Mapping, allowed: tuple[str, ...], where: str) -> Iterator[str]:
    unknown = [str(key) for key in entry if key not in allowed]
    if unknown:
        yield f"{where} has unknown keys {', '.join(unknown)} (allowed: {', '.join(allowed)})"


def _typed(entry: Mapping, where: str, **checks: Callable[[object], bool]) -> Iterator[str]:
    for key, right in checks.items():
        if key in entry and not right(entry[key]):
            yield f"{where}.{key} cannot be {entry[key]!r}"


def _is_yes(value: object) -> bool:
    return value is True


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < float("inf")


def _is_positive(value: object) -> bool:
    return _is_number(value) and value > 0


def _is_count(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= 0


def _is_column(value: object) -> bool:
    return (isinstance(value, str) and bool(value.strip())) or (_is_count(value) and value > 0)


def _is_date_format(value: object) -> bool:
    if not isinstance(value, str) or "%" not in value:
        return False
    try:
        datetime.strptime(datetime(2000, 1, 2).strftime(value), value)
    except ValueError:
        return False
    return True
