"""Serialises many messages at once: from one template, with the varying numbers patched in."""

from collections.abc import Mapping, Sequence

import numpy as np
from rosbags.interfaces import Nodetype

from damper_estimator.recordings.cdr_layout import layout_of
from damper_estimator.recordings.decode import NANOSECONDS
from damper_estimator.recordings.definitions import NUMBERS, Definition, builtin_schema, builtin_store, definition_of
from damper_estimator.recordings.field_path import FieldPath, parse_path, request_tree

_STAMP = "header.stamp"


def encode(type_name: str, count: int, fields: Mapping[str, object]) -> list[bytes]:
    """Serialises ``count`` messages of a built-in type (CDR, little endian); omitted fields are zero or empty.

    Args:
        type_name: such as ``sensor_msgs/msg/JointState``.
        count: number of messages n.
        fields: by path. Numbers: an array (n,), or (n, k) for a field of k elements. Texts: a string or a sequence of
            strings, the same in every message. ``header.stamp``: (n,) int64, ns.

    Raises:
        InputError: for a type that neither ROS 2 Jazzy nor this project has.
        ValueError: for a field that the type lacks, or an array of another length.
    """
    definition = definition_of(builtin_schema(type_name))
    columns = {path: value for path, value in fields.items() if not _is_text(value)}
    texts = {path: value for path, value in fields.items() if _is_text(value)}
    numbers = _split_stamp({path: np.asarray(value) for path, value in columns.items()})
    for path, column in numbers.items():
        if column.ndim not in (1, 2) or len(column) != count:
            raise ValueError(f"{path}: shape {column.shape} does not fit {count} messages")
    if count == 0:
        return []
    template = _template(definition, texts, numbers)
    matrix = np.tile(np.frombuffer(template, np.uint8), (count, 1))
    paths = [parse_path(path) for path in numbers]
    layout = layout_of(template, definition, request_tree(paths), len(paths))
    for leaf, column in zip(layout.leaves, numbers.values(), strict=True):
        if leaf.count:
            leaf.write(matrix, column)
    flat, size = matrix.tobytes(), len(template)
    return [flat[start : start + size] for start in range(0, count * size, size)]


def _is_text(value: object) -> bool:
    return isinstance(value, str) or (isinstance(value, list | tuple) and all(isinstance(item, str) for item in value))


def _split_stamp(columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    if _STAMP not in columns:
        return columns
    seconds, nanoseconds = np.divmod(columns[_STAMP].astype(np.int64), NANOSECONDS)
    rest = {path: column for path, column in columns.items() if path != _STAMP}
    return {f"{_STAMP}.sec": seconds, f"{_STAMP}.nanosec": nanoseconds, **rest}


def _template(definition: Definition, texts: Mapping[str, object], numbers: Mapping[str, np.ndarray]) -> bytes:
    message = _blank(definition, (Nodetype.NAME, definition.type))
    for path, value in texts.items():
        _set(message, parse_path(path), value if isinstance(value, str) else list(value))
    for path, column in numbers.items():
        if column.ndim == 2:
            _set(message, parse_path(path), np.zeros(column.shape[1]))
    return bytes(builtin_store().serialize_cdr(message, definition.type, little_endian=True))


def _blank(definition: Definition, description: tuple) -> object:
    """The zero or empty value of a field, in the form of rosbags."""
    kind, detail = description
    if kind == Nodetype.NAME:
        fields = {name: _blank(definition, inner) for name, inner in definition.fields(detail)}
        return builtin_store().types[detail](**fields)
    if kind == Nodetype.BASE:
        return "" if detail[0] == "string" else 0
    element, size = detail
    size = size if kind == Nodetype.ARRAY else 0
    if element[0] == Nodetype.BASE and element[1][0] in NUMBERS:
        return np.zeros(size, NUMBERS[element[1][0]])
    return [_blank(definition, element) for _ in range(size)]


def _set(message: object, path: FieldPath, value: object) -> None:
    for step in path.steps[:-1]:
        message = getattr(message, step.field)
    name = path.steps[-1].field
    before = getattr(message, name, None)
    if before is None:
        raise ValueError(f"{path.text}: {type(message).__name__} has no such field")
    setattr(message, name, value.astype(before.dtype) if isinstance(value, np.ndarray) else value)


def joint_states(
    names: Sequence[str],
    stamps: np.ndarray,
    position: np.ndarray | None = None,
    velocity: np.ndarray | None = None,
    effort: np.ndarray | None = None,
) -> list[bytes]:
    """``sensor_msgs/msg/JointState``: k names, stamps (n,) ns, arrays (n, k); omitted ones are empty."""
    arrays = {"position": position, "velocity": velocity, "effort": effort}
    given = {field: array for field, array in arrays.items() if array is not None}
    return encode("sensor_msgs/msg/JointState", len(stamps), {"header.stamp": stamps, "name": list(names), **given})


def floats(values: np.ndarray) -> list[bytes]:
    """``std_msgs/msg/Float64``: values (n,)."""
    return encode("std_msgs/msg/Float64", len(values), {"data": values})


def temperatures(stamps: np.ndarray, celsius: np.ndarray) -> list[bytes]:
    """``sensor_msgs/msg/Temperature``: stamps (n,) ns, temperature (n,) deg C."""
    return encode("sensor_msgs/msg/Temperature", len(stamps), {"header.stamp": stamps, "temperature": celsius})


def pressures(stamps: np.ndarray, pascal: np.ndarray) -> list[bytes]:
    """``sensor_msgs/msg/FluidPressure``: stamps (n,) ns, pressure (n,) Pa."""
    return encode("sensor_msgs/msg/FluidPressure", len(stamps), {"header.stamp": stamps, "fluid_pressure": pascal})


def accelerations(stamps: np.ndarray, vertical: np.ndarray) -> list[bytes]:
    """``geometry_msgs/msg/AccelStamped``: stamps (n,) ns, ``accel.linear.z`` (n,) m/s^2."""
    return encode("geometry_msgs/msg/AccelStamped", len(stamps), {"header.stamp": stamps, "accel.linear.z": vertical})


def damper_forces(names: Sequence[str], stamps: np.ndarray, fields: Mapping[str, np.ndarray]) -> list[bytes]:
    """``damper_msgs/msg/DamperForces``: k names, stamps (n,) ns, arrays (n, k) by field.

    Omitted number fields are NaN (not available), ``status`` is 0 (GOOD).
    """
    shape = (len(stamps), len(names))
    definition = definition_of(builtin_schema("damper_msgs/msg/DamperForces"))
    arrays = {
        name: np.full(shape, np.nan) if description[1][0][1][0] == "float64" else np.zeros(shape, np.uint8)
        for name, description in definition.fields(definition.type)
        if description[0] == Nodetype.SEQUENCE and name != "name"
    }
    unknown = sorted(fields.keys() - arrays.keys())
    if unknown:
        raise ValueError(f"DamperForces has no field {', '.join(unknown)}; there are {', '.join(arrays)}")
    return encode(definition.type, len(stamps), {"header.stamp": stamps, "name": list(names), **arrays, **fields})
