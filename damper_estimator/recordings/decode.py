"""Numbers from many serialised messages at once."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.recordings.cdr_layout import Layout, layout_of
from damper_estimator.recordings.definitions import Definition
from damper_estimator.recordings.field_path import FieldPath, check_path, parse_path, request_tree
from damper_estimator.recordings.raw_messages import gathered

_STAMP = ("header.stamp.sec", "header.stamp.nanosec")
_REMEMBERED_LAYOUTS = 64  # with more layouts a search does not pay: every message is walked
NANOSECONDS = 1_000_000_000


@dataclass(frozen=True, eq=False)
class Numbers:
    """The result of a decoder: ``stamp`` (n,) int64 ns or None, ``values`` (n, k) float64, ``present`` (n, k) bool."""

    stamp: np.ndarray | None
    values: np.ndarray
    present: np.ndarray


class Decoder:
    """Reads fields of one message type; final.

    The layout of the first message is found by walking it; all messages that share its structure are read as one array
    per length (padding makes lengths differ), the others by their own layouts.

    Raises:
        InputError: if a path is malformed or the type lacks it.
    """

    def __init__(self, definition: Definition, paths: Iterable[str]) -> None:
        parsed = [parse_path(path) for path in paths]
        for path in parsed:
            check_path(path, definition)
        self._definition = definition
        self._width = len(parsed)
        stamp = _stamp_paths(definition)
        self._stamped = bool(stamp)
        self._request = request_tree([*parsed, *stamp])
        self._slots = len(parsed) + len(stamp)
        self._layouts: list[Layout] = []

    def decode(self, data: bytes, start: np.ndarray, length: np.ndarray) -> Numbers:
        """Reads the messages ``data[start[i] : start[i] + length[i]]``.

        Raises:
            MalformedMessage: if the bytes of a message do not fit its type.
        """
        count = len(start)
        result = Numbers(
            np.empty(count, np.int64) if self._stamped else None,
            np.full((count, self._width), np.nan),
            np.zeros((count, self._width), bool),
        )
        buffer = np.frombuffer(data, np.uint8)
        order = np.argsort(length, kind="stable")
        for rows in np.split(order, np.flatnonzero(np.diff(length[order])) + 1):
            if len(rows):
                self._decode_equal(gathered(buffer, start[rows], int(length[rows[0]])), rows, result)
        return result

    def _decode_equal(self, matrix: np.ndarray, rows: np.ndarray, result: Numbers) -> None:
        for layout in self._layouts:
            if not len(rows):
                return
            matrix, rows = self._decode_fitting(layout, matrix, rows, result)
        while len(rows):
            layout = layout_of(matrix[0].tobytes(), self._definition, self._request, self._slots)
            if len(self._layouts) < _REMEMBERED_LAYOUTS:
                self._layouts.append(layout)
                matrix, rows = self._decode_fitting(layout, matrix, rows, result)
            else:
                self._store(layout, matrix[:1], rows[:1], result)
                matrix, rows = matrix[1:], rows[1:]

    def _decode_fitting(
        self, layout: Layout, matrix: np.ndarray, rows: np.ndarray, result: Numbers
    ) -> tuple[np.ndarray, np.ndarray]:
        fits = layout.fits(matrix)
        if not fits.all():
            if fits.any():
                self._store(layout, matrix[fits], rows[fits], result)
            return matrix[~fits], rows[~fits]
        self._store(layout, matrix, rows, result)
        return matrix[:0], rows[:0]

    def _store(self, layout: Layout, matrix: np.ndarray, rows: np.ndarray, result: Numbers) -> None:
        for slot, leaf in enumerate(layout.leaves[: self._width]):
            if leaf is not None:
                result.values[rows, slot] = leaf.read(matrix)
                result.present[rows, slot] = True
        if result.stamp is not None:
            seconds, nanoseconds = (leaf.read(matrix).astype(np.int64) for leaf in layout.leaves[self._width :])
            result.stamp[rows] = seconds * NANOSECONDS + nanoseconds


def _stamp_paths(definition: Definition) -> list[FieldPath]:
    """The parts of ``header.stamp``; none if the type has none."""
    paths = [parse_path(text) for text in _STAMP]
    try:
        for path in paths:
            check_path(path, definition)
    except InputError:
        return []
    return paths
