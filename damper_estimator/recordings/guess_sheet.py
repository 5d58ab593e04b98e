"""A bench or logger file without a map: its columns, titles, units, and hints at its rate."""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.recordings.bench_table import Column, file_content
from damper_estimator.recordings.column_map import TextFormat
from damper_estimator.recordings.guess_words import is_unit
from damper_estimator.recordings.library_errors import explained
from damper_estimator.recordings.mat_file import read_mat
from damper_estimator.recordings.text_layout import split_cells
from damper_estimator.recordings.text_table import TextTable, decoded

_SEPARATORS = {"\t": "tab", ";": "semicolon", ",": "comma", "|": "|", "": "space"}
_SAMPLE, _HEAD, _MOST_COLUMNS = 60, 1000, 200
_DATES = (
    "%d.%m.%Y %H:%M:%S.%f", "%d.%m.%Y %H:%M:%S,%f", "%Y-%m-%d %H:%M:%S.%f", "%Y-%m-%dT%H:%M:%S.%f",
    "%Y-%m-%dT%H:%M:%S.%fZ", "%m/%d/%Y %H:%M:%S.%f", "%m/%d/%Y %I:%M:%S.%f %p", "%H:%M:%S.%f", "%H:%M:%S,%f",
    "%H:%M:%S:%f",
)  # fmt: skip
_RATE = re.compile(r"rate|frequen|frequenz|sampling|abtast|\bhz\b|\bfs\b", re.IGNORECASE)
_HERTZ = re.compile(
    r"^\s*([^\d]*?)[\s:=;,]*([-+]?\d+(?:[.,]\d+)?(?:[eE][-+]?\d+)?)[\s;,]*(hz|1/s)?\s*[;,]*\s*$", re.IGNORECASE
)


@dataclass(frozen=True, eq=False)
class Sheet:
    """The content of a file.

    Attributes:
        columns: as in a column map: title, number or MAT expression.
        titles, units: of each column, "" if there are none.
        numbers: (rows,) of each; all NaN for text.
        dates, texts: the format of the columns of dates, and their cells.
        rate: Hz that a line above the numbers names; None if none does.
        text: for the column map's key of that name; empty for MAT files.
        several: whether lines of titles repeat among the numbers.
    """

    path: Path
    columns: tuple[Column, ...]
    titles: tuple[str, ...]
    units: tuple[str, ...]
    numbers: tuple[np.ndarray, ...]
    dates: Mapping[int, str] = field(default_factory=dict)
    texts: Mapping[int, list[str]] = field(default_factory=dict)
    rate: float | None = None
    text: Mapping[str, object] = field(default_factory=dict)
    several: bool = False


def read_sheet(path: Path) -> Sheet:
    """Reads a CSV, text or MAT file of unknown content.

    Raises:
        InputError: if it cannot be read, or contains no table of numbers.
    """
    content = file_content(path)
    if path.suffix.lower() == ".mat" or content.startswith(b"MATLAB "):
        return _mat_sheet(path, content)
    lines = decoded(content).splitlines()
    separator, decimal, width = _layout(path, lines)
    first = _first_row(path, lines, separator, decimal, width)
    title, titles, units = _titles(path, lines[:first], separator, width)
    several = _has_headings(path, lines[first:], separator, decimal, width)
    text = {"separator": _SEPARATORS[separator], "decimal": decimal}
    # Without a suitable row of titles, the lines above the first numbers are skipped.
    text |= {"titles": title + 1} if title is not None else {"skip": first}
    text |= {"blocks": True} if several else {}
    numbered = list(range(1, width + 1))
    known = TextFormat(separator, decimal, first, None, several)
    table = TextTable(path, content, known, numbered, numbered)
    columns = tuple(_named(i, titles) if title is not None else i + 1 for i in range(width))
    numbers = tuple(table.numbers(i) for i in numbered)
    dates = {i: form for i in range(width) if (form := _date_format(table.texts(i + 1), numbers[i])) is not None}
    texts = {i: table.texts(i + 1) for i in dates}
    return Sheet(path, columns, titles, units, numbers, dates, texts, _rate(lines[:first]), text, several)


def _named(index: int, titles: Sequence[str]) -> Column:
    """The title if it is unique, else the number."""
    plain = [re.sub(r"\s*[\[(][^\])]*[\])]\s*$", "", title).casefold().strip("\"' ") for title in titles]
    return titles[index] if titles[index] and plain.count(plain[index]) == 1 and plain[index] else index + 1


def _layout(path: Path, lines: Sequence[str]) -> tuple[str, str, int]:
    """Separator, decimal sign and number of columns with which most of the middle is numbers."""
    full = [line for line in lines if line.strip()]
    middle = full[len(full) // 2 :][:_SAMPLE] or full
    best: tuple[float, str, str, int] = (0.0, "", ".", 0)
    for separator in _SEPARATORS:
        rows = [[cell.strip() for cell in row] for row in split_cells(path, middle, separator)]
        for decimal in ".,":
            if separator == decimal and not any('"' in line for line in middle):
                continue
            widths = Counter(len(row) for row in rows)
            width, count = widths.most_common(1)[0]
            cells = [cell for row in rows if len(row) == width for cell in row if cell]
            numeric = [_is_number(cell, decimal) for cell in cells]
            score = count / len(rows) * (sum(numeric) / len(numeric) if numeric else 0.0)
            marks = sum(decimal in cell for cell in cells) > 0
            if width >= 2 and score + 0.01 * marks > best[0] + 1e-9:
                best = (score + 0.01 * marks, separator, decimal, width)
    if best[0] < 0.3 or best[3] > _MOST_COLUMNS:
        raise InputError(f"{path}: contains no table of numbers; describe it in a column map (--columns)")
    return best[1], best[2], _without_empty_end(path, middle, best[1], best[3])


def _without_empty_end(path: Path, middle: Sequence[str], separator: str, width: int) -> int:
    """The number of columns without those at the end that are always empty."""
    rows = [row for row in split_cells(path, middle, separator) if len(row) == width]
    while width > 2 and not any(row[width - 1].strip() for row in rows):
        width -= 1
    return width


def _first_row(path: Path, lines: Sequence[str], separator: str, decimal: str, width: int) -> int:
    """The first of three consecutive lines of numbers."""
    run, start, need = 0, 0, 3
    head = lines[: _HEAD * 5]
    for i, row in enumerate(split_cells(path, head, separator)):
        if not any(cell.strip() for cell in row):
            continue
        filled = [cell.strip() for cell in row[:width] if cell.strip()]
        good = (
            len(filled) >= 2
            and 2 * sum(_is_number(cell, decimal) for cell in filled) >= len(filled)
            and len(row) >= width
        )
        run = run + 1 if good else 0
        start = i if run == 1 else start if good else 0
        if run == need:
            return start
    raise InputError(f"{path}: fewer than {need} rows of numbers follow each other; export it again")


def _titles(
    path: Path, head: Sequence[str], separator: str, width: int
) -> tuple[int | None, tuple[str, ...], tuple[str, ...]]:
    """Line of the titles, titles and units; the line only if the map can use its titles."""
    units = ("",) * width
    for i in range(len(head) - 1, max(len(head) - 8, -1), -1):
        cells = _cells(path, head[i], separator, width)
        if cells is None or not any(cells):
            continue
        filled = [cell for cell in cells if cell]
        if (
            not any(units)
            and sum(map(is_unit, filled)) > 0.6 * len(filled)
            and _is_unit_row(path, head[:i], separator, width)
        ):
            units = cells
            continue
        if len(filled) >= min(2, width) and sum(_is_number(cell, ".") for cell in filled) <= 0.3 * len(filled):
            same = len([c for c in next(iter(split_cells(path, [head[i]], separator))) if c.strip()]) <= width
            return (i if same and len(head) - i <= 4 else None), cells, units
    return None, ("",) * width, units


def _is_unit_row(path: Path, head: Sequence[str], separator: str, width: int) -> bool:
    """Whether there are titles above: single letters such as t, x, F can be both."""
    above = [cells for line in head[-3:] if (cells := _cells(path, line, separator, width)) and any(cells)]
    return any(len([c for c in cells if c]) >= 2 for cells in above)


def _cells(path: Path, line: str, separator: str, width: int) -> tuple[str, ...] | None:
    """The titles in a line; in columns of white space, titles with spaces are two spaces apart."""
    line = line.lstrip("#%/ ") if separator != "\t" else line.lstrip("#%/")
    row = [cell.strip().strip('"') for cell in next(iter(split_cells(path, [line], separator)), [])]
    if not separator and len(row) != width:
        row = [cell.strip() for cell in re.split(r"\s{2,}|\t", line.strip())]
    if len(row) < 2 and width >= 2:
        return None
    return tuple((row + [""] * width)[:width]) if len(row) <= width + 1 else None


def _has_headings(path: Path, lines: Sequence[str], separator: str, decimal: str, width: int) -> bool:
    """Whether there are lines without numbers among the numbers."""
    rows = split_cells(path, [line for line in lines if line.strip()], separator)
    return any(2 * sum(_is_number(cell.strip(), decimal) for cell in row) < max(width, 2) for row in rows if any(row))


def _is_number(cell: str, decimal: str) -> bool:
    try:
        float(cell.replace(",", ".") if decimal == "," else cell)
    except ValueError:
        return False
    return True


def _date_format(texts: Sequence[str], numbers: np.ndarray) -> str | None:
    sample = [text for text in texts[:20] if text]
    if not sample or np.isfinite(numbers).any() or not any(":" in text for text in sample):
        return None
    for form in _DATES:
        try:
            for text in sample:
                datetime.strptime(text, form)
        except ValueError:
            continue
        return form
    return None


def _rate(head: Sequence[str]) -> float | None:
    """The rate in Hz that a line names; None if none does, or several differ."""
    found = set()
    for line in head:
        match = _HERTZ.match(line.strip().strip("#%/ ").replace("\t", " ").replace('"', ""))
        if match and (_RATE.search(match.group(1)) or match.group(3)):
            value = float(match.group(2).replace(",", "."))
            if "khz" not in line.lower() and 1.0 <= value <= 1e6 and ("hz" in line.lower() or "1/s" in line.lower()):
                found.add(value)
    return found.pop() if len(found) == 1 else None


def _mat_sheet(path: Path, content: bytes) -> Sheet:
    with explained(path, "save it again, with -v7"):
        columns = list(_arrays(read_mat(content), ""))
    lengths = Counter(len(values) for _, values in columns if len(values) > 2)
    if not lengths:
        raise InputError(f"{path}: contains no columns of numbers; describe it in a column map (--columns)")
    rows = max(lengths, key=lambda length: (lengths[length] > 1, length))
    kept = [(name, values) for name, values in columns if len(values) == rows][:_MOST_COLUMNS]
    titles = tuple(name.rpartition(".")[2] if "[" not in name else name for name, _ in kept)
    single = {name: float(v[0]) for name, v in columns if len(v) == 1}
    rate = next((v for name, v in single.items() if re.search(r"(^|\.)(fs|rate|sampl\w*)$", name, re.IGNORECASE)), None)
    return Sheet(path, tuple(n for n, _ in kept), titles, ("",) * len(kept), tuple(v for _, v in kept), rate=rate)


def _arrays(value: object, name: str):
    """Every column of numbers in a MAT file, by the expression that a column map uses."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from _arrays(inner, f"{name}.{key}" if name else str(key))
    elif isinstance(value, np.ndarray) and value.dtype.kind in "fiu":
        array = np.atleast_1d(value).astype(float)
        if array.ndim == 1:
            yield name, array
        elif array.ndim == 2 and array.shape[1] <= 20:
            yield from ((f"{name}[:,{i}]", array[:, i]) for i in range(array.shape[1]))
        elif array.ndim == 2 and array.shape[0] <= 20:
            yield from ((f"{name}[{i},:]", array[i]) for i in range(array.shape[0]))
