"""Serialised ``damper_msgs/DamperCommand``: the commands, and the sample that they answer. Independent of ROS."""

from collections.abc import Sequence
from itertools import groupby

import numpy as np

from damper_estimator.node.force_follower import FOLLOWED, LIMITED, Command
from damper_estimator.recordings import encode, parse_path
from damper_estimator.recordings.cdr_layout import layout_of
from damper_estimator.recordings.definitions import builtin_schema, definition_of
from damper_estimator.recordings.field_path import request_tree

COMMAND_TYPE = "damper_msgs/msg/DamperCommand"
_NUMBERS = ("current", "desired_force", "achievable_force")
_MOST_TEMPLATES = 64


class CommandMessages:
    """Numbers and serialises the messages; final."""

    def __init__(self) -> None:
        self._sequence = 0
        self._templates: dict[tuple[str, ...], _Template] = {}

    def of(self, commands: Sequence[Command]) -> list[bytes]:
        """One message per stamp for all commands that answer it, oldest first."""
        messages = []
        for stamp, group in groupby(sorted(commands, key=lambda command: command.stamp), lambda c: c.stamp):
            together = list(group)
            names = tuple(command.damper for command in together)
            if names not in self._templates:
                if len(self._templates) >= _MOST_TEMPLATES:
                    self._templates.clear()
                self._templates[names] = _Template(names)
            self._sequence += 1
            messages.append(self._templates[names].message(stamp, self._sequence, together))
        return messages


class _Template:
    """A message for given dampers, to be filled; final."""

    def __init__(self, names: Sequence[str]) -> None:
        k = len(names)
        arrays = {field: np.zeros((1, k)) for field in _NUMBERS}
        bytes_ = {field: np.zeros((1, k), np.uint8) for field in ("source", "valid")}
        stamp = {"header.stamp": np.zeros(1, np.int64), "sequence": np.zeros(1, np.uint64)}
        (plain,) = encode(COMMAND_TYPE, 1, {"name": list(names), **stamp, **arrays, **bytes_})
        self._buffer = bytearray(plain)
        first = [f"{field}[0]" for field in (*_NUMBERS, "source", "valid")]
        paths = [parse_path(p) for p in ("header.stamp.sec", "header.stamp.nanosec", "sequence", *first)]
        leaves = layout_of(plain, definition_of(builtin_schema(COMMAND_TYPE)), request_tree(paths), len(paths)).leaves
        self._seconds, self._nanoseconds, self._sequence = (
            np.ndarray((), leaf.dtype, self._buffer, leaf.offset) for leaf in leaves[:3]
        )
        self._columns = [np.ndarray((k,), leaf.dtype, self._buffer, leaf.offset) for leaf in leaves[3:]]

    def message(self, stamp: int, sequence: int, commands: Sequence[Command]) -> bytes:
        self._seconds[...], self._nanoseconds[...] = divmod(stamp, 10**9)
        self._sequence[...] = sequence
        currents, desired, achievable, source, valid = self._columns
        for i, command in enumerate(commands):
            currents[i], desired[i], achievable[i] = command.current, command.desired, command.achievable
            source[i], valid[i] = command.source, command.source in (FOLLOWED, LIMITED)
        return bytes(self._buffer)
