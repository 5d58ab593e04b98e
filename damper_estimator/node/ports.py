"""The interfaces through which the parts of the estimator's node use it: narrow views of rclpy's ``Node``, and the
state that the node sets and its parts read.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from rclpy.clock import Clock
from rclpy.context import Context
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.subscription import Subscription

from damper_estimator.node.estimation import Estimation
from damper_estimator.node.rclpy_private import RcutilsLogger
from damper_estimator.node.recorder import Recorder

# Records publisher, type and bytes of a published message.
Keep = Callable[[Publisher, str, bytes], None]


@dataclass(slots=True)
class NodeState:
    """The present state of the node, which alone changes it.

    Attributes:
        estimation: of the present settings; None until the node is configured.
        recorder: None unless the node records.
        is_active: whether the node publishes.
        refusal: why the last transition was refused, in one line.
    """

    estimation: Estimation | None = None
    recorder: Recorder | None = None
    is_active: bool = False
    refusal: str = ""


class LoggingNode(Protocol):
    """A node with a context and a logger."""

    @property
    def context(self) -> Context: ...

    def get_logger(self) -> RcutilsLogger: ...


class SubscribingNode(LoggingNode, Protocol):
    """What `Inputs` use of a node."""

    def create_subscription(
        self,
        msg_type: Any,
        topic: str,
        callback: Callable[..., None],
        qos_profile: QoSProfile,
        *,
        event_callbacks: SubscriptionEventCallbacks | None = None,
        qos_overriding_options: QoSOverridingOptions | None = None,
        raw: bool = False,
    ) -> Subscription: ...

    def destroy_subscription(self, subscription: Subscription) -> bool: ...

    def resolve_topic_name(self, topic: str) -> str: ...

    def get_clock(self) -> Clock: ...


class PublishingNode(LoggingNode, Protocol):
    """What the outputs use of a node."""

    def create_publisher(
        self,
        msg_type: Any,
        topic: str,
        qos_profile: QoSProfile | int,
        *,
        event_callbacks: PublisherEventCallbacks | None = None,
        qos_overriding_options: QoSOverridingOptions | None = None,
    ) -> Publisher: ...

    def destroy_publisher(self, publisher: Publisher) -> bool: ...


class NamedNode(LoggingNode, Protocol):
    """What `Reporter` uses of a node."""

    def get_fully_qualified_name(self) -> str: ...

    def resolve_topic_name(self, topic: str) -> str: ...

    def get_publishers_info_by_topic(self, topic_name: str) -> Sequence[Any]: ...
