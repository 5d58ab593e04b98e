"""One displacement topic: serialised messages in, serialised forces out. Knows no ROS."""

import struct
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.node.commands import Command, Follower, Rules
from damper_estimator.node.stamp_age import StampAge
from damper_estimator.node.wire import NANOSECONDS, ForcesTemplate, MalformedMessage, names_and_frame, reader_of
from damper_estimator.runtime import FIELDS, SLOW, STALE, Deployed, Line
from damper_estimator.signals import Channel, DamperSignals

JOINT_STATE = "sensor_msgs/msg/JointState"
_STAMP = slice(4, 12)
_REACH = slice(FIELDS.index("force_min"), FIELDS.index("dforce_dcurrent") + 1)
_MOST_TEMPLATES = 256


@dataclass(frozen=True, eq=False)
class Estimator:
    """One damper as the node estimates it: where its channels are, and what runs."""

    name: str
    signals: DamperSignals
    deployed: Deployed


class DisplacementInput:
    """Filter and model of all dampers on one topic; final.

    Attributes:
        line: their running state.
        followers: what turns desired forces for them into currents.
        missing: (k,) int64, messages that did not hold the damper.
        last_good: (k,) steady time of the last sample that was used, s; NaN before the first.
        stamps: (k,) int64 ns of the last sample that was used; 0 before the first.
        age: of the stamps on arrival.
        stamp: of the last message, ns.
    """

    def __init__(self, estimators: Sequence[Estimator], rules: Rules) -> None:
        """Raises InputError where a field path does not fit the message type, or limits and safe current do not fit a
        model."""
        self.estimators: tuple[Estimator, ...] = ()
        self.followers: tuple[Follower, ...] = ()
        self._rules = rules
        self._leading: list[tuple[int, Follower]] = []
        self.line = Line()
        self.missing = np.zeros(0, np.int64)
        self.last_good = np.zeros(0)
        self.age = StampAge()
        self.stamps = np.zeros(0, np.int64)
        self._templates: dict[tuple[bytes, bytes], ForcesTemplate] = {}
        self.stamp = 0
        self._frame = b""
        for one in estimators:
            self.line.add(one.name, one.deployed)
        self._grow(estimators)

    def add(self, one: Estimator) -> None:
        """Takes one more damper; the others' states stay."""
        self.line.add(one.name, one.deployed)
        self._grow([one])

    def _grow(self, more: Sequence[Estimator]) -> None:
        self.estimators = (*self.estimators, *more)
        self.followers += tuple(Follower(one.name, one.deployed, self._rules) for one in more)
        self._leading = [(d, follower) for d, follower in enumerate(self.followers) if not follower.refusal]
        channels = [one.signals.displacement for one in self.estimators]
        self._reader = reader_of("displacement", JOINT_STATE, channels)
        self._scale = np.array([channel.scale for channel in channels])
        self._offset = np.array([channel.offset for channel in channels])
        self._tables = [(d, channel) for d, channel in enumerate(channels) if channel.table is not None]
        self._values = np.zeros(len(channels))
        self.missing = np.append(self.missing, np.zeros(len(more), np.int64))
        self.last_good = np.append(self.last_good, np.full(len(more), np.nan))
        self.stamps = np.append(self.stamps, np.zeros(len(more), np.int64))
        self._templates.clear()

    def held(self, data: bytes) -> frozenset[str]:
        """The dampers that one message holds.

        Raises:
            MalformedMessage: where the bytes do not fit the type.
        """
        present = self._reader.present(data)
        return frozenset(one.name for one, there in zip(self.estimators, present.tolist(), strict=True) if there)

    def take(
        self, data: bytes, now: float, clock: int = 0, max_age: float = 0.0, suspect: bool = False
    ) -> bytes | None:
        """The answer to one message, None where it gives no estimate.

        Args:
            data: serialised JointState.
            now: steady time, s.
            clock: ROS time, ns, against which the age of the stamp is judged.
            max_age: s, 0 to judge no age.
            suspect: whether the sender is in doubt.

        Raises:
            MalformedMessage: where the bytes do not fit the type.
        """
        reading = self._reader.read(data)
        values = np.multiply(reading.values, self._scale, out=self._values)
        values += self._offset
        for d, channel in self._tables:
            values[d] = channel.value(reading.values[d])
        if not reading.is_whole:
            self.missing += ~reading.present
        self.stamp = reading.stamp
        is_late = self.age.is_late(reading.stamp, clock, max_age)
        count = self.line.step(reading.stamp, values, reading.present, suspect or is_late)
        if not count:
            return None
        stamp, self._frame = _head(data)
        answered = self.line.answered
        numbers, status = answered.numbers[0], answered.status[0]
        for d, follower in self._leading:
            if self.line.is_good(d):
                numbers[_REACH, d] = follower.look(self.line.sample(d))
        if count == values.size:
            self.last_good[:], self.stamps[:] = now, reading.stamp
            return self._template(None).message(stamp, numbers, status)
        chosen = self.line.is_good(slice(None))
        self.last_good[chosen], self.stamps[chosen] = now, reading.stamp
        return self._template(chosen).message(stamp, numbers[:, chosen], status[chosen])

    def due(self, now: float, after: float, rules: Rules) -> list[Command]:
        """Commands that the last message brings about by itself; arguments as `trusted`, and the present rules."""
        return [
            follower.command(self.trusted(d, now, after), int(self.stamps[d]), now, rules)
            for d, follower in self._leading
            if self.line.is_good(d) and follower.is_due()
        ]

    def trusted(self, damper: int, now: float, after: float) -> int:
        """Status by which the damper of this number may be commanded at the steady time ``now``: that of the line,
        STALE where its last sample is older than ``after`` s or none came."""
        fresh = now - self.last_good[damper] <= after
        return int(self.line.answered.trusted[0, damper]) if fresh else STALE

    def is_new_structure(self, data: bytes) -> bool:
        """Whether the message differs in names or lengths from those that were read lately."""
        return not self._reader.knows(data)

    def stale(self, now: float, after: float) -> list[bytes]:
        """What to say of the dampers whose input stopped ``after`` s ago or earlier: their last estimate, marked STALE,
        under its stamp."""
        silent = now - self.last_good > after
        if not silent.any():
            return []
        messages = []
        for stamp in np.unique(self.stamps[silent]):
            chosen = silent & (self.stamps == stamp)
            status = np.full(int(np.count_nonzero(chosen)), STALE, np.uint8)
            numbers = self.line.answered.numbers[0][:, chosen]
            messages.append(self._template(chosen).message(_stamp_bytes(int(stamp)), numbers, status))
        return messages

    def rewind(self, now: float) -> None:
        """After the clock was set back to ``now`` s: what was received counts from now, desired forces are dropped."""
        self.last_good = np.minimum(self.last_good, now)
        for follower in self.followers:
            follower.drop_desired_force()

    def _template(self, chosen: np.ndarray | None) -> ForcesTemplate:
        key = (self._frame, b"" if chosen is None else chosen.tobytes())
        found = self._templates.get(key)
        if found is None:
            if len(self._templates) >= _MOST_TEMPLATES:
                self._templates.clear()
            names = [one.name for d, one in enumerate(self.estimators) if chosen is None or chosen[d]]
            found = self._templates[key] = ForcesTemplate(names, self._frame.rstrip(b"\0").decode("utf-8", "replace"))
        return found


def _stamp_bytes(stamp: int) -> bytes:
    seconds, nanoseconds = divmod(stamp, NANOSECONDS)
    return struct.pack("<iI", seconds, nanoseconds)


def _head(data: bytes) -> tuple[bytes, bytes]:
    """Stamp (8 bytes, little endian) and frame of a message that the reader accepted."""
    if data[1]:
        size = int.from_bytes(data[12:16], "little")
        return data[_STAMP], data[16 : 16 + size]
    size = int.from_bytes(data[12:16], "big")
    return struct.pack("<iI", *struct.unpack_from(">iI", data, _STAMP.start)), data[16 : 16 + size]


def names_in(data: bytes) -> list[str]:
    """The names in a JointState.

    Raises:
        MalformedMessage: where the bytes are none.
    """
    if len(data) < _STAMP.stop or data[0] != 0 or data[1] > 1:
        raise MalformedMessage("it is not plain CDR")
    return names_and_frame(data)[0]


class AccelerationInput:
    """The accelerometer of one damper, where it is taken in; final."""

    def __init__(self, type_name: str, channel: Channel, line: Line, damper: int) -> None:
        """Of the damper of this number on the line; raises InputError where the field path does not fit the type."""
        self._reader = reader_of("acceleration", type_name, [channel])
        self._channel, self._line, self._damper = channel, line, damper

    def take(self, data: bytes) -> None:
        """Holds value and stamp of one message."""
        reading = self._reader.read(data)
        if reading.is_whole:
            arrived = self._line.arrived
            arrived.felt[0, self._damper] = float(self._channel.value(float(reading.values[0])))
            arrived.felt_at[0, self._damper] = reading.stamp


class HeldInput:
    """A slow channel of one damper: its value reaches the line as it arrives; final."""

    def __init__(self, role: str, type_name: str, channel: Channel, line: Line, damper: int) -> None:
        """Of the damper of this number on the line; raises InputError where the field path does not fit the type."""
        self._reader = reader_of(role, type_name, [channel])
        self._channel, self._line, self._row, self._damper = channel, line, SLOW.index(role), damper

    def take(self, data: bytes) -> None:
        """Holds the value of one message."""
        reading = self._reader.read(data)
        if reading.is_whole:
            arrived = self._line.arrived
            arrived.slow[0, self._row, self._damper] = float(self._channel.value(float(reading.values[0])))
            arrived.heard[0, self._row, self._damper] += 1
