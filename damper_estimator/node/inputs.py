"""The node's subscriptions: every message arrives as bytes, is counted, and is passed to the present estimation."""

import time
import traceback
from collections.abc import Callable, Iterable
from contextlib import suppress
from copy import copy
from dataclasses import replace
from importlib import import_module
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from damper_estimator.errors import InputError
from damper_estimator.node.command_publisher import CommandPublisher
from damper_estimator.node.current_topics import CURRENT_TYPE, topic_of
from damper_estimator.node.estimation import Arrival, Estimation, check_type
from damper_estimator.node.input_health import InputTally
from damper_estimator.node.message_info import with_info
from damper_estimator.node.ports import NodeState, SubscribingNode
from damper_estimator.node.quality_of_service import OVERRIDABLE
from damper_estimator.node.rclpy_private import RCLError, take
from damper_estimator.node.sequence_numbers import DoubleSenders, Losses
from damper_estimator.node.simulated_time import SimulatedTime
from damper_estimator.node.wire import MalformedMessage

LOG_PERIOD = 1.0  # s, at most one error per topic
# What the node and rclpy publish for it; none is an input.
OUTPUTS = (
    "/diagnostics", "/rosout", "/parameter_events", "~/transition_event", "~/force", "~/residual", "~/command",
)  # fmt: skip


class Inputs:
    """The subscriptions by topic, as the signal map names it; final.

    Attributes:
        tallies: counts by topic; they survive changes of parameters.
        data: the last message by topic.
        is_simulated: whether the node's time is simulated; see `check_clock`.
        busy: s, time spent on messages.
    """

    def __init__(
        self,
        node: SubscribingNode,
        state: NodeState,
        publish_forces: Callable[[bytes], None],
        commands: CommandPublisher,
    ) -> None:
        """Answers go to ``publish_forces`` and ``commands``."""
        self._node, self._state = node, state
        self._publish_forces, self._commands = publish_forces, commands
        self._quality: QoSProfile | None = None
        self._subscriptions: dict[tuple[str, str], Subscription] = {}
        self.tallies: dict[str, InputTally] = {}
        self.data: dict[str, bytes] = {}
        self.busy = 0.0
        self.is_simulated = False
        self._simulated = SimulatedTime()
        self._latest = float("-inf")
        self._longest = 0.0

    def open(self, quality: QoSProfile) -> None:
        """Further subscriptions have this quality of service."""
        self._quality = quality

    def close(self) -> None:
        """Destroys all subscriptions."""
        for subscription in self._subscriptions.values():
            self._node.destroy_subscription(subscription)
        self._subscriptions.clear()
        self.tallies.clear()
        self.data.clear()

    def check(self, estimation: Estimation) -> None:
        """Drops the topics whose name a damper's name makes invalid, for example by a blank.

        Raises:
            InputError: if a topic that the signal map names is invalid, is one that this node publishes (only the
                current may be the commanded one), or has another type under another name.
        """
        where = estimation.roster.signal_map.where
        outputs = {self._node.resolve_topic_name(topic) for topic in OUTPUTS}
        types: dict[str, str] = {}  # by resolved name
        for damper in estimation.names:
            with suppress(ValueError, RCLError):
                types[self._node.resolve_topic_name(topic_of(damper))] = CURRENT_TYPE
        for topic, type_name in list(estimation.topics.items()):
            try:
                name = self._node.resolve_topic_name(topic)
            except (ValueError, RCLError) as error:
                if topic in estimation.named:
                    raise InputError(
                        f"{where}: {topic!r} cannot be a topic: use letters, digits, _ "
                        "and /, and begin no part with a digit"
                    ) from error
                del estimation.topics[topic]
                continue
            if name in outputs:
                raise InputError(f"{where}: {topic} is published by this node; give the topic of the sensor")
            check_type(where, topic, type_name, types.setdefault(name, type_name))

    def subscribe(self, estimation: Estimation) -> None:
        """Creates the missing subscriptions of the estimation, and destroys those that it does not need."""
        required = set(estimation.topics.items())
        for key in [key for key in self._subscriptions if key not in required]:
            self._node.destroy_subscription(self._subscriptions.pop(key))
            self.tallies.pop(key[0], None)
        for topic, type_name in required - self._subscriptions.keys():
            self._subscriptions[topic, type_name] = self._subscription(topic, type_name)

    def take_waiting(self) -> bool:
        """Answers the waiting messages while the executor cannot; returns whether there were any."""
        found = False
        for subscription in list(self._subscriptions.values()):
            taken = take(subscription)
            if taken is not None:
                found = True
                subscription.callback(*taken)
        return found

    def check_clock(self) -> None:
        """Updates whether time is simulated; once a second, because the query takes too long for every message."""
        is_simulated = self._node.get_clock().ros_time_is_active
        if is_simulated != self.is_simulated:
            self.is_simulated, self._latest = is_simulated, float("inf")
            self.now()

    def now(self) -> float:
        """Time for staleness, s: that of the simulated clock if it is in use, since it may run at another pace. If a
        clock is set back, times of earlier messages and requests are set back as well.
        """
        now = time.monotonic()
        if self.is_simulated:
            now = self._simulated.seconds(self._clock() / 1e9, now)
        if now < self._latest and self._state.estimation is not None:
            self._state.estimation.rewind(now)
        self._latest = now
        return now

    @property
    def clock_has_stopped(self) -> bool:
        """Whether messages arrive although the simulated clock stands still."""
        return self.is_simulated and self._simulated.has_stopped

    def _clock(self) -> int:
        return self._node.get_clock().now().nanoseconds

    def take_longest(self) -> float:
        """The longest time that one message has taken since the last call, s."""
        longest, self._longest = self._longest, 0.0
        return longest

    def snapshot(self, topics: Iterable[str]) -> dict[str, InputTally]:
        """A copy of the counts of these topics."""
        return {topic: replace(self.tallies[topic]) for topic in topics}

    def _subscription(self, topic: str, type_name: str) -> Subscription:
        node, state = self._node, self._state
        tally, losses = InputTally(node.resolve_topic_name(topic)), Losses()
        self.tallies[topic] = tally
        answer = self._answering(topic, type_name, tally)

        def receive(data: bytes, number: int | None, received: int) -> None:
            begin = time.monotonic()
            if state.is_active:
                answer(data, number, received, begin)
            # The answer has been published; counts for the report once a second come after it.
            tally.messages += 1
            tally.last = begin
            self.data[topic] = data
            if number is not None:
                losses.take(number)
                tally.lost = losses.lost
            took = time.monotonic() - begin
            self.busy += took
            if took > self._longest:
                self._longest = took

        return node.create_subscription(
            message_type(type_name),
            topic,
            with_info(receive),
            copy(self._quality),  # overrides are written into it
            event_callbacks=_events(tally, losses),
            qos_overriding_options=OVERRIDABLE,
            raw=True,
        )

    def _answering(
        self, topic: str, type_name: str, tally: InputTally
    ) -> Callable[[bytes, int | None, int, float], None]:
        """The function that answers a message on this topic; arguments as in `with_info`, and the steady time, s."""
        node, state, senders = self._node, self._state, DoubleSenders()
        publish_forces, commands = self._publish_forces, self._commands

        def answer(data: bytes, number: int | None, received: int, now: float) -> None:
            if state.recorder is not None:
                state.recorder.keep(tally.topic, type_name, data)
            try:
                is_simulated = self.is_simulated
                if is_simulated:
                    self._simulated.hear(now)
                    now = self.now()
                clock = round(now * 1e9) if is_simulated else time.time_ns()
                suspect = tally.publishers > 1 and number is not None and self._is_suspect(
                    topic, senders, data, number, now
                )  # fmt: skip
                if is_simulated or not received:
                    received = clock
                answers = state.estimation.take(topic, data, Arrival(now, clock, received, suspect, is_simulated))
                if answers.forces is not None:
                    publish_forces(answers.forces)
                if answers.commands:
                    commands.publish(answers.commands)
                if answers.has_grown:
                    self.check(state.estimation)
                    self.subscribe(state.estimation)
                    commands.offer(state.estimation.commanded)
            except MalformedMessage:
                tally.malformed += 1
            except Exception:
                if not node.context.ok():
                    return  # a signal has shut ROS down
                tally.failures += 1
                node.get_logger().error(
                    f"message on {topic}: {traceback.format_exc()}", throttle_duration_sec=LOG_PERIOD
                )

        return answer

    def _is_suspect(self, topic: str, senders: DoubleSenders, data: bytes, number: int, now: float) -> bool:
        """Whether another publisher has possibly sent the same damper as this message of this sequence number."""
        tally, estimation = self.tallies[topic], self._state.estimation
        displacement = estimation.displacement.get(topic)
        if displacement is None:
            return False
        suspect = senders.take(number, displacement.source.dampers_in(data), now, estimation.settings.max_gap)
        tally.doubled = senders.confirmed
        return suspect


def _events(tally: InputTally, losses: Losses) -> SubscriptionEventCallbacks:
    """Handlers of the middleware's events about the publishers of one topic."""

    def on_incompatible(event: Any) -> None:
        tally.incompatible = event.total_count

    def on_matched(event: Any) -> None:
        tally.publishers = event.current_count
        losses.matched(event.total_count)

    def on_lost(event: Any) -> None:
        tally.reported_lost = event.total_count

    return SubscriptionEventCallbacks(incompatible_qos=on_incompatible, matched=on_matched, message_lost=on_lost)


def message_type(type_name: str) -> type:
    """The Python class of ``package/msg/Name``."""
    package, folder, name = type_name.split("/")
    return getattr(import_module(f"{package}.{folder}"), name)
