"""The node's subscriptions: every message is taken as bytes, counted, and given to the estimation of the moment."""

import time
import traceback
from collections.abc import Callable, Iterable
from copy import copy
from dataclasses import replace
from importlib import import_module

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.lifecycle import LifecycleNode
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from damper_estimator.errors import InputError
from damper_estimator.node.estimation import Arrival, Estimation
from damper_estimator.node.health import InputTally
from damper_estimator.node.message_info import with_info
from damper_estimator.node.quality import OVERRIDABLE
from damper_estimator.node.rclpy_private import RCLError, take
from damper_estimator.node.senders import DoubleSenders, Losses
from damper_estimator.node.wire import MalformedMessage

LOG_PERIOD = 1.0  # s, at most one complaint per topic


class Inputs:
    """What comes in, by topic as the signal map names it; final.

    Attributes:
        tallies: counts by topic; they survive changes of parameters.
        data: the last message by topic.
        is_simulated: whether the node's time is a simulated one; see `look_at_clock`.
        busy: s, time spent on messages; ``longest`` the longest of one since `take_longest`.
    """

    def __init__(self, node: LifecycleNode) -> None:
        self._node = node
        self._quality: QoSProfile | None = None
        self._subscriptions: dict[tuple[str, str], Subscription] = {}
        self.tallies: dict[str, InputTally] = {}
        self.data: dict[str, bytes] = {}
        self.busy = 0.0
        self.is_simulated = False
        self._latest = float("-inf")
        self._longest = 0.0

    def open(self, quality: QoSProfile) -> None:
        """From now on with this quality of service."""
        self._quality = quality

    def close(self) -> None:
        """Gives all subscriptions up."""
        for subscription in self._subscriptions.values():
            self._node.destroy_subscription(subscription)
        self._subscriptions.clear()
        self.tallies.clear()
        self.data.clear()

    def check(self, estimation: Estimation) -> None:
        """Leaves out the topics that a damper's name cannot be part of, such as one with a blank.

        Raises:
            InputError: where a topic that somebody named cannot be one.
        """
        for topic in list(estimation.topics):
            try:
                self._node.resolve_topic_name(topic)
            except (ValueError, RCLError) as error:
                if topic in estimation.named:
                    raise InputError(
                        f"{estimation.roster.signal_map.where}: {topic!r} cannot be a topic: letters, digits, _ and / "
                        "can, and no part begins with a digit"
                    ) from error
                del estimation.topics[topic]

    def subscribe(self, estimation: Estimation) -> None:
        """Subscribes what the estimation wants and is not there yet, and gives up what it does not want."""
        wanted = set(estimation.topics.items())
        for key in [key for key in self._subscriptions if key not in wanted]:
            self._node.destroy_subscription(self._subscriptions.pop(key))
            self.tallies.pop(key[0], None)
        for topic, type_name in wanted - self._subscriptions.keys():
            self._subscriptions[topic, type_name] = self._subscription(topic, type_name)

    def take_waiting(self) -> bool:
        """Answers the messages that wait, where the executor cannot; whether there were any."""
        found = False
        for subscription in list(self._subscriptions.values()):
            taken = take(subscription)
            if taken is not None:
                found = True
                subscription.callback(*taken)
        return found

    def look_at_clock(self) -> None:
        """Whether time is simulated; looked up once a second, since asking costs too much."""
        is_simulated = self._node.get_clock().ros_time_is_active
        if is_simulated != self.is_simulated:
            self.is_simulated, self._latest = is_simulated, float("inf")
            self.now()

    def now(self) -> float:
        """Time for staleness, s: the simulated clock where that is in use, since it may run at another pace. A clock
        that is set back takes along what was received and asked before."""
        now = self._clock() / 1e9 if self.is_simulated else time.monotonic()
        if now < self._latest and self._node.estimation is not None:
            self._node.estimation.rewind(now)
        self._latest = now
        return now

    def _clock(self) -> int:
        return self._node.get_clock().now().nanoseconds

    def take_longest(self) -> float:
        """The longest time that one message took since the last call, s."""
        longest, self._longest = self._longest, 0.0
        return longest

    def snapshot(self, topics: Iterable[str]) -> dict[str, InputTally]:
        """A copy of the counts of these topics."""
        return {topic: replace(self.tallies[topic]) for topic in topics}

    def _subscription(self, topic: str, type_name: str) -> Subscription:
        node = self._node
        tally, losses = InputTally(node.resolve_topic_name(topic)), Losses()
        self.tallies[topic] = tally
        answer = self._answering(topic, type_name, tally)

        def receive(data: bytes, number: int | None, received: int) -> None:
            begin = time.monotonic()
            if node.is_active:
                answer(data, number, received, begin)
            # The answer has gone; what is only told once a second comes after it.
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
        """What answers a message on this topic; arguments as in `with_info`, and the steady time, s."""
        node, senders = self._node, DoubleSenders()

        def answer(data: bytes, number: int | None, received: int, now: float) -> None:
            if node.recorder is not None:
                node.recorder.keep(tally.topic, type_name, data)
            try:
                is_simulated = self.is_simulated
                if is_simulated:
                    now = self.now()
                clock = round(now * 1e9) if is_simulated else time.time_ns()
                suspect = tally.publishers > 1 and number is not None and self._is_suspect(
                    topic, senders, data, number, now
                )  # fmt: skip
                if is_simulated or not received:
                    received = clock
                told = node.estimation.take(topic, data, Arrival(now, clock, received, suspect, is_simulated))
                if told.forces is not None:
                    node.publish_forces(told.forces)
                if told.commands:
                    node.commanding.publish(told.commands)
                if told.has_grown:
                    self.check(node.estimation)
                    self.subscribe(node.estimation)
                    node.commanding.offer(node.estimation.commanded)
            except MalformedMessage:
                tally.malformed += 1
            except Exception:
                if not node.context.ok():
                    return  # a signal has taken ROS away
                tally.failures += 1
                node.get_logger().error(
                    f"message on {topic}: {traceback.format_exc()}", throttle_duration_sec=LOG_PERIOD
                )

        return answer

    def _is_suspect(self, topic: str, senders: DoubleSenders, data: bytes, number: int, now: float) -> bool:
        """Whether another publisher may have sent the same damper as this message of this sequence number."""
        tally, estimation = self.tallies[topic], self._node.estimation
        displacement = estimation.displacement.get(topic)
        if displacement is None:
            return False
        suspect = senders.take(number, displacement.source.held(data), now, estimation.settings.max_gap)
        tally.doubled = senders.confirmed
        return suspect


def _events(tally: InputTally, losses: Losses) -> SubscriptionEventCallbacks:
    """What the middleware says of the publishers of one topic."""

    def on_incompatible(event: object) -> None:
        tally.incompatible = event.total_count

    def on_matched(event: object) -> None:
        tally.publishers = event.current_count
        losses.matched(event.total_count)

    def on_lost(event: object) -> None:
        tally.reported_lost = event.total_count

    return SubscriptionEventCallbacks(incompatible_qos=on_incompatible, matched=on_matched, message_lost=on_lost)


def message_type(type_name: str) -> type:
    """The Python class of ``package/msg/Name``."""
    package, folder, name = type_name.split("/")
    return getattr(import_module(f"{package}.{folder}"), name)
