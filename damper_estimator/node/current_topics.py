"""The topics of commanded currents, one per damper whose force depends on a current."""

import sys
import time
from collections.abc import Iterable, Sequence

from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from std_msgs.msg import Float64

from damper_estimator.node.ports import LoggingNode, PublishingNode
from damper_estimator.node.quality_of_service import OVERRIDABLE, offered
from damper_estimator.node.rclpy_private import RCLError

DEPTH = 10
ACKNOWLEDGED = 0.5  # s, longest wait for the last commands to be acknowledged
ON_THE_WAY = 0.05  # s for subscriptions that acknowledge nothing
DISCOVERED = 5.0  # s, longest wait until another context discovers the drivers
CURRENT_TYPE = "std_msgs/msg/Float64"


def topic_of(damper: str) -> str:
    """The topic on which currents of a damper are commanded."""
    return f"suspension/{damper}/current_command"


class CurrentTopics:
    """Publishers of ``suspension/<damper>/current_command``; final."""

    def __init__(self, node: PublishingNode) -> None:
        self._node = node
        self._publishers: dict[str, Publisher] = {}

    def offer(self, names: Iterable[str]) -> None:
        """Creates a topic for each of these dampers; one whose name cannot be part of a topic has none."""
        for name in names:
            if name in self._publishers:
                continue
            topic = topic_of(name)
            try:
                self._publishers[name] = self._node.create_publisher(
                    Float64, topic, offered(DEPTH), qos_overriding_options=OVERRIDABLE
                )
            except (ValueError, RCLError) as error:
                reason = str(error).partition(", at ")[0]
                self._node.get_logger().warning(f"{name}: no currents can be commanded on {topic}: {reason}")

    def publish(self, name: str, data: bytes) -> Publisher | None:
        """Publishes a serialised command; returns the publisher, None if the damper has no topic."""
        publisher = self._publishers.get(name)
        if publisher is not None:
            publisher.publish(data)
        return publisher

    def last(self, commands: Iterable[tuple[str, bytes]]) -> list[tuple[Publisher, bytes]]:
        """For `deliver`: commands (name of the damper, serialised) with their publishers."""
        return [(self._publishers[name], data) for name, data in commands if name in self._publishers]

    @property
    def publishers(self) -> list[Publisher]:
        """Of all dampers."""
        return list(self._publishers.values())

    def close(self) -> None:
        """Destroys the topics."""
        for publisher in self._publishers.values():
            self._node.destroy_publisher(publisher)
        self._publishers.clear()


def deliver(node: LoggingNode, publishers: Sequence[Publisher], last: Sequence[tuple[Publisher, bytes]] = ()) -> None:
    """Waits briefly until the node's published messages have arrived. If its context was shut down, so that it could
    not publish the ``last`` messages, another context sends them.
    """
    if node.context.ok():
        _let_arrive(publishers)
    elif last:
        _send_from_another_context(last)


def _let_arrive(publishers: Sequence[Publisher]) -> None:
    end = time.monotonic() + ACKNOWLEDGED
    for publisher in publishers:
        publisher.wait_for_all_acked(Duration(seconds=max(end - time.monotonic(), 0.0)))
    if any(publisher.get_subscription_count() for publisher in publishers):
        time.sleep(ON_THE_WAY)


def _send_from_another_context(last: Sequence[tuple[Publisher, bytes]]) -> None:
    """Sends messages as the given publishers would have, to the subscribers discovered on their topics."""
    context = Context()
    context.init()
    node = Node("last_commands", context=context, use_global_arguments=False, enable_rosout=False,
                start_parameter_services=False)  # fmt: skip
    try:
        senders = {
            closed: node.create_publisher(closed.msg_type, closed.topic_name, offered(DEPTH)) for closed, _ in last
        }
        end = time.monotonic() + DISCOVERED
        while time.monotonic() < end and not all(sender.get_subscription_count() for sender in senders.values()):
            time.sleep(0.01)
        for closed, data in last:
            senders[closed].publish(data)
        _let_arrive(list(senders.values()))
        unheard = sorted(closed.topic_name for closed, sender in senders.items() if not sender.get_subscription_count())
        if unheard:
            print(
                f"the context was shut down, and within {DISCOVERED:g} s no driver was found on {', '.join(unheard)} "
                "for the safe current; the driver's deadline has to act",
                file=sys.stderr,
            )
    finally:
        node.destroy_node()
        context.try_shutdown()
