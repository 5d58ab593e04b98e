"""Plays recorded messages to a running node over DDS, as fast as it answers, and keeps what it answers."""

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
from damper_estimator.node.health import PUBLISHERS, SUBSCRIBERS
from damper_estimator.node.inputs import message_type

WINDOW = 20  # displacement messages that may be unanswered
PATIENCE = 0.5  # s, after which an unanswered message counts as one that gives no estimate
LINGER = 10.0  # s without any answer, after which those that are missing are taken for lost
PAUSE = 0.02  # s after a message of a slow channel: topics overtake each other
DISCOVERY = (
    120.0  # s; the kernels of a model that never ran here are compiled first, which a busy machine takes its time for
)
DEPTH = 1000
_STAMP = slice(4, 12)


class Player:
    """A node that publishes serialised messages and listens to the estimator; final. rclpy must be initialised.

    Attributes:
        forces: every ``DamperForces`` that came and answers a message.
        stale: those that say that the input has stopped.
        health: every ``DiagnosticArray`` that came.
    """

    def __init__(self, estimator: str = "/damper_estimator", process: subprocess.Popen | None = None) -> None:
        """``estimator``: full name of the node that is played to; ``process``: its own, where waiting ends when it
        ends.
        """
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
        self._hear = self._keep
        self._node.create_subscription(DamperForces, f"{estimator}/force", lambda m: self._hear(m), quality)
        self._node.create_subscription(DiagnosticArray, "/diagnostics", self.health.append, quality)

    def listen_instead(self, hear: Callable[[DamperForces], None]) -> None:
        """Gives the forces to ``hear`` and keeps none, for runs without end."""
        self._hear = hear

    def publish(self, topic: str, data: bytes) -> None:
        """One serialised message."""
        self._publishers[topic].publish(data)

    def spin(self, seconds: float) -> None:
        """Listens for one message, at most so long."""
        self._executor.spin_once(timeout_sec=seconds)

    def _keep(self, message: DamperForces) -> None:
        (self.stale if DamperForces.STALE in message.status else self.forces).append(message)

    def connect(self, topics: dict[str, str]) -> None:
        """Makes a publisher for each topic (with its type, such as ``std_msgs/msg/Float64``) and
        waits for the estimator.

        Args:
            topics: those of displacement last. A node learns of publishers one after the other, and this is what the
                estimator tells of.

        Raises:
            InputError: where nobody listens on one of them in time.
        """
        quality = QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.RELIABLE)
        for topic, kind in topics.items():
            self._publishers[topic] = self._node.create_publisher(message_type(kind), topic, quality)
        for topic, publisher in self._publishers.items():
            self.wait(lambda publisher=publisher: publisher.get_subscription_count() > 0, f"a subscriber of {topic}")
        # That we know of the estimator does not mean that it knows of us. It says so itself, in a later report.
        seen = len(self.health)
        self.wait(
            lambda: any(_hears_and_is_heard(own, self._publishers) for own in self.health[seen + 1 :]),
            "the estimator to hear and be heard",
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
        """Listens until at most ``allowed`` are unanswered; gives them up when nothing comes for ``PATIENCE``."""
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
        """Listens until there are ``count`` forces, or none has come for ``LINGER``: a busy machine takes its time."""
        seen, since = len(self.forces), time.monotonic()
        while len(self.forces) < count and time.monotonic() - since < LINGER:
            self._executor.spin_once(timeout_sec=0.05)
            if len(self.forces) > seen:
                seen, since = len(self.forces), time.monotonic()

    def wait(self, condition: Callable[[], bool], what: str, patience: float = DISCOVERY) -> None:
        """Listens until a condition holds.

        Raises:
            InputError: where it does not hold in time, or the estimator has ended; ``what`` was waited for.
        """
        end = time.monotonic() + patience
        while not condition():
            if self._process is not None and self._process.poll() is not None:
                raise InputError(f"the estimator ended while {what} was waited for; it said why")
            if time.monotonic() > end:
                raise InputError(
                    f"waited {patience:g} s for {what}; is the estimator running with the same ROS_DOMAIN_ID?"
                )
            self._executor.spin_once(timeout_sec=0.05)

    def close(self) -> None:
        """Leaves the ROS graph."""
        self._executor.shutdown()
        self._node.destroy_node()


def _hears_and_is_heard(health: DiagnosticArray, topics: Container[str]) -> bool:
    told = [{pair.key: pair.value for pair in status.values} for status in health.status]
    heard = [own[PUBLISHERS] for own in told if PUBLISHERS in own and own["topic"] in topics]
    return "0" not in heard and any(own.get(SUBSCRIBERS, "0") != "0" for own in told)
