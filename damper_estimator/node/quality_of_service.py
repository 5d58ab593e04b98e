"""Quality of service: which policies are parameters, and the offer to drivers."""

from rclpy.duration import Duration
from rclpy.qos import LivelinessPolicy, QoSProfile
from rclpy.qos_overriding_options import QoSOverridingOptions

OVERRIDABLE = QoSOverridingOptions.with_default_policies()
"""Depth, history and reliability by parameter: ``qos_overrides./topic.publisher.depth`` and so on."""

DEADLINE = 0.2  # s, longest pause between two commands
LEASE = 1.0  # s after which a process that was killed, or its machine, counts as gone


def offered(depth: int) -> QoSProfile:
    """The offer to drivers; a subscription with the default policies requests none of it and still matches."""
    return QoSProfile(
        depth=depth,
        deadline=Duration(seconds=DEADLINE),
        liveliness=LivelinessPolicy.AUTOMATIC,
        liveliness_lease_duration=Duration(seconds=LEASE),
    )
