"""The topic ``~/force``."""

from typing import Any

from damper_msgs.msg import DamperForces
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.publisher import Publisher

from damper_estimator.node.ports import Keep, PublishingNode
from damper_estimator.node.quality_of_service import OVERRIDABLE

DEPTH = 100


class ForcePublisher:
    """Publishes, counts and records serialised forces; final.

    Attributes:
        published: number of messages.
        incompatible: subscribers that request more than the offered quality of service.
    """

    def __init__(self, node: PublishingNode, keep: Keep) -> None:
        self._node, self._keep = node, keep
        self._publisher: Publisher | None = None
        self.published = self.incompatible = 0

    def open(self) -> None:
        """Creates the topic."""
        events = PublisherEventCallbacks(incompatible_qos=self._note_incompatible)
        self._publisher = self._node.create_publisher(
            DamperForces, "~/force", DEPTH, event_callbacks=events, qos_overriding_options=OVERRIDABLE
        )

    def close(self) -> None:
        """Destroys the topic."""
        if self._publisher is not None:
            self._node.destroy_publisher(self._publisher)
            self._publisher = None

    def publish(self, message: bytes) -> None:
        """Publishes and records serialised forces; only between `open` and `close`."""
        self._publisher.publish(message)
        self.published += 1
        self._keep(self._publisher, "damper_msgs/msg/DamperForces", message)

    @property
    def topic(self) -> str:
        """Resolved name."""
        return self._publisher.topic_name

    @property
    def subscribers(self) -> int:
        """Their present number."""
        return self._publisher.get_subscription_count()

    def _note_incompatible(self, event: Any) -> None:
        self.incompatible = event.total_count
