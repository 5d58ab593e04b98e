"""Messages as bytes (CDR), packed and read by hand: the messages of the soak must not depend on the code under test."""

import struct
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

SECOND = 1_000_000_000


@dataclass
class States:
    """A message of joint states in transit, which faults can change.

    Attributes:
        names, values: of the dampers; ``values`` can be shorter.
        stamp: ns.
        raw: bytes to be sent instead; ``fits`` is then whether they are a message of this type.
        is_big: most significant byte first.
        padding: bytes after the message.
        foreign: whether another publisher sends it.
        truth, undisturbed: (k,) N, forces of the dampers at its measurement, and of the models without faults.
    """

    names: list[str]
    values: list[float]
    stamp: int
    raw: bytes | None = None
    fits: bool = True
    is_big: bool = False
    padding: int = 0
    foreign: bool = False
    truth: np.ndarray | None = None
    undisturbed: np.ndarray | None = None

    def data(self) -> bytes:
        """Serialised, the values as positions."""
        if self.raw is not None:
            return self.raw
        return joint_state(self.names, self.stamp, self.values, (), self.is_big) + bytes(self.padding)


def joint_state(
    names: Sequence[str], stamp: int, position: Sequence[float], effort: Sequence[float] = (), is_big: bool = False
) -> bytes:
    """A ``sensor_msgs/JointState``."""
    order = ">" if is_big else "<"
    body = bytearray(_header(stamp, order))
    _pad(body, 4)
    body += struct.pack(order + "I", len(names))
    for name in names:
        _pad(body, 4)
        text = name.encode() + b"\0"
        body += struct.pack(order + "I", len(text)) + text
    for values in (position, (), effort):
        _pad(body, 4)
        body += struct.pack(order + "I", len(values))
        if values:
            _pad(body, 8)
            body += struct.pack(f"{order}{len(values)}d", *values)
    return (b"\0\0\0\0" if is_big else b"\0\1\0\0") + bytes(body)


def stamped(stamp: int, *values: float) -> bytes:
    """A message of a header and numbers: Temperature and FluidPressure (2), AccelStamped (6)."""
    body = bytearray(_header(stamp, "<"))
    _pad(body, 8)
    return b"\0\1\0\0" + bytes(body) + struct.pack(f"<{len(values)}d", *values)


def number(value: float) -> bytes:
    """A ``std_msgs/Float64``."""
    return struct.pack("<4sd", b"\0\1\0\0", value)


def number_in(data: bytes) -> float:
    """The number in a ``std_msgs/Float64``."""
    return struct.unpack_from("<d", data, 4)[0]


@dataclass(frozen=True)
class Forces:
    """The judged fields of a ``damper_msgs/DamperForces``."""

    stamp: int
    names: list[str]
    force: tuple[float, ...]
    stddev: tuple[float, ...]
    status: bytes


@dataclass(frozen=True)
class Commands:
    """The judged fields of a ``damper_msgs/DamperCommand``."""

    stamp: int
    sequence: int
    names: list[str]
    current: tuple[float, ...]
    valid: bytes


def commands_in(data: bytes) -> Commands:
    """Parses a ``damper_msgs/DamperCommand``."""
    walk = _Walk(data)
    stamp = walk.stamp()
    walk.text()
    (sequence,) = walk.numbers("Q", 1)
    names = [walk.text() for _ in range(walk.count())]
    current, _, _ = (walk.numbers("d", walk.count()) for _ in range(3))
    walk.bytes(walk.count())
    return Commands(stamp, sequence, names, current, walk.bytes(walk.count()))


def forces_in(data: bytes) -> Forces:
    """Parses a ``damper_msgs/DamperForces``."""
    walk = _Walk(data)
    stamp = walk.stamp()
    walk.text()
    names = [walk.text() for _ in range(walk.count())]
    arrays = [walk.numbers("d", walk.count()) for _ in range(9)]
    return Forces(stamp, names, arrays[3], arrays[4], walk.bytes(walk.count()))


class _Walk:
    """Reads a serialised message in sequence, least significant byte first; final."""

    def __init__(self, data: bytes) -> None:
        self._body, self._at = data[4:], 0

    def stamp(self) -> int:
        """ns."""
        (seconds,), (nanoseconds,) = self.numbers("i", 1), self.numbers("I", 1)
        return seconds * SECOND + nanoseconds

    def numbers(self, kind: str, count: int) -> tuple:
        """``count`` numbers of one kind (as in `struct`), aligned."""
        size = struct.calcsize(kind)
        self._at += -self._at % size if count else 0
        values = struct.unpack_from(f"<{count}{kind}", self._body, self._at)
        self._at += size * count
        return values

    def count(self) -> int:
        """The length of a sequence."""
        return self.numbers("I", 1)[0]

    def bytes(self, count: int) -> bytes:
        """``count`` bytes."""
        self._at += count
        return self._body[self._at - count : self._at]

    def text(self) -> str:
        """A string without its terminator."""
        return self.bytes(self.count())[:-1].decode()


def _header(stamp: int, order: str) -> bytes:
    return struct.pack(order + "iII", stamp // SECOND, stamp % SECOND, 1) + b"\0"


def _pad(body: bytearray, size: int) -> None:
    body += bytes(-len(body) % size)
