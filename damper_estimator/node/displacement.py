"""One displacement topic: serialised messages in, serialised forces out. Independent of ROS."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from damper_estimator.node.current_check import CurrentCheck
from damper_estimator.node.force_follower import Command, ForceFollower, Rules
from damper_estimator.node.stamp_age import StampAge
from damper_estimator.node.wire import ForcesTemplate, MalformedMessage, names_and_frame, reader_of
from damper_estimator.runtime import EXTRAPOLATING, FIELDS, GOOD, SLOW, STALE, Deployed, Line
from damper_estimator.signals import Channel, DamperSignals

JOINT_STATE = "sensor_msgs/msg/JointState"
_SHORTEST = 12  # bytes of a message that has a stamp
_REACH = slice(FIELDS.index("force_min"), FIELDS.index("dforce_dcurrent") + 1)
_MOST_TEMPLATES = 256


@dataclass(frozen=True, eq=False)
class Estimator:
    """One damper that the node estimates: its channels and its model."""

    name: str
    signals: DamperSignals
    deployed: Deployed


class Arrival(NamedTuple):
    """When and how a message came.

    Attributes:
        now: steady time, s.
        clock: ROS time, ns; ``received``: the same, when the middleware received it.
        suspect: whether its sender is doubtful.
        is_simulated: whether ``clock`` is simulated.
    """

    now: float
    clock: int = 0
    received: int = 0
    suspect: bool = False
    is_simulated: bool = False


class DisplacementInput:
    """Filter and model of all dampers on one topic; final.

    Attributes:
        line: their running state.
        followers: they follow the dampers' desired forces by currents.
        missing: (k,) int64, messages that did not contain the damper.
        last_good: (k,) steady time of the last used sample, s; NaN before the first.
        age: of the stamps on arrival.
        stamp: of the last message, ns.
    """

    def __init__(self, estimators: Sequence[Estimator], rules: Rules) -> None:
        """Raises InputError if a field path does not fit the message type, or limits and safe current do not fit a
        model.
        """
        self.estimators: tuple[Estimator, ...] = ()
        self.followers: tuple[ForceFollower, ...] = ()
        self._rules = rules
        self._leading: list[tuple[int, ForceFollower]] = []
        self._driven: list[tuple[int, CurrentCheck]] = []  # the dampers whose force depends on a current
        self.line = Line()
        self.missing = np.zeros(0, np.int64)
        self.last_good = np.zeros(0)
        self.age = StampAge()
        self._templates: dict[tuple[bytes, bytes], ForcesTemplate] = {}
        self.stamp = 0
        self._frame = b""
        self._grow(estimators)

    def add(self, estimator: Estimator) -> None:
        """Adds a damper; the others' states stay."""
        self._grow([estimator])

    def _grow(self, more: Sequence[Estimator]) -> None:
        channels = [estimator.signals.displacement for estimator in (*self.estimators, *more)]
        self._reader = reader_of("displacement", JOINT_STATE, channels)  # may be refused; nothing has changed then
        self.estimators = (*self.estimators, *more)
        for estimator in more:
            channel = estimator.signals.displacement
            scaling = (channel.scale, channel.offset) if channel.table is None else (1.0, 0.0)
            self.line.add(estimator.name, estimator.deployed, *scaling)
        self.followers += tuple(ForceFollower(estimator.name, estimator.deployed, self._rules) for estimator in more)
        self._leading = [(d, follower) for d, follower in enumerate(self.followers) if not follower.refusal]
        self._driven = [
            (d, follower.current)
            for d, (estimator, follower) in enumerate(zip(self.estimators, self.followers, strict=True))
            if estimator.deployed.memories["command"] is not None
        ]
        self._whole = np.ones(len(self.estimators), bool)
        self._tables = [(d, channel) for d, channel in enumerate(channels) if channel.table is not None]
        self.missing = np.append(self.missing, np.zeros(len(more), np.int64))
        self.last_good = np.append(self.last_good, np.full(len(more), np.nan))
        self._templates.clear()

    def dampers_in(self, data: bytes) -> frozenset[str]:
        """The dampers that one message contains.

        Raises:
            MalformedMessage: if the bytes do not fit the type.
        """
        present = self._reader.place(data).present
        return frozenset(
            estimator.name
            for estimator, is_present in zip(self.estimators, present.tolist(), strict=True)
            if is_present
        )

    @property
    def stamps(self) -> np.ndarray:
        """(k,) int64 ns of the last used sample; 0 before the first."""
        return self.line.records["last"]

    def take(self, data: bytes, arrival: Arrival, max_age: float = 0.0) -> bytes | None:
        """The answer to one message, None if it gives no estimate.

        Args:
            data: serialised JointState.
            arrival: when and how it came.
            max_age: s after its stamp from which on a sample is too old; 0 judges no age.

        Raises:
            MalformedMessage: if the bytes do not fit the type.
        """
        place = self._reader.place(data)
        raw, stamp = place.values(data), place.stamp(data)
        for d, channel in self._tables:
            raw[d] = channel.value(raw[d])
        if not place.is_whole:
            self.missing += ~place.present
        self.stamp = stamp
        is_late = self.age.is_late(stamp, arrival.clock, max_age, arrival.is_simulated)
        if self._driven:
            self._doubt_currents(stamp, max_age > 0.0 and self.age.is_related)
        count = self.line.step(stamp, raw, place.present, is_late or arrival.suspect)
        if not count:
            return None
        self._frame = data[place.frame]
        answered = self.line.output
        for d, follower in self._leading:
            if self.line.is_good(d):
                is_trusted = answered.trusted[0, d] in (GOOD, EXTRAPOLATING)
                answered.numbers[0, _REACH, d] = follower.update(self.line.sample(d), is_trusted)
        chosen = self._whole if count == self._whole.size else self.line.is_good(slice(None))
        self.last_good[chosen] = arrival.now
        return self._template(chosen).message(stamp, answered.numbers[0], answered.status[0], chosen)

    def _doubt_currents(self, stamp: int, judges_age: bool) -> None:
        """Marks on the line the dampers whose reported current cannot be the one that flowed at the sample."""
        fastest = self.age.fastest if judges_age else float("inf")
        for d, current in self._driven:
            self.line.doubted[d] = current.is_contradicted or current.is_ahead(stamp, fastest)

    def due(self, now: float, after: float, rules: Rules) -> list[Command]:
        """Commands that are due without a new desired force; arguments as `trusted`, and the present rules."""
        return [
            follower.command(self.trusted(d, now, after), int(self.stamps[d]), now, rules)
            for d, follower in self._leading
            if self.line.is_good(d) and follower.is_due()
        ]

    def trusted(self, damper: int, now: float, after: float) -> int:
        """Status that decides whether the damper of this number is commanded at the steady time ``now``: that of the
        line, STALE if its last sample is older than ``after`` s or none came.
        """
        fresh = now - self.last_good[damper] <= after
        return int(self.line.output.trusted[0, damper]) if fresh else STALE

    def is_new_structure(self, data: bytes) -> bool:
        """Whether the message differs in names or lengths from the recently read ones."""
        return not self._reader.knows(data)

    @property
    def estimated(self) -> set[str]:
        """Names of the dampers of which any sample has given an estimate."""
        return {name for name, at in zip(self.line.names, self.last_good, strict=True) if np.isfinite(at)}

    def stale(self, now: float, after: float, without: Collection[str] = ()) -> list[bytes]:
        """Messages about the dampers whose input stopped ``after`` s ago or earlier: their last estimate, marked STALE,
        under its stamp. Those ``without`` are left out.
        """
        silent = (now - self.last_good > after) & [name not in without for name in self.line.names]
        if not silent.any():
            return []
        messages = []
        for stamp in np.unique(self.stamps[silent]):
            chosen = silent & (self.stamps == stamp)
            status = np.full(chosen.size, STALE, np.uint8)
            messages.append(self._template(chosen).message(int(stamp), self.line.output.numbers[0], status, chosen))
        return messages

    def rewind(self, now: float) -> None:
        """After the clock was set back to ``now`` s: earlier samples count from now, desired forces are dropped."""
        self.last_good = np.minimum(self.last_good, now)
        for follower in self.followers:
            follower.drop_desired_force()

    def _template(self, chosen: np.ndarray) -> ForcesTemplate:
        key = (self._frame, chosen.tobytes())
        found = self._templates.get(key)
        if found is None:
            if len(self._templates) >= _MOST_TEMPLATES:
                self._templates.clear()
            names = [estimator.name for d, estimator in enumerate(self.estimators) if chosen[d]]
            found = self._templates[key] = ForcesTemplate(names, self._frame.rstrip(b"\0").decode("utf-8", "replace"))
        return found


def names_in(data: bytes) -> list[str]:
    """The names in a JointState.

    Raises:
        MalformedMessage: if the bytes are no JointState.
    """
    if len(data) < _SHORTEST or data[0] != 0 or data[1] > 1:
        raise MalformedMessage("it is not plain CDR")
    return names_and_frame(data)[0]


class AccelerationInput:
    """The accelerometer of one damper, if the signal map fuses it; final."""

    def __init__(self, type_name: str, channel: Channel, line: Line, damper: int) -> None:
        """Of the damper of this number on the line; raises InputError if the field path does not fit the type."""
        self._reader = reader_of("acceleration", type_name, [channel])
        self._channel, self._line, self._damper = channel, line, damper

    def take(self, data: bytes, now: float, received: int) -> None:
        """Passes value and stamp of one message to the line."""
        reading = self._reader.read(data)
        if reading.is_whole:
            arrived = self._line.input
            arrived.acceleration[0, self._damper] = float(self._channel.value(float(reading.values[0])))
            arrived.acceleration_stamp[0, self._damper] = reading.stamp


class SlowInput:
    """A slow channel of one damper, passed to the line as it arrives; final."""

    def __init__(
        self, role: str, type_name: str, channel: Channel, line: Line, damper: int, current: CurrentCheck | None
    ) -> None:
        """Of the damper of this number on the line; ``current`` if the node can command this channel.

        Raises:
            InputError: if the field path does not fit the type.
        """
        self._current = current
        self._reader = reader_of(role, type_name, [channel])
        self._channel, self._line, self._row, self._damper = channel, line, SLOW.index(role), damper

    def take(self, data: bytes, now: float, received: int) -> None:
        """Passes on the value of one message of the steady time ``now`` in s, ``received`` in ns of the clock."""
        reading = self._reader.read(data)
        if reading.is_whole:
            arrived, value = self._line.input, float(self._channel.value(float(reading.values[0])))
            arrived.slow[0, self._row, self._damper] = value
            arrived.received[0, self._row, self._damper] += 1
            if self._current is not None:
                self._current.note_report(value, now, received)
