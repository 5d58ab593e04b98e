"""The middleware's information about a message: sequence number and time of receipt; for both rclpy executors.

A callback with two parameters receives the message and this information. ``SingleThreadedExecutor`` calls it with two
arguments; ``EventsExecutor`` (rclpy 7.1) passes both as one tuple. Only this module depends on that.
"""

from collections.abc import Callable
from inspect import Parameter, Signature

_TWO = Signature([Parameter(name, Parameter.POSITIONAL_ONLY) for name in ("message", "info")])


def with_info(take: Callable[[bytes, int | None, int], None]) -> Callable:
    """A callback of a raw subscription that passes ``take`` the bytes, the publisher's sequence number (None if the
    middleware has none; it rises by one per message), and the time of receipt in ns of this machine's clock (0 if the
    middleware does not report it).
    """

    def receive(*given: object) -> None:
        message, info = given if len(given) == 2 else given[0]
        take(message, info["publication_sequence_number"], info["received_timestamp"])

    receive.__signature__ = _TWO  # rclpy decides by it which arguments to pass
    return receive
