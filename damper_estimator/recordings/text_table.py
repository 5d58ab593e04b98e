"""CSV and logger text as columns."""

import re
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.recordings.bench_table import Column, Table
from damper_estimator.recordings.column_map import TextFormat
from damper_estimator.recordings.text_layout import TextLayout, find_layout

_NUMBER_IN_TEXT = re.compile(r"[-+]?\d+(?:[.,]\d+)?(?:[eE][-+]?\d+)?")
_BLOCK = 50_000  # rows converted together
_SAMPLE = 40


class TextTable(Table):
    """A text file of columns; final. Only the requested columns are kept.

    Args:
        path: for messages.
        content: the file's bytes, unpacked.
        known: known part of the layout.
        needed: columns of numbers.
        named: columns of text.

    Raises:
        InputError: if a column is missing, or no rows of numbers are found.
    """

    def __init__(
        self, path: Path, content: bytes, known: TextFormat, needed: Sequence[Column], named: Sequence[Column] = ()
    ) -> None:
        super().__init__(path)
        lines, self._several = decoded(content).splitlines(), known.blocks
        self._layout = find_layout(path, lines, known, needed, named)
        self._header = lines[: self._layout.first]
        self._read(lines[self._layout.first :], set(needed), set(named))
        if not self._rows:
            raise InputError(f"{path}: has no rows of numbers; check text.skip and text.titles in the column map")

    @property
    def rows(self) -> int:
        return self._rows

    def numbers(self, column: Column) -> np.ndarray:
        return self._numbers[column]

    def texts(self, column: Column) -> list[str]:
        return self._texts[column]

    def header_number(self, label: str) -> float:
        label = label.strip().casefold()
        for line in (line.strip() for line in self._header):
            match = _NUMBER_IN_TEXT.search(line, len(label)) if line.casefold().startswith(label) else None
            if match:
                return float(match.group().replace(",", "."))
        raise InputError(
            f"{self.path}: no header line begins with {label!r} and contains a number; give time.rate in Hz"
        )

    def resolution(self, column: Column) -> float:
        places = re.compile(re.escape(self._layout.decimal) + r"(\d+)")
        digits = [len(match.group(1)) for cell in self._samples[column] if (match := places.search(cell))]
        exponents = any("e" in cell.lower() for cell in self._samples[column])
        return 0.0 if exponents else 10.0 ** -max(digits, default=0)

    def _read(self, lines: Sequence[str], needed: set[Column], named: set[Column]) -> None:
        place = {column: self._layout.place(column) for column in needed | named}
        numbers: dict[Column, list[np.ndarray]] = {column: [] for column in needed}
        self._texts: dict[Column, list[str]] = {column: [] for column in named}
        self._samples: dict[Column, list[str]] = {}
        self._rows, width = 0, 0
        for rows in _blocks(self._layout, lines, self._several):
            self._rows += len(rows)
            width = max(width, max(map(len, rows)))
            for column in needed | named:
                cells = [row[place[column]] if place[column] < len(row) else "" for row in rows]
                self._samples.setdefault(column, cells[:_SAMPLE])
                if column in needed:
                    numbers[column].append(_numbers(self._layout, cells))
                if column in named:
                    self._texts[column] += cells
        beyond = [str(column) for column in place if isinstance(column, int) and column > width]
        if self._rows and beyond:
            raise InputError(f"{self.path}: has no column {', '.join(beyond)}; there are {width} (counted from 1)")
        self._numbers = {column: np.concatenate([*parts, np.empty(0)]) for column, parts in numbers.items()}


def _blocks(layout: TextLayout, lines: Sequence[str], several: bool) -> Iterator[list[list[str]]]:
    rows = (row for row in layout.split(lines) if any(row) and not (several and layout.is_heading(row)))
    while block := list(islice(rows, _BLOCK)):
        yield block


def _numbers(layout: TextLayout, cells: list[str]) -> np.ndarray:
    try:
        return np.array([cell.replace(",", ".") for cell in cells] if layout.decimal == "," else cells, np.float64)
    except ValueError:
        return np.array([layout.number(cell) for cell in cells])


def decoded(content: bytes) -> str:
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        return content.decode("utf-16", "replace")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("cp1252", "replace")
