"""One displacement topic: serialised messages in, serialised forces out. Knows no ROS."""

import struct
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.control.inverse import HORIZON, LEAD
from damper_estimator.model.estimator import FIELDS, STALE, Deployed
from damper_estimator.model.live_line import SLOW, LiveLine
from damper_estimator.node.commands import Follower, Rules
from damper_estimator.node.wire import ForcesTemplate, MalformedMessage, names_and_frame, reader_of
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
        followers: what turns wishes for them into currents.
        missing: (k,) int64, messages that did not hold the damper.
        last_good: (k,) steady time of the last sample that was used, s; NaN before the first.
        stamp: of the last message, ns.
    """

    def __init__(self, estimators: Sequence[Estimator], horizon: float = HORIZON, lead: float = LEAD) -> None:
        """``horizon`` and ``lead`` in s, of the inverse models.

        Raises:
            InputError: where a field path does not fit the message type.
        """
        self.estimators: tuple[Estimator, ...] = ()
        self.followers: tuple[Follower, ...] = ()
        self._inverse = (horizon, lead)
        self._leading: list[tuple[int, Follower]] = []
        self.line = LiveLine()
        self.missing = np.zeros(0, np.int64)
        self.last_good = np.zeros(0)
        self._templates: dict[tuple[bytes, bytes], ForcesTemplate] = {}
        self.stamp = 0
        self._stamp = bytes(8)
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
        self.followers += tuple(Follower(own.name, own.deployed, own.signals.command, *self._inverse) for own in more)
        self._leading = [(d, own) for d, own in enumerate(self.followers) if not own.refusal]
        channels = [one.signals.displacement for one in self.estimators]
        self._reader = reader_of("displacement", JOINT_STATE, channels)
        self._scale = np.array([channel.scale for channel in channels])
        self._offset = np.array([channel.offset for channel in channels])
        self._tables = [(d, channel) for d, channel in enumerate(channels) if channel.table is not None]
        self._values = np.zeros(len(channels))
        self.missing = np.append(self.missing, np.zeros(len(more), np.int64))
        self.last_good = np.append(self.last_good, np.full(len(more), np.nan))
        self._templates.clear()

    def take(self, data: bytes, now: float) -> bytes | None:
        """The answer to one message, None where it gives no estimate; ``now`` is the steady time in s.

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
        count = self.line.step(reading.stamp, values, reading.present)
        if not count:
            return None
        self._stamp, self._frame = _head(data)
        for d, follower in self._leading:
            if self.line.is_good(d):
                self.line.estimates[_REACH, d] = follower.look(self.line.sample(d))
        if count == values.size:
            self.last_good[:] = now
            return self._template(None).message(self._stamp, self.line.estimates, self.line.status)
        chosen = self.line.is_good(slice(None))
        self.last_good[chosen] = now
        return self._template(chosen).message(self._stamp, self.line.estimates[:, chosen], self.line.status[chosen])

    def due(self, now: float, after: float, rules: Rules) -> list[tuple[str, bytes]]:
        """Commands that the last message brings about by itself, by damper; arguments as `status`, and the rules."""
        return [
            (own.name, own.command(self.status(d, now, after), now, rules))
            for d, own in self._leading
            if self.line.is_good(d) and own.is_due()
        ]

    def status(self, damper: int, now: float, after: float) -> int:
        """Of the damper of this number at the steady time ``now``; STALE where its last sample is older than
        ``after`` s."""
        return int(self.line.status[damper]) if now - self.last_good[damper] <= after else STALE

    def is_new_structure(self, data: bytes) -> bool:
        """Whether the message differs in names or lengths from those that were read lately."""
        return not self._reader.knows(data)

    def stale(self, now: float, after: float) -> bytes | None:
        """What to say of the dampers whose input stopped ``after`` s ago or earlier: their last estimate, marked STALE,
        under the last stamp; None where there are none."""
        silent = now - self.last_good > after
        if not silent.any():
            return None
        status = np.full(int(np.count_nonzero(silent)), STALE, np.uint8)
        return self._template(silent).message(self._stamp, self.line.estimates[:, silent], status)

    def _template(self, chosen: np.ndarray | None) -> ForcesTemplate:
        key = (self._frame, b"" if chosen is None else chosen.tobytes())
        found = self._templates.get(key)
        if found is None:
            if len(self._templates) >= _MOST_TEMPLATES:
                self._templates.clear()
            names = [one.name for d, one in enumerate(self.estimators) if chosen is None or chosen[d]]
            found = self._templates[key] = ForcesTemplate(names, self._frame.rstrip(b"\0").decode("utf-8", "replace"))
        return found


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

    def __init__(self, type_name: str, channel: Channel, line: LiveLine, damper: int) -> None:
        """Of the damper of this number on the line; raises InputError where the field path does not fit the type."""
        self._reader = reader_of("acceleration", type_name, [channel])
        self._channel, self._line, self._damper = channel, line, damper

    def take(self, data: bytes, _: float) -> None:
        """Holds value and stamp of one message."""
        reading = self._reader.read(data)
        if reading.is_whole:
            self._line.felt[self._damper] = float(self._channel.value(float(reading.values[0])))
            self._line.felt_at[self._damper] = reading.stamp


class HeldInput:
    """A slow channel of one damper: its value reaches the line as it arrives; final."""

    def __init__(self, role: str, type_name: str, channel: Channel, line: LiveLine, damper: int) -> None:
        """Of the damper of this number on the line; raises InputError where the field path does not fit the type."""
        self._reader = reader_of(role, type_name, [channel])
        self._channel, self._line, self._row, self._damper = channel, line, SLOW.index(role), damper
        self.last: float | None = None

    def take(self, data: bytes, now: float) -> None:
        """Holds the value of one message."""
        reading = self._reader.read(data)
        if reading.is_whole:
            self._line.held[self._row, self._damper] = float(self._channel.value(float(reading.values[0])))
            self.last = now
