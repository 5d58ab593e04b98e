"""Everything that one set of settings makes the node do with messages: built whole, then swapped in at once. Knows no
ROS."""

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass
from typing import NamedTuple

from damper_estimator.errors import InputError
from damper_estimator.node.commands import Command, Follower
from damper_estimator.node.displacement import (
    JOINT_STATE,
    AccelerationInput,
    Arrival,
    DisplacementInput,
    Estimator,
    HeldInput,
    names_in,
)
from damper_estimator.node.residuals import Comparison, GaugeInput
from damper_estimator.node.roster import MOST_DAMPERS, Roster
from damper_estimator.node.settings import Settings
from damper_estimator.node.wire import reader_of
from damper_estimator.runtime import SLOW
from damper_estimator.signals import Channel, default_signals

DESIRED = "~/desired_force"

SLOW_TYPES = {
    "command": "std_msgs/msg/Float64",
    "temperature": "sensor_msgs/msg/Temperature",
    "pressure": "sensor_msgs/msg/FluidPressure",
    "acceleration": "geometry_msgs/msg/AccelStamped",
}


class Answer(NamedTuple):
    """What one message brings about: forces to publish, commands, whether there are new topics."""

    forces: bytes | None = None
    commands: Sequence[Command] = ()
    has_grown: bool = False


@dataclass(frozen=True, eq=False)
class Displacement:
    """One displacement topic with its dampers, and their comparison with the gauges."""

    source: DisplacementInput
    comparison: Comparison


class Estimation:
    """The running state of all dampers; final.

    Attributes:
        settings: what it was made from.
        roster: the dampers, and the signal map.
        displacement: by topic.
        slow: slow channels by topic: what they are, of which damper.
        topics: type by topic of everything that is to be subscribed; grows where dampers arrive by name.
        named: those of them that somebody named; the others are where a damper of that name would have its channels.
    """

    def __init__(self, settings: Settings, roster: Roster) -> None:
        """Raises InputError where a field path does not fit its message type."""
        self.settings = settings
        self.roster = roster
        self.displacement: dict[str, Displacement] = {}
        self.slow: dict[str, list[tuple[str, str, HeldInput | AccelerationInput]]] = {}
        self.topics: dict[str, str] = {}
        self.named: set[str] = set()
        self._gauges: dict[str, tuple[tuple[str, ...], GaugeInput]] = {}
        by_topic: dict[str, list[Estimator]] = {}
        for one in roster.known:
            by_topic.setdefault(one.signals.displacement.topic, []).append(one)
        if roster.template is not None:
            by_topic = {default_signals("").displacement.topic: []}
        for topic, estimators in by_topic.items():
            source = DisplacementInput(estimators, settings)
            self.displacement[topic] = Displacement(source, _comparison(source, settings, roster))
            self._subscribe(topic, JOINT_STATE, True)
            for one in estimators:
                self._hold(source, one)
        self._measure()

    def changed(self, settings: Settings) -> "Estimation":
        """The same filters and models in their present state, with other settings that leave them as they are.

        Raises:
            InputError: where a driver cannot set the safe current.
        """
        for own in self.displacement.values():
            for follower in own.source.followers:
                follower.check_safe_current(settings.safe_current)
        other = copy(self)
        other.settings = settings
        other.displacement = {
            topic: Displacement(own.source, _comparison(own.source, settings, self.roster))
            for topic, own in self.displacement.items()
        }
        return other

    def _subscribe(self, topic: str, type_name: str, is_named: bool) -> None:
        if is_named:
            self.named.add(topic)
        if self.topics.setdefault(topic, type_name) != type_name:
            raise InputError(
                f"{self.roster.signal_map.where}: topic {topic} is named for a {type_name} and for a "
                f"{self.topics[topic]}; a topic has one type"
            )

    def _hold(self, source: DisplacementInput, one: Estimator) -> None:
        """Slow channels of one damper."""
        damper = source.line.names.index(one.name)
        for role in SLOW:
            channel = getattr(one.signals, role)
            current = source.followers[damper].current if role == "command" else None
            held = HeldInput(role, SLOW_TYPES[role], channel, source.line, damper, current)
            self._hear(one.name, role, channel, held)
        if one.deployed.fusion is not None:
            channel = one.signals.acceleration
            felt = AccelerationInput(SLOW_TYPES["acceleration"], channel, source.line, damper)
            self._hear(one.name, "acceleration", channel, felt)

    def _hear(self, name: str, role: str, channel: Channel, held: HeldInput | AccelerationInput) -> None:
        self.slow.setdefault(channel.topic, []).append((name, role, held))
        self._subscribe(channel.topic, SLOW_TYPES[role], channel.given)

    def _measure(self) -> None:
        """The gauges of all dampers, and the forces desired of them."""
        desired = [Channel(DESIRED, f"effort[{name}]") for name in self.names]
        self._desired = reader_of("desired force", JOINT_STATE, desired)
        self._subscribe(DESIRED, JOINT_STATE, True)
        by_topic: dict[str, list[Estimator]] = {}
        for own in self.displacement.values():
            for one in own.source.estimators:
                by_topic.setdefault(one.signals.force.topic, []).append(one)
        for topic, estimators in by_topic.items():
            gauge = GaugeInput([one.signals for one in estimators])
            self._gauges[topic] = (tuple(one.name for one in estimators), gauge)
            self._subscribe(topic, JOINT_STATE, any(one.signals.force.given for one in estimators))

    @property
    def names(self) -> list[str]:
        """All dampers."""
        return [name for own in self.displacement.values() for name in own.source.line.names]

    @property
    def commanded(self) -> list[str]:
        """The dampers to which currents can be sent."""
        return [own.name for one in self.displacement.values() for own in one.source.followers if not own.refusal]

    def take(self, topic: str, data: bytes, arrival: Arrival) -> Answer:
        """Takes one message, serialised, that came on a topic.

        Raises:
            MalformedMessage: where the bytes do not fit the type.
        """
        own, settings, now = self.displacement.get(topic), self.settings, arrival.now
        if own is None:
            for _, _, held in self.slow.get(topic, ()):
                held.take(data, now, arrival.received)
            if topic in self._gauges:
                self._gauges[topic][1].take(data)
            return Answer(commands=self._ask(data, now)) if topic == DESIRED else Answer()
        grown = self.roster.template is not None and self._admit(own.source, data)
        if topic in self._gauges:
            self._gauges[topic][1].take(data)
        answer = own.source.take(data, arrival, settings.max_age)
        if own.comparison.is_measured:
            own.comparison.collected.keep(own.source.stamp)
        return Answer(answer, own.source.due(now, settings.stale_after, settings), grown)

    def _ask(self, data: bytes, now: float) -> list[Command]:
        """Takes a message of desired forces; the commands that answer them."""
        reading, commands, number = self._desired.read(data), [], 0
        for own in self.displacement.values():
            for d, follower in enumerate(own.source.followers):
                if reading.present[number]:
                    follower.ask(float(reading.values[number]), now)
                    status = own.source.trusted(d, now, self.settings.stale_after)
                    command = follower.command(status, int(own.source.stamps[d]), now, self.settings)
                    commands += [command] if command is not None else []
                number += 1
        return commands

    def safe(self) -> list[Command]:
        """Safe currents for all dampers that were commanded."""
        return self._commands(lambda follower, source, d: follower.safe(int(source.stamps[d]), self.settings))

    def overdue(self, now: float, period: float) -> list[Command]:
        """Commands for those dampers that were commanded, but not in the last ``period`` s before the steady time
        ``now``: their displacement comes slowly or has stopped."""
        after, rules = self.settings.stale_after, self.settings

        def command(follower: Follower, source: DisplacementInput, d: int) -> Command | None:
            if not follower.tally.desired or now - follower.sent_at <= period:
                return None
            return follower.command(source.trusted(d, now, after), int(source.stamps[d]), now, rules)

        return self._commands(command)

    def idle(self) -> list[Command]:
        """What holds for the dampers of which no force was desired yet."""
        return self._commands(lambda follower, source, d: follower.idle(int(source.stamps[d]), self.settings))

    def _commands(self, of: Callable[[Follower, DisplacementInput, int], Command | None]) -> list[Command]:
        """What ``of`` gives for each follower of each input."""
        sources = [own.source for own in self.displacement.values()]
        found = (of(follower, source, d) for source in sources for d, follower in enumerate(source.followers))
        return [command for command in found if command is not None]

    def rewind(self, now: float) -> None:
        """The clock was set back to ``now``, s."""
        for own in self.displacement.values():
            own.source.rewind(now)

    def _admit(self, source: DisplacementInput, data: bytes) -> bool:
        """Takes the dampers that arrive by name."""
        if not source.is_new_structure(data):
            return False
        new = [n for n in dict.fromkeys(names_in(data)) if n and n not in source.line.names]
        for name in new[: max(MOST_DAMPERS - len(source.line.names), 0)]:
            one = self.roster.newcomer(name)
            source.add(one)
            self._hold(source, one)
        if new:
            self._measure()
        return bool(new)

    def compare(self) -> list[bytes]:
        """The residual messages that can now be told."""
        measured = {}
        for names, gauge in self._gauges.values():
            if gauge.has_samples:
                measured |= dict(zip(names, gauge.taken(), strict=True))
        return [message for own in self.displacement.values() for message in own.comparison.compare(measured)]

    def stale(self, now: float) -> list[bytes]:
        """What to say of dampers whose input has stopped, at the steady time ``now``, s."""
        after = self.settings.stale_after
        return [message for own in self.displacement.values() for message in own.source.stale(now, after)]


def _comparison(source: DisplacementInput, settings: Settings, roster: Roster) -> Comparison:
    cutoff = roster.signal_map.gauge_cutoff
    return Comparison(source, cutoff, settings.max_gap, settings.drift_window, settings.drift_factor)
