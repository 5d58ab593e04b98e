"""Layout of a text file of columns: separator, decimal sign, titles, first row of numbers."""

import csv
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from damper_estimator.errors import InputError
from damper_estimator.recordings.bench_table import Column
from damper_estimator.recordings.column_map import TextFormat

_CANDIDATES = ("\t", ";", ",")
_COMMA_NUMBER = re.compile(r"[-+]?\d+,\d+([eE][-+]?\d+)?")
_WHOLE = re.compile(r"[-+]?\d+")
_UNIT_IN_TITLE = re.compile(r"\s*[\[(][^\])]*[\])]\s*$")
_SAMPLE = 40
_HEAD = 1000  # lines that must contain the titles and the first numbers
_UNIT_ROWS = 3  # maximum number of lines without numbers between titles and data


@dataclass(frozen=True)
class TextLayout:
    """The layout of one file; ``separator`` ``""`` is any white space, ``first`` the number of the first data line."""

    path: object
    separator: str
    decimal: str
    titles: tuple[str, ...]
    first: int

    def split(self, lines: Sequence[str]) -> Iterable[list[str]]:
        """The cells of each line, stripped."""
        return ([cell.strip() for cell in row] for row in split_cells(self.path, lines, self.separator))

    def place(self, column: Column) -> int:
        """The cell of a column in a row.

        Raises:
            InputError: if there is no such title, or several; lists the existing ones.
        """
        if isinstance(column, int):
            return column - 1
        for key in (str, plain_title):
            places = [place for place, title in enumerate(self.titles) if key(title) == key(column)]
            if len(places) == 1:
                return places[0]
            if places:
                raise InputError(f"{self.path}: several columns are titled {column!r}; give the column's number")
        existing = ", ".join(title for title in self.titles if title) or "no titles (give column numbers)"
        raise InputError(f"{self.path}: has no column {column!r}; there are: {existing}")

    def is_heading(self, cells: Sequence[str]) -> bool:
        """Whether a line among the data is no data row: fewer than half as many numbers as columns."""
        return 2 * sum(_is_number(self, cell) for cell in cells) < max(len(self.titles), 2)

    def number(self, cell: str) -> float:
        """The number in a cell, NaN if there is none."""
        try:
            return float(cell.replace(",", ".") if self.decimal == "," else cell)
        except ValueError:
            return float("nan")


def find_layout(
    path: object, lines: Sequence[str], known: TextFormat, needed: Sequence[Column], named: Sequence[Column]
) -> TextLayout:
    """Finds the separator in the middle of a file, and titles and first numbers at its head.

    Args:
        path: for messages.
        lines: all lines.
        known: the layout in the column map.
        needed: the columns of numbers; they determine where the data begin.
        named: further requested columns.

    Raises:
        InputError: if a column is missing.
    """
    middle = [line for line in lines[len(lines) // 2 :][:_HEAD] if line.strip()][:_SAMPLE]
    separator = _separator(middle) if known.separator is None else known.separator
    decimal = known.decimal or _decimal(split_cells(path, middle, separator), separator)
    head = [[cell.strip() for cell in row] for row in split_cells(path, lines[: known.skip + _HEAD], separator)]
    blank = TextLayout(path, separator, decimal, (), known.skip)
    row = _title_row(blank, head, known, [*needed, *named])
    titles = () if row is None else tuple(cell.lstrip("#% ") for cell in head[row])
    titled = TextLayout(path, separator, decimal, titles, known.skip if row is None else row + 1)
    places = [titled.place(column) for column in (*needed, *named)][: len(needed)]
    return TextLayout(path, separator, decimal, titles, _first_row(titled, head, places))


def _title_row(blank: TextLayout, head: list[list[str]], known: TextFormat, columns: Sequence[Column]) -> int | None:
    """The line with most of the requested titles; else the last line before the numbers."""
    if known.titles is not None:
        if known.titles > len(head):
            raise InputError(f"{blank.path}: text.titles is line {known.titles}, but the file has {len(head)} lines")
        return known.titles - 1
    requested = {plain_title(column) for column in columns if isinstance(column, str)}
    found = [len(requested.intersection(map(plain_title, cells))) for cells in head]
    if any(found[known.skip :]):
        return known.skip + max(range(len(found) - known.skip), key=lambda row: found[known.skip + row])
    numeric = (row for row in range(known.skip, len(head)) if _share_of_numbers(blank, head[row]) > 0.5)
    before = next(numeric, 0) - 1
    return before if before >= known.skip else None


def _first_row(layout: TextLayout, head: list[list[str]], places: list[int]) -> int:
    """The first line with a number in every needed column; after titles, in any of them: unit rows have none."""
    last = len(head) if not layout.titles else min(len(head), layout.first + _UNIT_ROWS + 1)
    for row in range(layout.first, last):
        found = [place < len(head[row]) and _is_number(layout, head[row][place]) for place in places]
        if any(found) if layout.titles else all(found):
            return row
    return layout.first


def _share_of_numbers(layout: TextLayout, cells: Sequence[str]) -> float:
    return sum(_is_number(layout, cell) for cell in cells) / max(len(cells), 1)


def _is_number(layout: TextLayout, cell: str) -> bool:
    value = layout.number(cell)
    return value == value


def _separator(middle: Sequence[str]) -> str:
    """The first candidate that most lines in the middle of the file contain; else white space."""
    for candidate in _CANDIDATES:
        cut = [line for line in middle if candidate in line and not (candidate == "," and _is_decimal_comma(line))]
        if len(cut) > len(middle) // 2:
            return candidate
    return ""


def _is_decimal_comma(line: str) -> bool:
    """Whether white space separates the line into several numbers, some with a comma."""
    cells = line.split()
    return len(cells) > 1 and all(_COMMA_NUMBER.fullmatch(cell) or _WHOLE.fullmatch(cell) for cell in cells)


def _decimal(middle: Iterable[Sequence[str]], separator: str) -> str:
    if separator == ",":
        return "."
    return "," if any(_COMMA_NUMBER.fullmatch(cell.strip()) for row in middle for cell in row) else "."


def split_cells(path: object, lines: Sequence[str], separator: str) -> Iterator[list[str]]:
    """The cells of each line; the quotes of CSV are honoured.

    Raises:
        InputError: if a quote is never closed.
    """
    if not separator:
        yield from (line.split() for line in lines)
    elif not any('"' in line for line in lines):
        yield from (line.split(separator) for line in lines)
    else:
        try:
            yield from csv.reader(lines, delimiter=separator, skipinitialspace=True)
        except csv.Error as error:
            raise InputError(
                f"{path}: cannot be split into cells ({error}); look for a quote that is not closed"
            ) from error


def plain_title(title: Column) -> str:
    """A title without unit, quotes and case."""
    return _UNIT_IN_TITLE.sub("", str(title).lstrip("#% ").strip("\"' ")).casefold()
