"""Columns of a bench file of any format."""

import gzip
import re
from abc import ABC, abstractmethod
from pathlib import Path

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.recordings.library_errors import explained
from damper_estimator.recordings.mat_file import read_mat

Column = str | int
_EXPRESSION = re.compile(r"\s*([A-Za-z]\w*)((?:\.[A-Za-z]\w*)*)\s*(?:\[\s*(:|\d+)\s*(?:,\s*(:|\d+)\s*)?\])?\s*")


class Table(ABC):
    """Rows and columns of the file ``path``."""

    def __init__(self, path: Path) -> None:
        self.path = path

    @property
    @abstractmethod
    def rows(self) -> int:
        """Number of rows."""

    @abstractmethod
    def numbers(self, column: Column) -> np.ndarray:
        """A column, (rows,) float64; NaN if there is no number.

        Raises:
            InputError: if there is no such column (lists the existing ones).
        """

    @abstractmethod
    def texts(self, column: Column) -> list[str]:
        """A column as text, stripped. Raises InputError as `numbers`."""

    @abstractmethod
    def header_number(self, label: str) -> float:
        """The number in the header line that begins with ``label``.

        Raises:
            InputError: if there is no such line.
        """

    def resolution(self, column: Column) -> float:
        """The smallest step of the column's notation; 0 if numbers are stored in full."""
        return 0.0


class MatTable(Table):
    """Variables of a MAT file (version 5 to 7.2); columns are ``x_F[:,0]``, ``Tout`` or ``data.force``; final."""

    def __init__(self, path: Path, content: bytes) -> None:
        super().__init__(path)
        with explained(path, "save it again, with -v7"):
            self._variables = read_mat(content)
        self._rows = 0

    @property
    def rows(self) -> int:
        return self._rows

    def numbers(self, column: Column) -> np.ndarray:
        found = self._find(column)
        if found.ndim != 1 or found.dtype.kind not in "fiub":
            raise self._wrong(column, f"is {found.dtype} of shape {found.shape}, not one column of numbers")
        if self._rows and len(found) != self._rows:
            raise self._wrong(column, f"has {len(found)} rows, but the columns before it have {self._rows}")
        self._rows = len(found)
        return found.astype(np.float64)

    def texts(self, column: Column) -> list[str]:
        return [str(item).strip() for item in np.atleast_1d(self._find(column)).tolist()]

    def header_number(self, label: str) -> float:
        found = self._find(label)
        if found.size != 1 or found.dtype.kind not in "fiub":
            raise self._wrong(label, "is not a single number")
        return float(found.reshape(-1)[0])

    def _find(self, column: Column) -> np.ndarray:
        match = _EXPRESSION.fullmatch(str(column))
        if not match:
            raise self._wrong(column, 'is no MAT expression; write for example "x_F[:,0]", "Tout" or "data.force"')
        name, fields, *index = match.groups()
        value: object = self._variables
        for step in (name, *fields.split(".")[1:]):
            if not isinstance(value, dict) or step not in value:
                raise self._wrong(column, "does not exist")
            value = value[step]
        array = np.asarray(value)
        places = tuple(slice(None) if part == ":" else int(part) for part in index if part is not None)
        try:
            return array[places[: array.ndim]] if array.ndim == 1 and 0 in places else array[places]
        except IndexError as error:
            raise self._wrong(column, f"reaches beyond the array's shape {array.shape}") from error

    def _wrong(self, column: Column, what: str) -> InputError:
        existing = ", ".join(f"{name} {np.shape(value)}" for name, value in self._variables.items())
        return InputError(f"{self.path}: variable {str(column)!r} {what}; there are: {existing or 'none at all'}")


def file_content(path: Path) -> bytes:
    """The bytes of a file, unpacked if it is gzip.

    Raises:
        InputError: if it is missing, unreadable, damaged or empty.
    """
    with explained(path, "copy it again"):
        content = path.read_bytes()
        if content.startswith(b"\x1f\x8b"):
            try:
                content = gzip.decompress(content)
            except gzip.BadGzipFile as error:
                raise ValueError(str(error)) from error
    if not content.strip():
        raise InputError(f"{path}: empty; export or copy it again")
    return content
