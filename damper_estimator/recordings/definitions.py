"""Message definitions: from the bag's schema, else those of ROS 2 Jazzy and of this project."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, TypesysError, get_types_from_idl, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from damper_estimator.errors import InputError
from damper_estimator.recordings.library_errors import LIBRARY_ERRORS, explained
from damper_estimator.share import share_path

DAMPER_FORCES, DAMPER_COMMAND = "damper_msgs/msg/DamperForces", "damper_msgs/msg/DamperCommand"

# CDR numbers; bool, byte and char are bytes.
NUMBERS: Mapping[str, np.dtype] = {
    name: np.dtype(code)
    for name, code in {
        "bool": "u1", "byte": "u1", "octet": "u1", "char": "u1", "uint8": "u1", "int8": "i1",
        "uint16": "u2", "int16": "i2", "uint32": "u4", "int32": "i4", "uint64": "u8", "int64": "i8",
        "float32": "f4", "float64": "f8",
    }.items()
}  # fmt: skip


_TYPE = re.compile(r"[A-Za-z]\w*(/[A-Za-z]\w*){1,2}", re.ASCII)
_NAME = re.compile(r"[A-Za-z]\w*", re.ASCII)


@dataclass(frozen=True)
class Schema:
    """A message type in a recording; ``encoding`` and ``text`` are empty if it contains no definition."""

    type: str
    encoding: str = ""
    text: str = ""


@dataclass(frozen=True, eq=False)
class Definition:
    """The fields of a message type and of all types that it contains.

    Attributes:
        type: such as ``sensor_msgs/msg/JointState``.
        types: fields by type name, in the form of rosbags: ``(constants, [(field, description)])``.
    """

    type: str
    types: Mapping[str, tuple]

    def fields(self, type_name: str) -> list[tuple]:
        """``(field, description)`` in order; a type without fields is serialised as one byte."""
        return self.types[type_name][1] or [("structure_needs_at_least_one_member", (Nodetype.BASE, ("uint8", 0)))]


def field_types(fields: list[tuple]) -> Iterator[str]:
    """The names of the message types among a list of fields."""
    for _, (kind, detail) in fields:
        if kind in (Nodetype.ARRAY, Nodetype.SEQUENCE):
            kind, detail = detail[0]
        if kind == Nodetype.NAME:
            yield detail


@cache
def builtin_store() -> Typestore:
    """The message types of ROS 2 Jazzy and of this project."""
    store = get_typestore(Stores.ROS2_JAZZY)
    for name in (DAMPER_FORCES, DAMPER_COMMAND):
        path = share_path(f"msg_defs/msg/{name.rpartition('/')[2]}.msg")
        with explained(path, "install the package again"):
            store.register(get_types_from_msg(path.read_text(encoding="utf-8"), name))
    return store


@cache
def definition_of(schema: Schema) -> Definition:
    """The definition of a message type; a recording's schema takes precedence over the built-in one.

    Raises:
        InputError: if neither knows the type; the text lacks the topic, which the caller adds.
    """
    types = _types_of_recording(schema) or _builtin_types(schema)
    pending, complete = [schema.type], {}
    while pending:
        name = pending.pop()
        if name not in complete:
            complete[name] = _checked(name, _fields_of(name, types, schema))
            pending += field_types(complete[name][1])
    return Definition(schema.type, complete)


def _types_of_recording(schema: Schema) -> dict:
    try:
        if schema.encoding == "ros2msg":
            types = get_types_from_msg(schema.text, schema.type)
        elif schema.encoding == "ros2idl":
            types = _idl_types(schema.text)
        else:
            return {}
    except (TypesysError, *LIBRARY_ERRORS):  # the built-in definition can still fit
        return {}
    return types if schema.type in types else {}


def _idl_types(text: str) -> dict:
    types = {}
    for part in text.split("=" * 80 + "\n"):
        body = part.split("\n", 1)[1] if part.startswith("IDL: ") else part
        if body.strip():
            types.update(get_types_from_idl(body))
    return types


def _builtin_types(schema: Schema) -> dict:
    if schema.type in builtin_store().fielddefs:
        return builtin_store().fielddefs
    if schema.type.endswith("_Event"):
        raise InputError(f"{schema.type} is a service event, whose definition cannot be read; use another topic")
    what = "has a definition that cannot be read" if schema.text else "has no definition in the bag"
    raise InputError(f"{schema.type} {what} and is not a type of ROS 2 Jazzy; record it with rosbag2's mcap storage")


def _fields_of(name: str, types: dict, schema: Schema) -> tuple:
    found = types.get(name) or builtin_store().fielddefs.get(name)
    if found is None:
        raise InputError(
            f"{schema.type} needs {name}, which the bag does not define; record it with rosbag2's mcap storage"
        )
    return found


def _checked(name: str, fields: tuple) -> tuple:
    """The fields of a type. Whole messages are decoded by generated Python code, so names must be valid."""
    wrong = [] if _TYPE.fullmatch(name) else [name]
    wrong += [name for name in (*(c[0] for c in fields[0]), *(f[0] for f in fields[1])) if not _NAME.fullmatch(name)]
    if wrong:
        raise InputError(f"{wrong[0][:50]!r} is no name of a type or field in ROS 2; the bag is damaged")
    return fields


@cache
def store_of(schema: Schema) -> Typestore:
    """A rosbags type store that decodes this one type, for whole messages."""
    store = Typestore()
    store.register(dict(definition_of(schema).types))
    return store


@cache
def builtin_schema(type_name: str) -> Schema:
    """The full definition of a built-in type as text, its parts concatenated as in an mcap file.

    Raises:
        InputError: for a type that neither ROS 2 Jazzy nor this project has.
    """
    _builtin_types(Schema(type_name))
    return Schema(type_name, "ros2msg", builtin_store().generate_msgdef(type_name, ros_version=2)[0])
