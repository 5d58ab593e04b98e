"""Quality of service: what may be set from outside, and what is offered to drivers."""

from rclpy.duration import Duration
from rclpy.qos import LivelinessPolicy, QoSProfile
from rclpy.qos_overriding_options import QoSOverridingOptions

OVERRIDABLE = QoSOverridingOptions.with_default_policies()
"""Depth, history and reliability by parameter: ``qos_overrides./topic.publisher.depth`` and so on."""

DEADLINE = 0.2  # s, longest pause between two commands while there is something to command
LEASE = 1.0  # s after which a process that was killed, or its machine, counts as gone


def offered(depth: int) -> QoSProfile:
    """What is offered to drivers; a subscription with the defaults asks for none of it and matches all the same."""
    return QoSProfile(
        depth=depth,
        deadline=Duration(seconds=DEADLINE),
        liveliness=LivelinessPolicy.AUTOMATIC,
        liveliness_lease_duration=Duration(seconds=LEASE),
    )
