"""The processing of messages for one set of settings: built completely, then swapped in at once. Independent of ROS."""

from collections.abc import Callable, Collection, Sequence
from copy import copy
from dataclasses import dataclass
from typing import NamedTuple

from damper_estimator.errors import InputError
from damper_estimator.node.displacement import (
    JOINT_STATE,
    AccelerationInput,
    Arrival,
    DisplacementInput,
    Estimator,
    SlowInput,
    names_in,
)
from damper_estimator.node.force_follower import Command, ForceFollower
from damper_estimator.node.residuals import Comparison, GaugeInput
from damper_estimator.node.roster import MOST_DAMPERS, Roster
from damper_estimator.node.settings import Settings
from damper_estimator.node.wire import reader_of
from damper_estimator.runtime import SLOW
from damper_estimator.signals import Channel, default_signals, named_element

DESIRED = "~/desired_force"

SLOW_TYPES = {
    "command": "std_msgs/msg/Float64",
    "temperature": "sensor_msgs/msg/Temperature",
    "pressure": "sensor_msgs/msg/FluidPressure",
    "acceleration": "geometry_msgs/msg/AccelStamped",
}


class Answer(NamedTuple):
    """The answer to one message: forces to publish, commands, and whether there are new topics."""

    forces: bytes | None = None
    commands: Sequence[Command] = ()
    has_grown: bool = False


def check_type(where: str, topic: str, type_name: str, other: str) -> None:
    """Raises InputError if a topic is also used for another message type."""
    if other != type_name:
        raise InputError(
            f"{where}: topic {topic} is given for {type_name} and for {other}; use one topic per message type"
        )


@dataclass(frozen=True, eq=False)
class Displacement:
    """One displacement topic with its dampers, and their comparison with the gauges."""

    source: DisplacementInput
    comparison: Comparison


class Estimation:
    """The running state of all dampers; final.

    Attributes:
        settings: it was built from these.
        roster: the dampers, and the signal map.
        displacement: by topic.
        slow: slow channels by topic, with damper and role.
        topics: type by topic of all subscriptions; grows if dampers arrive by name.
        named: the topics that the signal map names; the others are the default topics of a damper of that name.
    """

    def __init__(self, settings: Settings, roster: Roster) -> None:
        """Raises InputError if a field path does not fit its message type."""
        self.settings = settings
        self.roster = roster
        self.displacement: dict[str, Displacement] = {}
        self.slow: dict[str, list[tuple[str, str, SlowInput | AccelerationInput]]] = {}
        self.topics: dict[str, str] = {}
        self.named: set[str] = set()
        self._gauges: dict[str, tuple[tuple[str, ...], GaugeInput]] = {}
        self._before: Estimation | None = None
        by_topic: dict[str, list[Estimator]] = {}
        for estimator in roster.known:
            by_topic.setdefault(estimator.signals.displacement.topic, []).append(estimator)
        if roster.template is not None:
            by_topic = {default_signals("").displacement.topic: []}
        for topic, estimators in by_topic.items():
            source = DisplacementInput(estimators, settings)
            self.displacement[topic] = Displacement(source, _comparison(source, settings, roster))
            self._subscribe(topic, JOINT_STATE, True)
            for estimator in estimators:
                self._add_slow_channels(source, estimator)
        self._update_gauges()

    def changed(self, settings: Settings) -> "Estimation":
        """The same filters and models in their present state, with other settings that do not affect them.

        Raises:
            InputError: if a driver cannot set the safe current.
        """
        for displacement in self.displacement.values():
            for follower in displacement.source.followers:
                follower.check_safe_current(settings.safe_current)
        other = copy(self)
        other.settings = settings
        other.displacement = {
            topic: Displacement(displacement.source, _comparison(displacement.source, settings, self.roster))
            for topic, displacement in self.displacement.items()
        }
        return other

    def slow_topics(self, damper: str) -> dict[str, str]:
        """Topics of the slow channels of one damper, by role; only those that are subscribed."""
        return {
            role: topic
            for topic, inputs in self.slow.items()
            for name, role, _ in inputs
            if name == damper and topic in self.topics
        }

    def _subscribe(self, topic: str, type_name: str, is_named: bool) -> None:
        if is_named:
            self.named.add(topic)
        check_type(self.roster.signal_map.where, topic, type_name, self.topics.setdefault(topic, type_name))

    def _add_slow_channels(self, source: DisplacementInput, estimator: Estimator) -> None:
        name, signals = estimator.name, estimator.signals
        damper = source.line.names.index(name)
        for role in SLOW:
            channel = getattr(signals, role)
            current = source.followers[damper].current if role == "command" else None
            slow = SlowInput(role, SLOW_TYPES[role], channel, source.line, damper, current)
            self._add_slow(name, role, channel, slow)
        if estimator.deployed.fusion is not None:
            acceleration = AccelerationInput(SLOW_TYPES["acceleration"], signals.acceleration, source.line, damper)
            self._add_slow(name, "acceleration", signals.acceleration, acceleration)

    def _add_slow(self, name: str, role: str, channel: Channel, slow: SlowInput | AccelerationInput) -> None:
        self.slow.setdefault(channel.topic, []).append((name, role, slow))
        self._subscribe(channel.topic, SLOW_TYPES[role], channel.given)

    def _update_gauges(self) -> None:
        """Updates the gauges and the desired forces for the present dampers."""
        desired = [Channel(DESIRED, named_element("effort", name)) for name in self.names]
        self._desired = reader_of("desired force", JOINT_STATE, desired)
        self._subscribe(DESIRED, JOINT_STATE, True)
        by_topic: dict[str, list[Estimator]] = {}
        for displacement in self.displacement.values():
            for estimator in displacement.source.estimators:
                by_topic.setdefault(estimator.signals.force.topic, []).append(estimator)
        for topic, estimators in by_topic.items():
            gauge = GaugeInput([estimator.signals for estimator in estimators])
            self._gauges[topic] = (tuple(estimator.name for estimator in estimators), gauge)
            self._subscribe(topic, JOINT_STATE, any(estimator.signals.force.given for estimator in estimators))

    @property
    def names(self) -> list[str]:
        """All dampers."""
        return [name for displacement in self.displacement.values() for name in displacement.source.line.names]

    @property
    def commanded(self) -> list[str]:
        """The dampers to which currents can be sent."""
        return [
            follower.name
            for displacement in self.displacement.values()
            for follower in displacement.source.followers
            if not follower.refusal
        ]

    def take(self, topic: str, data: bytes, arrival: Arrival) -> Answer:
        """Processes one serialised message of a topic.

        Raises:
            MalformedMessage: if the bytes do not fit the type.
        """
        displacement, settings, now = self.displacement.get(topic), self.settings, arrival.now
        if displacement is None:
            for _, _, slow in self.slow.get(topic, ()):
                slow.take(data, now, arrival.received)
            if topic in self._gauges:
                self._gauges[topic][1].take(data)
            return Answer(commands=self._request(data, now)) if topic == DESIRED else Answer()
        source = displacement.source
        has_grown = self.roster.template is not None and self._admit(source, data)
        if topic in self._gauges:
            self._gauges[topic][1].take(data)
        forces = source.take(data, arrival, settings.max_age)
        displacement.comparison.buffer.keep(source.stamp)
        return Answer(forces, source.due(now, settings.stale_after, settings), has_grown)

    def _request(self, data: bytes, now: float) -> list[Command]:
        """The commands that answer a message of desired forces."""
        reading, commands, number = self._desired.read(data), [], 0
        for displacement in self.displacement.values():
            source = displacement.source
            for d, follower in enumerate(source.followers):
                if reading.present[number]:
                    follower.request(float(reading.values[number]), now)
                    status = source.trusted(d, now, self.settings.stale_after)
                    command = follower.command(status, int(source.stamps[d]), now, self.settings)
                    commands += [command] if command is not None else []
                number += 1
        return commands

    def safe(self) -> list[Command]:
        """Safe currents for all dampers that have been commanded."""
        return self._commands(lambda follower, source, d: follower.safe(int(source.stamps[d]), self.settings))

    def overdue(self, now: float, period: float) -> list[Command]:
        """Commands for the dampers that have been commanded, but not in the last ``period`` s before the steady time
        ``now``: their displacement comes slowly or has stopped.
        """
        after, rules = self.settings.stale_after, self.settings

        def command(follower: ForceFollower, source: DisplacementInput, d: int) -> Command | None:
            if not follower.tally.desired or now - follower.sent_at <= period:
                return None
            return follower.command(source.trusted(d, now, after), int(source.stamps[d]), now, rules)

        return self._commands(command)

    def idle(self) -> list[Command]:
        """Commands for the dampers of which no force has been desired."""
        return self._commands(lambda follower, source, d: follower.idle(int(source.stamps[d]), self.settings))

    def _commands(self, of: Callable[[ForceFollower, DisplacementInput, int], Command | None]) -> list[Command]:
        """The commands that ``of`` returns for each follower of each input."""
        found = (of(follower, source, d) for source in self._sources() for d, follower in enumerate(source.followers))
        return [command for command in found if command is not None]

    def _sources(self) -> list[DisplacementInput]:
        return [displacement.source for displacement in self.displacement.values()]

    def rewind(self, now: float) -> None:
        """After the clock was set back to ``now``, s."""
        for source in self._sources():
            source.rewind(now)

    def _admit(self, source: DisplacementInput, data: bytes) -> bool:
        """Adds the dampers that arrive by name; returns whether there were any."""
        if not source.is_new_structure(data):
            return False
        new = [n for n in dict.fromkeys(names_in(data)) if n and n not in source.line.names]
        for name in new[: max(MOST_DAMPERS - len(source.line.names), 0)]:
            estimator = self.roster.newcomer(name)
            source.add(estimator)
            self._add_slow_channels(source, estimator)
        if new:
            self._update_gauges()
        return bool(new)

    def compare(self) -> list[bytes]:
        """The residual messages that are now complete."""
        measured = {}
        for names, gauge in self._gauges.values():
            if gauge.has_samples:
                measured |= dict(zip(names, gauge.drain(), strict=True))
        comparisons = [displacement.comparison for displacement in self.displacement.values()]
        return [message for comparison in comparisons for message in comparison.compare(measured)]

    def stale(self, now: float, without: Collection[str] = ()) -> list[bytes]:
        """Messages about dampers whose input has stopped, at the steady time ``now``, s; ``without`` some of them."""
        after = self.settings.stale_after
        found = [message for source in self._sources() for message in source.stale(now, after, without)]
        if self._before is not None:
            estimated = {name for source in self._sources() for name in source.estimated}
            # Only a roster that takes dampers as they come may still meet one that it does not know.
            gone = set() if self.roster.template is not None else set(self._before.names) - set(self.names)
            if estimated | gone >= set(self._before.names):
                self._before = None
            else:
                found += self._before.stale(now, {*without, *estimated, *gone})
        return found

    def continue_after(self, before: "Estimation | None") -> None:
        """Until a damper's first sample in this estimation, its estimate of the one before becomes stale."""
        if before is not None and before.roster is not self.roster:
            before._before = None
            self._before = before


def _comparison(source: DisplacementInput, settings: Settings, roster: Roster) -> Comparison:
    cutoff = roster.signal_map.gauge_cutoff
    return Comparison(source, cutoff, settings.max_gap, settings.drift_window, settings.drift_factor)
