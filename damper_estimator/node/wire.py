"""Serialised messages to numbers and back, at the rate of the input.

ROS messages are received and published as bytes (CDR): creating a Python object for every message would cost more than
the estimate itself. The positions of the numbers are found by walking the definition once, and remembered as long as
the messages keep their structure (names, lengths of arrays); a message that does not fit its type is refused.
"""

import struct
from collections.abc import Sequence
from operator import itemgetter
from typing import NamedTuple

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.errors import InputError
from damper_estimator.recordings import encode, parse_path
from damper_estimator.recordings.cdr_layout import Layout, MalformedMessage, layout_of
from damper_estimator.recordings.definitions import builtin_schema, definition_of
from damper_estimator.recordings.field_path import check_path, request_tree
from damper_estimator.recordings.padding import is_padding
from damper_estimator.runtime import FIELDS
from damper_estimator.signals import Channel

__all__ = ["ForcesTemplate", "MalformedMessage", "NumbersReader", "Reading"]
FORCES_TYPE = "damper_msgs/msg/DamperForces"
NANOSECONDS = 1_000_000_000
_STAMP = slice(4, 12)
# The numbers of eight bytes in a message begin four bytes off; in a copy shifted by four bytes they are aligned.
_SHIFT = 4
_FRAME = 16  # first byte of the header's frame_id, after its length
_NUMBER = np.dtype("<f8")
_STAMP_PARTS = struct.Struct("<iI")
_FLOAT = struct.Struct("<4sd")
_STAMP_PATHS = ("header.stamp.sec", "header.stamp.nanosec")
_MOST_PLACES = 64  # remembered structures; a publisher of ever new names must not fill the memory


class Reading(NamedTuple):
    """The numbers of one message.

    Attributes:
        stamp: ns; 0 if the type has none.
        values: (k,) one per path, valid where ``present``; the next message can reuse the array.
        present: (k,) bool.
        is_whole: whether all are present.
    """

    stamp: int
    values: np.ndarray
    present: np.ndarray
    is_whole: bool


class Place:
    """The positions of the numbers in messages of one structure; final.

    Attributes:
        present: (k,) bool, which paths these messages contain; ``is_whole``: whether all.
        frame: position of the header's frame_id; empty if the type has none.
    """

    def __init__(self, data: bytes, layout: Layout, width: int, stamped: bool) -> None:
        """``width`` paths, followed by those of the stamp if ``stamped``."""
        leaves = layout.leaves[:width]
        self._end, self._allowed = layout.end, layout.allowed
        self._structure = itemgetter(*_runs(layout.structural))  # one call for all runs
        self._expected = self._structure(data)
        order = "<" if data[1] else ">"
        self._stamp = struct.Struct(f"{order}iI") if stamped else None
        size = struct.unpack_from(f"{order}I", data, _FRAME - 4)[0] if stamped else 0
        self.frame = slice(_FRAME, _FRAME + size)
        self.present = np.array([leaf is not None for leaf in leaves])
        self.is_whole = bool(self.present.all())
        copy = np.zeros(layout.end + _SHIFT, np.uint8)
        self._copy = memoryview(copy)[_SHIFT:]
        found = [leaf for leaf in leaves if leaf is not None]
        first = found[0].offset if found else 0
        is_block = self.is_whole and {leaf.dtype.str for leaf in found} == {"<f8"}
        if is_block and [leaf.offset for leaf in found] == list(range(first, first + 8 * width, 8)):
            self._values, self._loose = np.ndarray(width, _NUMBER, copy, first + _SHIFT), []
        else:
            self._values = np.full(width, np.nan)
            self._loose = [
                (slot, np.ndarray(1, leaf.dtype, copy, leaf.offset + _SHIFT))
                for slot, leaf in enumerate(leaves)
                if leaf is not None
            ]

    def fits(self, data: bytes) -> bool:
        """Whether a message has this structure."""
        if not 0 <= len(data) - self._end <= self._allowed and not is_padding(data, self._end, self._allowed):
            return False
        return self._structure(data) == self._expected

    def values(self, data: bytes) -> np.ndarray:
        """(k,) one per path, NaN if it is not present; reused by the next message."""
        self._copy[:] = data[: self._end]
        for slot, number in self._loose:
            self._values[slot] = number[0]
        return self._values

    def stamp(self, data: bytes) -> int:
        """ns; 0 if the type has none. Raises MalformedMessage if it is no time."""
        if self._stamp is None:
            return 0
        seconds, nanoseconds = self._stamp.unpack_from(data, _STAMP.start)
        if nanoseconds >= NANOSECONDS:
            raise MalformedMessage(f"its stamp has {nanoseconds} ns beside the seconds")
        return seconds * NANOSECONDS + nanoseconds


def _runs(structural: np.ndarray) -> list[slice]:
    """Runs of structural bytes, without the padding between them, which is not initialised and differs."""
    places = np.unique(structural)
    edges = np.flatnonzero(np.diff(places) > 1)
    first = places[np.concatenate([[0], edges + 1])]
    last = places[np.concatenate([edges, [places.size - 1]])]
    return [slice(int(a), int(b) + 1) for a, b in zip(first, last, strict=True)]


class NumbersReader:
    """Reads fields of one built-in message type from serialised messages; final.

    Raises:
        InputError: if the type has no such field, or it is no number.
    """

    def __init__(self, type_name: str, paths: Sequence[str]) -> None:
        self._definition = definition_of(builtin_schema(type_name))
        parsed = [parse_path(path) for path in paths]
        for path in parsed:
            check_path(path, self._definition)
        self._stamped = any(name == "header" for name, _ in self._definition.fields(type_name))
        self._request = request_tree([*parsed, *map(parse_path, _STAMP_PATHS)] if self._stamped else parsed)
        self._width = len(parsed)
        self._places: list[Place] = []

    def knows(self, data: bytes) -> bool:
        """Whether a message of this structure was read recently."""
        return any(place.fits(data) for place in self._places)

    def read(self, data: bytes) -> Reading:
        """The numbers of one message.

        Raises:
            MalformedMessage: if the bytes do not fit the type.
        """
        place = self.place(data)
        return Reading(place.stamp(data), place.values(data), place.present, place.is_whole)

    def place(self, data: bytes) -> Place:
        """The positions of the numbers in one message.

        Raises:
            MalformedMessage: if the bytes do not fit the type.
        """
        for number, place in enumerate(self._places):
            if place.fits(data):
                if number:
                    self._places.insert(0, self._places.pop(number))
                return place
        slots = self._width + (2 if self._stamped else 0)
        layout = layout_of(data, self._definition, self._request, slots)
        place = Place(data, layout, self._width, self._stamped)
        self._places = [place, *self._places[: _MOST_PLACES - 1]]
        return place


def reader_of(role: str, type_name: str, channels: Sequence[Channel]) -> NumbersReader:
    """A reader of the channels on one topic.

    Raises:
        InputError: if a field path does not fit the message type that the node subscribes for this role.
    """
    for channel in channels:
        try:
            NumbersReader(type_name, [channel.field])
        except InputError as error:
            raise InputError(f"{role} on {channel.topic}: {error}") from error
    return NumbersReader(type_name, [channel.field for channel in channels])


def names_and_frame(data: bytes) -> tuple[list[str], str]:
    """``name[]`` and ``header.frame_id`` of a message that begins with a header and names, such as JointState.

    Raises:
        MalformedMessage: if the bytes do not contain them.
    """
    length = struct.Struct(("<" if data[1:2] == b"\x01" else ">") + "I")
    position = _STAMP.stop

    def text() -> str:
        nonlocal position
        position += -(position - 4) % 4
        (size,) = length.unpack_from(data, position)
        start = position + 4
        position = start + size
        if position > len(data):
            raise MalformedMessage(f"its {len(data)} bytes end too early")
        return data[start:position].rstrip(b"\0").decode("utf-8", "replace")

    try:
        frame = text()
        position += -(position - 4) % 4
        (count,) = length.unpack_from(data, position)
        position += 4
        if count > len(data):
            raise MalformedMessage(f"it announces {count} names in {len(data)} bytes")
        return [text() for _ in range(count)], frame
    except struct.error as error:
        raise MalformedMessage(f"its {len(data)} bytes end too early") from error


def float_message(value: float) -> bytes:
    """A serialised ``std_msgs/Float64``."""
    return _FLOAT.pack(b"\0\1\0\0", value)


class ForcesTemplate:
    """A serialised ``DamperForces`` of given dampers, to be filled; final."""

    def __init__(self, names: Sequence[str], frame: str) -> None:
        k = len(names)
        definition = definition_of(builtin_schema(FORCES_TYPE))
        arrays = {field: np.full((1, k), np.nan) for field in FIELDS} | {"status": np.zeros((1, k), np.uint8)}
        (plain,) = encode(FORCES_TYPE, 1, {"header.frame_id": frame, "name": list(names), **arrays})
        buffer = np.zeros(len(plain) + _SHIFT, np.uint8)
        self._message = memoryview(buffer)[_SHIFT:]
        self._message[:] = plain
        paths = [parse_path(f"{field}[0]") for field in (*FIELDS, "status")]
        leaves = layout_of(plain, definition, request_tree(paths), len(paths)).leaves
        first, second = leaves[0].offset, leaves[1].offset
        self._numbers = np.ndarray((len(FIELDS), k), _NUMBER, buffer, first + _SHIFT, (second - first, 8))
        self._status = np.ndarray((k,), np.uint8, buffer, leaves[-1].offset + _SHIFT)

    def message(self, stamp: int, numbers: np.ndarray, status: np.ndarray, chosen: np.ndarray) -> bytes:
        """The message: ``stamp`` in ns, ``numbers`` (9, n) by FIELDS and ``status`` (n,), of which the
        ``chosen`` (n,) are its k dampers.
        """
        _STAMP_PARTS.pack_into(self._message, _STAMP.start, *divmod(stamp, NANOSECONDS))
        _fill(numbers, status, chosen, self._numbers, self._status)
        return bytes(self._message)


@compiled
def _fill(numbers, status, chosen, filled_numbers, filled_status):
    """Copies the chosen columns; with numpy each copy would take as long as this function."""
    j = 0
    for d in range(chosen.size):
        if chosen[d]:
            for field in range(numbers.shape[0]):
                filled_numbers[field, j] = numbers[field, d]
            filled_status[j] = status[d]
            j += 1
