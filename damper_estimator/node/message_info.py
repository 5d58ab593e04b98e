"""What the middleware says of a message: its publisher's number for it, when it came; with both rclpy executors.

A callback with two parameters gets the message and what the middleware says of it. ``SingleThreadedExecutor`` calls it
with two arguments; ``EventsExecutor`` (rclpy 7.1) passes both as one tuple. This is the one place that knows.
"""

from collections.abc import Callable
from inspect import Parameter, Signature

_TWO = Signature([Parameter(name, Parameter.POSITIONAL_ONLY) for name in ("message", "info")])


def with_info(take: Callable[[bytes, int | None, int], None]) -> Callable:
    """A callback of a raw subscription that gives ``take`` the bytes, the publisher's sequence number (None where the
    middleware has none; it rises by one per message), and when the message came, in ns of this machine's clock (0 where
    the middleware does not say)."""

    def receive(*given: object) -> None:
        message, info = given if len(given) == 2 else given[0]
        take(message, info["publication_sequence_number"], info["received_timestamp"])

    receive.__signature__ = _TWO  # by this rclpy decides what to pass
    return receive
