"""Bytes that can follow a message: the one rule, live and offline.

ROS readers ignore bytes after the last field, and three sources leave some there:

- RTPS rounds the payload up to a multiple of four bytes: up to three bytes of any content.
- ``rmw_serialize`` of Fast DDS (rclpy's ``serialize_message``, rosbag2 if it serialises) returns a buffer of a
  previously estimated size. The estimate aligns every sequence of 8-byte numbers, the message only those that
  are not empty: up to four bytes too many per such sequence (JointState 12, DamperForces 36, measured). They are not
  initialised and can have any content.
- Buffers of a fixed size, filled with zeros.

So bytes of any content are padding up to the sum of the first two, and zeros in any number. More than that is content:
the message is of another type than its definition, and its fields would be misread.
"""

_ALIGNMENT = 3
_PER_SEQUENCE = 4


def allowance(sequences: int) -> int:
    """Bytes of any content that can follow a message with this number of sequences of 8-byte numbers."""
    return _ALIGNMENT + _PER_SEQUENCE * sequences


def is_padding(data: bytes, end: int, allowed: int) -> bool:
    """Whether the bytes after the first ``end`` are only padding; ``allowed`` is the `allowance`."""
    spare = len(data) - end
    return 0 <= spare <= allowed or (spare > 0 and data.count(0, end) == spare)
