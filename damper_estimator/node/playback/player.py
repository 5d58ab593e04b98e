"""Plays recorded messages to a running node over DDS, as fast as it answers, and keeps the answers."""

import struct
import subprocess
import time
from collections.abc import Callable, Container, Iterable

from damper_msgs.msg import DamperForces
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy

from damper_estimator.errors import InputError
from damper_estimator.node.health import SUBSCRIBERS
from damper_estimator.node.input_health import PUBLISHERS
from damper_estimator.node.inputs import message_type

WINDOW = 20  # largest number of unanswered displacement messages
PATIENCE = 0.5  # s, after which an unanswered message counts as one without an estimate
LINGER = 10.0  # s without any answer, after which the missing ones count as lost
PAUSE = 0.02  # s after a message of a slow channel: topics overtake each other
DISCOVERY = 120.0  # s; a new model is compiled first, which takes long on a busy machine
DEPTH = 1000
_STAMP = slice(4, 12)


class Player:
    """A node that publishes serialised messages and subscribes to the estimator; final. rclpy must be initialised.

    Attributes:
        forces: every received ``DamperForces`` that answers a message.
        stale: those that report that the input has stopped.
        health: every received ``DiagnosticArray``.
    """

    def __init__(self, estimator: str = "/damper_estimator", process: subprocess.Popen | None = None) -> None:
        """``estimator``: full name of the node; ``process``: that of the node, if waiting must end with it."""
        self._process = process
        self.forces: list[DamperForces] = []
        self.stale: list[DamperForces] = []
        self._seen = 0
        self.health: list[DiagnosticArray] = []
        self._node = Node("player", start_parameter_services=False)
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self._node)
        self._publishers: dict[str, object] = {}
        quality = QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.RELIABLE)
        self._node.create_subscription(DamperForces, f"{estimator}/force", self._keep, quality)
        self._node.create_subscription(DiagnosticArray, "/diagnostics", self.health.append, quality)

    def _keep(self, message: DamperForces) -> None:
        (self.stale if DamperForces.STALE in message.status else self.forces).append(message)

    def connect(self, topics: dict[str, str]) -> None:
        """Creates a publisher for each topic (with its type, such as ``std_msgs/msg/Float64``) and waits for the
        estimator.

        Args:
            topics: those of displacement last. A node discovers publishers one after the other, and the estimator
                reports these.

        Raises:
            InputError: if one of them has no subscriber in time.
        """
        quality = QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.RELIABLE)
        for topic, kind in topics.items():
            self._publishers[topic] = self._node.create_publisher(message_type(kind), topic, quality)
        for topic, publisher in self._publishers.items():
            self.wait(lambda publisher=publisher: publisher.get_subscription_count() > 0, f"a subscriber of {topic}")
        # Discovery is one-sided: the estimator reports in a later message that it has discovered this node.
        seen = len(self.health)
        self.wait(
            lambda: any(_is_connected(health, self._publishers) for health in self.health[seen + 1 :]),
            "the estimator to discover this node",
        )

    def play(self, messages: Iterable[tuple[str, bytes]], answered: set[str]) -> None:
        """Publishes (topic, serialised message) in order.

        Args:
            answered: topics whose messages are answered by forces; never more than ``WINDOW`` of them are unanswered.
        """
        pending: list[bytes] = []  # stamps of displacement messages that are not answered
        self._seen = len(self.forces)
        for topic, data in messages:
            is_answered = topic in answered
            self._settle(pending, WINDOW - 1 if is_answered else 0)
            self._publishers[topic].publish(data)
            if is_answered:
                pending.append(data[_STAMP])
            else:
                time.sleep(PAUSE)
        self._settle(pending, 0)

    def _settle(self, pending: list[bytes], allowed: int) -> None:
        """Waits until at most ``allowed`` are unanswered; gives up when nothing comes for ``PATIENCE``."""
        since = time.monotonic()
        while len(pending) > allowed:
            self._executor.spin_once(timeout_sec=PATIENCE / 10)
            for message in self.forces[self._seen :]:
                stamp = struct.pack("<iI", message.header.stamp.sec, message.header.stamp.nanosec)
                if stamp in pending:
                    pending.remove(stamp)
                since = time.monotonic()
            self._seen = len(self.forces)
            if time.monotonic() - since > PATIENCE:
                pending.clear()

    def linger(self, count: int) -> None:
        """Waits until there are ``count`` forces, or none has come for ``LINGER``: a busy machine is slow."""
        seen, since = len(self.forces), time.monotonic()
        while len(self.forces) < count and time.monotonic() - since < LINGER:
            self._executor.spin_once(timeout_sec=0.05)
            if len(self.forces) > seen:
                seen, since = len(self.forces), time.monotonic()

    def wait(self, condition: Callable[[], bool], what: str, patience: float = DISCOVERY) -> None:
        """Waits until a condition holds.

        Raises:
            InputError: if it does not hold in time, or the estimator has ended; ``what`` names the condition.
        """
        end = time.monotonic() + patience
        while not condition():
            if self._process is not None and self._process.poll() is not None:
                raise InputError(f"the estimator ended during the wait for {what}; see its message")
            if time.monotonic() > end:
                raise InputError(
                    f"waited {patience:g} s for {what}; is the estimator running with the same ROS_DOMAIN_ID?"
                )
            self._executor.spin_once(timeout_sec=0.05)

    def close(self) -> None:
        """Destroys the ROS node."""
        self._executor.shutdown()
        self._node.destroy_node()


def _is_connected(health: DiagnosticArray, topics: Container[str]) -> bool:
    reports = [{pair.key: pair.value for pair in status.values} for status in health.status]
    publishers = [report[PUBLISHERS] for report in reports if PUBLISHERS in report and report["topic"] in topics]
    return "0" not in publishers and any(report.get(SUBSCRIBERS, "0") != "0" for report in reports)
