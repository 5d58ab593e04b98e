"""Field paths: ``position[front_left]``, ``effort[1]``, ``position["1"]``, ``accel.linear.z``, ``data``.

A number is a position; in quotation marks, with the escapes of JSON, any text is a name.
"""

import json
import re
from collections.abc import Iterable
from dataclasses import dataclass

from rosbags.interfaces import Nodetype

from damper_estimator.errors import InputError
from damper_estimator.recordings.definitions import NUMBERS, Definition

_STEP = re.compile(r'([A-Za-z]\w*)(?:\[(?:("(?:[^"\\]|\\.)*")|([^\[\]]+))\])?(?:\.(?=.)|$)')


@dataclass(frozen=True)
class Step:
    """One step of a path: a field, and one of its elements (by number, or by the entry of ``name[]``)."""

    field: str
    index: int | str | None = None


@dataclass(frozen=True)
class FieldPath:
    """A chain of names and indices that ends at one number of a message."""

    text: str
    steps: tuple[Step, ...]


def parse_path(text: str) -> FieldPath:
    """Splits ``accel.linear.z`` or ``position[front_left]`` into its steps.

    Raises:
        InputError: if the text is no such chain.
    """
    steps, position = [], 0
    while match := _STEP.match(text, position):
        field, quoted, index = match.groups()
        steps.append(Step(field, _unquoted(text, quoted) if quoted else _index(index)))
        position = match.end()
    if not steps or position != len(text):
        raise InputError(
            f'{text!r} is no field path; write for example "position[front_left]", "effort[1]" or "linear.z"'
        )
    return FieldPath(text, tuple(steps))


def _unquoted(text: str, quoted: str) -> str:
    try:
        return str(json.loads(quoted, strict=False))
    except ValueError as error:
        raise InputError(f"{text!r}: {quoted} is no name in quotation marks ({error})") from None


def _index(text: str | None) -> int | str | None:
    index = text.strip() if text else None
    return int(index) if index and index.isascii() and index.isdigit() else index


def check_path(path: FieldPath, definition: Definition) -> None:
    """Checks a path against a message type.

    Raises:
        InputError: if the type has no such field, or the path does not end at one number; names the existing fields.
    """
    description = (Nodetype.NAME, definition.type)
    for step in path.steps:
        description = _follow(path, step, description, definition)
    kind, detail = description
    if kind == Nodetype.NAME:
        raise _wrong(path, definition, f"ends at a {detail}; continue with {_listed(definition, detail)}")
    if kind in (Nodetype.ARRAY, Nodetype.SEQUENCE):
        raise _wrong(path, definition, f"is an array; add an index such as {path.text}[0] or {path.text}[front_left]")
    if detail[0] not in NUMBERS:
        raise _wrong(path, definition, f"is a {detail[0]}, not a number; choose a field of numbers")


def _follow(path: FieldPath, step: Step, description: tuple, definition: Definition) -> tuple:
    kind, type_name = description
    if kind != Nodetype.NAME:
        raise _wrong(path, definition, f"has {step.field!r} below a field without fields")
    fields = dict(definition.fields(type_name))
    if step.field not in fields:
        raise _wrong(path, definition, f"has no field {step.field!r}; there are {_listed(definition, type_name)}")
    kind, detail = fields[step.field]
    if step.index is None:
        return kind, detail
    if kind not in (Nodetype.ARRAY, Nodetype.SEQUENCE):
        raise _wrong(path, definition, f"gives an index to {step.field!r}, which is no array; leave the index out")
    element, size = detail
    if kind == Nodetype.ARRAY and isinstance(step.index, int) and step.index >= size:
        raise _wrong(
            path, definition, f"has index {step.index}, but {step.field!r} has {size} elements (0 to {size - 1})"
        )
    return element


def _listed(definition: Definition, type_name: str) -> str:
    return ", ".join(name for name, _ in definition.fields(type_name))


def _wrong(path: FieldPath, definition: Definition, what: str) -> InputError:
    return InputError(f'field "{path.text}" of {definition.type} {what}')


def request_tree(paths: Iterable[FieldPath]) -> dict:
    """Nested ``{field: {index: ...}}``; a branch ends in the list of positions that its path has in ``paths``."""
    tree: dict = {}
    for slot, path in enumerate(paths):
        branch = tree
        for step in path.steps[:-1]:
            branch = branch.setdefault(step.field, {}).setdefault(step.index, {})
        last = path.steps[-1]
        branch.setdefault(last.field, {}).setdefault(last.index, []).append(slot)
    return tree
