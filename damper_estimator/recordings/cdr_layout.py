"""The positions of requested numbers in a serialised message (CDR), found by walking its definition once.

All messages whose *structural* bytes (byte order, string and sequence lengths, and the contents of ``name[]`` if an
element is looked up by name) agree have the same layout, so that they can be read as one array. The module ``padding``
judges the bytes after the last field.
"""

import struct
from dataclasses import dataclass

import numpy as np
from rosbags.interfaces import Nodetype

from damper_estimator.recordings.definitions import NUMBERS, Definition
from damper_estimator.recordings.padding import allowance, is_padding

_ENCAPSULATION = 4  # bytes before the payload; alignment counts from there
_WIDE = 8  # bytes of the largest numbers


@dataclass(frozen=True)
class Leaf:
    """``count`` numbers of ``dtype`` at byte ``offset`` of the message."""

    offset: int
    dtype: np.dtype
    count: int = 1

    def read(self, matrix: np.ndarray) -> np.ndarray:
        """The first number of every message (row) of a byte matrix: (n,), a view."""
        return np.ndarray(len(matrix), self.dtype, matrix, self.offset, matrix.strides[:1])

    def write(self, matrix: np.ndarray, column: np.ndarray) -> None:
        """Writes numbers (n,) or (n, count) into every message (row) of a byte matrix."""
        strides = (matrix.strides[0], self.dtype.itemsize)
        target = np.ndarray((len(matrix), self.count), self.dtype, matrix, self.offset, strides)
        target[...] = column if column.ndim == 2 else column[:, None]


@dataclass(frozen=True, eq=False)
class Layout:
    """Leaf per requested path (None if this message lacks it) and the structural bytes that determine the layout.

    Attributes:
        end: bytes up to the end of the last field.
        allowed: bytes of any content that can follow, by ``padding``.
    """

    leaves: tuple[Leaf | None, ...]
    structural: np.ndarray
    template: np.ndarray
    end: int
    allowed: int

    def fits(self, matrix: np.ndarray) -> np.ndarray:
        """Whether each row of ``matrix`` (n, bytes) has this layout, followed only by padding: (n,) bool."""
        spare = matrix.shape[1] - self.end
        if spare < 0:
            return np.zeros(len(matrix), bool)
        fits = (matrix[:, self.structural] == self.template).all(axis=1)
        if spare > self.allowed:
            fits &= ~matrix[:, self.end :].any(axis=1)
        return fits


class MalformedMessage(Exception):
    """The bytes end before the definition, or contain more than it and padding."""


def layout_of(raw: bytes, definition: Definition, request: dict, slots: int) -> Layout:
    """Walks one raw message.

    Args:
        raw: serialised message with its encapsulation header, either byte order.
        definition: its type.
        request: the requested paths, from `request_tree`.
        slots: number of paths.

    Raises:
        MalformedMessage: if the bytes do not fit the definition.
    """
    walk = _Walk(raw, definition, slots)
    walk.message(definition.type, request, ())
    walk.finish()
    structural = np.concatenate([np.arange(*span) for span in walk.spans])
    template = np.frombuffer(raw, np.uint8)[structural]
    return Layout(tuple(walk.leaves), structural, template, walk.position, walk.allowed)


class _Walk:
    """A cursor over one message; final."""

    def __init__(self, raw: bytes, definition: Definition, slots: int) -> None:
        if len(raw) < _ENCAPSULATION or raw[0] != 0 or raw[1] > 1:
            raise MalformedMessage("it is not plain CDR")
        self._raw = raw
        self._definition = definition
        self._order = "<" if raw[1] else ">"
        self._length = struct.Struct(self._order + "I")
        self.position = _ENCAPSULATION
        self._sequences = 0  # of 8-byte numbers
        self.spans = [(0, 2)]
        self.leaves: list[Leaf | None] = [None] * slots

    @property
    def allowed(self) -> int:
        """Bytes of any content that can follow."""
        return allowance(self._sequences)

    def finish(self) -> None:
        """Checks that the definition uses the whole message, except padding."""
        if not is_padding(self._raw, self.position, self.allowed):
            left = len(self._raw) - self.position
            raise MalformedMessage(f"{left} of its {len(self._raw)} bytes are left over, more than padding")

    def message(self, type_name: str, request: dict, names: tuple[str, ...]) -> None:
        fields = self._definition.fields(type_name)
        if any(isinstance(index, str) for branch in request.values() for index in branch):
            names = self._names(fields) or names
        for name, description in fields:
            self._field(description, request.get(name, {}), names)

    def _field(self, description: tuple, request: dict, names: tuple[str, ...]) -> None:
        kind, detail = description
        if kind in (Nodetype.BASE, Nodetype.NAME):
            self._element(description, request.get(None), names)
            return
        element, count = detail
        if kind == Nodetype.SEQUENCE:
            count = self._read_length()
        requested = _by_position(request, names, count)
        if element[0] == Nodetype.BASE and element[1][0] in NUMBERS:
            self._sequences += kind == Nodetype.SEQUENCE and NUMBERS[element[1][0]].itemsize == _WIDE
            self._numbers(element[1][0], count, requested)
            return
        for position in range(count):
            self._element(element, requested.get(position), names)

    def _element(self, description: tuple, request: dict | list | None, names: tuple[str, ...]) -> None:
        kind, detail = description
        if kind == Nodetype.NAME:
            self.message(detail, request or {}, names)
        elif detail[0] in NUMBERS:
            self._numbers(detail[0], 1, {0: request} if request else {})
        elif detail[0] == "string":
            self._skip(self._read_length())
        else:
            raise MalformedMessage(f"fields of type {detail[0]} are not supported")

    def _numbers(self, name: str, count: int, requested: dict) -> None:
        dtype = NUMBERS[name].newbyteorder(self._order)
        if count:  # an empty sequence is not padded to its elements' alignment
            self._align(dtype.itemsize)
        for position, slots in requested.items():
            whole = position is None
            leaf = Leaf(self.position + (0 if whole else position * dtype.itemsize), dtype, count if whole else 1)
            for slot in slots:
                self.leaves[slot] = leaf
        self._skip(count * dtype.itemsize)

    def _names(self, fields: list[tuple]) -> tuple[str, ...]:
        """The entries of this message's ``name[]``, read in advance; () if it has none."""
        start, spans, sequences = self.position, len(self.spans), self._sequences
        names: tuple[str, ...] = ()
        contents = []
        for name, description in fields:
            if name == "name" and _is_string_array(description):
                kind, (_, count) = description
                entries = [
                    self._read_string() for _ in range(self._read_length() if kind == Nodetype.SEQUENCE else count)
                ]
                names = tuple(text for text, _ in entries)
                contents = [span for _, span in entries]
                break
            self._field(description, {}, ())
        self.position, self._sequences = start, sequences
        del self.spans[spans:]  # the actual walk passes here again
        self.spans += contents
        return names

    def _read_string(self) -> tuple[str, tuple[int, int]]:
        size = self._read_length()
        start = self.position
        self._skip(size)
        text = bytes(self._raw[start : self.position]).rstrip(b"\0").decode("utf-8", "replace")
        return text, (start, self.position)

    def _read_length(self) -> int:
        self._align(4)
        start = self.position
        self._skip(4)
        self.spans.append((start, self.position))
        return self._length.unpack_from(self._raw, start)[0]

    def _align(self, size: int) -> None:
        self.position += -(self.position - _ENCAPSULATION) % size

    def _skip(self, size: int) -> None:
        self.position += size
        if self.position > len(self._raw):
            raise MalformedMessage(f"its {len(self._raw)} bytes end too early")


def _is_string_array(description: tuple) -> bool:
    kind, detail = description
    return kind in (Nodetype.ARRAY, Nodetype.SEQUENCE) and detail[0][1][0] == "string"


def _by_position(request: dict, names: tuple[str, ...], count: int) -> dict:
    """Branches by element number; None keeps the whole array; missing elements are dropped."""
    requested: dict = {}
    for index, branch in request.items():
        if index is None:
            requested[None] = branch
            continue
        position = (names.index(index) if index in names else count) if isinstance(index, str) else index
        if position < count:
            requested[position] = _joined(requested.get(position), branch)
    return requested


def _joined(first: dict | list | None, second: dict | list) -> dict | list:
    """Two branches that reach the same element, one by number and one by name."""
    if first is None:
        return second
    if isinstance(first, list):
        return first + second
    merged = dict(first)
    for key, branch in second.items():
        merged[key] = _joined(merged.get(key), branch)
    return merged
