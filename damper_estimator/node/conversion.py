"""Messages to numbers and back; the only place that knows the fields of ROS messages."""

from array import array
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from damper_msgs.msg import DamperForces
from sensor_msgs.msg import FluidPressure, JointState, Temperature
from std_msgs.msg import Float64, Header

from damper_estimator.errors import InputError
from damper_estimator.recordings import FieldPath, parse_path
from damper_estimator.signals import Channel

TYPES = {"displacement": JointState, "command": Float64, "temperature": Temperature, "pressure": FluidPressure}
NANOSECONDS = 1_000_000_000


def stamp_ns(stamp: Time) -> int:
    """Time stamp in ns."""
    return stamp.sec * NANOSECONDS + stamp.nanosec


def live_path(role: str, channel: Channel) -> FieldPath:
    """The channel's field path, held against the message type that the node subscribes for this role.

    Raises:
        InputError: where the type has no such field.
    """
    path = parse_path(channel.field)
    fields = TYPES[role].get_fields_and_field_types()
    if path.steps[0].field not in fields or (role == "displacement") != (path.steps[0].index is not None):
        raise InputError(
            f"{role} on {channel.topic}: field {channel.field!r} is not a number of "
            f"{TYPES[role].__module__.split('.')[0]}/"
            f"{TYPES[role].__name__}, which the node subscribes there; its fields are {', '.join(fields)}"
        )
    return path


def number_at(message: Any, path: FieldPath, places: Mapping[str, int]) -> float | None:
    """The number that the path leads to; None where the message has no such name or index.

    ``places`` gives the index of each entry of the message's ``name[]``.
    """
    value = message
    for step in path.steps:
        value = getattr(value, step.field)
        if step.index is None:
            continue
        index = places.get(step.index) if isinstance(step.index, str) else step.index
        if index is None or index >= len(value):
            return None
        value = value[index]
    return value


def places_by_name(names: Sequence[str]) -> dict[str, int]:
    """Index by name; of equal names the first counts."""
    return {name: index for index, name in reversed(list(enumerate(names)))}


def forces_message(header: Header, names: Sequence[str], fields: Mapping[str, np.ndarray]) -> DamperForces:
    """The message with the input's header; ``fields`` as in ``Estimates.fields``, each (len(names),)."""
    message = DamperForces(header=header, name=list(names))
    for field, values in fields.items():
        code = "B" if field == "status" else "d"
        setattr(message, field, array(code, values.tobytes()))
    return message
