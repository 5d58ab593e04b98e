"""A recording: what is in it, and its messages in arrival order."""

import heapq
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.recordings.batch import Batch, Columns, Reading, joined_columns
from damper_estimator.recordings.faults import one_line
from damper_estimator.recordings.folder import contents_of, open_storage
from damper_estimator.recordings.raw import RawMessages, in_arrival_order, joined

_BATCH = 65536
_BATCH_BYTES = 64 << 20  # large messages (images) make smaller batches


@dataclass(frozen=True)
class Topic:
    """A topic of a recording: name, message type (such as ``sensor_msgs/msg/JointState``), number of messages."""

    name: str
    type: str
    messages: int


class Bag:
    """An opened recording; final. Use it as a context manager; made by `open_bag`.

    Attributes:
        path: as it was given.
        topics: sorted by name.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        contents = contents_of(self.path)
        with ExitStack() as stack:
            scratch = Path(stack.enter_context(TemporaryDirectory(prefix="damper_estimator_")))
            self._files = []
            for file in contents.files:
                self._files.append(open_storage(file, scratch))
                stack.callback(self._files[-1].close)
            self._stack = stack.pop_all()
        connections = tuple(connection for file in self._files for connection in file.connections)
        self._reading = Reading(str(path), connections, contents.compressed_messages)
        self.topics = _topics(connections)

    def __enter__(self) -> "Bag":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Closes the files; unpacked copies vanish."""
        self._stack.close()

    def batches(self, topics: Iterable[str] | None = None, size: int = _BATCH, ends: bool = False) -> Iterator[Batch]:
        """The messages in arrival (log time) order over all files, equal times as they lie in the files.

        Args:
            topics: which (all); `/` in front may be left out.
            size: most messages in a batch.
            ends: only the first and the last chunk, which is enough to see when it was recorded.

        Raises:
            InputError: for a topic that is not there (lists those that are), and for damaged files.
        """
        names = None if topics is None else [self.topic(name).name for name in topics]
        wanted = self._reading.chosen(names)
        for rank, messages in _grouped(self._merged(ends), wanted, size):
            yield Batch(self._reading, self._reading.unpacked(messages), rank)

    def topic(self, name: str) -> Topic:
        """The topic of this name, with or without its leading ``/``.

        Raises:
            InputError: if it is not in the recording; lists what is.
        """
        by_name = {topic.name: topic for topic in self.topics}
        for candidate in (name, f"/{name}", name.removeprefix("/")):
            if candidate in by_name:
                return by_name[candidate]
        there = ", ".join(by_name) or "none at all"
        raise InputError(one_line(f"{self.path}: has no topic {name!r}; there are: {there}"))

    def read(self, fields: Mapping[str, Iterable[str]]) -> dict[str, Columns]:
        """Several topics in one pass over the whole recording: field paths by topic to columns by topic.

        Raises:
            InputError: as `batches` and `Batch.columns`.
        """
        wanted = {name: tuple(paths) for name, paths in fields.items()}
        parts: dict[str, list[Columns]] = {name: [] for name in wanted}
        for name, paths in wanted.items():
            self._reading.check(self.topic(name).name, paths)
        for batch in self.batches(wanted):
            for name, paths in wanted.items():
                parts[name].append(batch.columns(name, paths))
        return {name: joined_columns(parts[name], len(paths)) for name, paths in wanted.items()}

    def columns(self, topic: str, paths: Iterable[str]) -> Columns:
        """Fields of one topic over the whole recording.

        Raises:
            InputError: as `batches` and `Batch.columns`.
        """
        return self.read({topic: paths})[topic]

    def _merged(self, ends: bool) -> Iterator[RawMessages]:
        """All messages, or the first and the last, in arrival order; connections are counted over all files."""
        shifts = np.cumsum([0, *(len(file.connections) for file in self._files)])
        spans = heapq.merge(
            *(file.spans(number) for number, file in enumerate(self._files)), key=lambda span: span.start
        )
        if ends:
            every = list(spans)
            spans = iter(every[:1] + every[1:][-1:])
        return in_arrival_order(spans, shifts)


def open_bag(path: str | Path) -> Bag:
    """Opens an ``.mcap`` file or a rosbag2 folder (mcap or sqlite3; split; zstd), without ROS.

    Raises:
        InputError: if it is missing, unreadable, cut off, damaged or no recording; says which and what to do.
    """
    return Bag(path)


def _topics(connections: Iterable) -> tuple[Topic, ...]:
    found: dict[str, Topic] = {}
    for connection in connections:
        name = connection.topic
        before = found[name].messages if name in found else 0
        found[name] = Topic(name, connection.schema.type, before + connection.messages)
    return tuple(found[name] for name in sorted(found))


def _grouped(merged: Iterable[RawMessages], wanted: np.ndarray, size: int) -> Iterator[tuple[np.ndarray, RawMessages]]:
    """Ranks and messages of the wanted connections in groups of ``size``, fewer where they are large."""
    held: list[tuple[np.ndarray, RawMessages]] = []
    seen, count, bulk = 0, 0, 0
    for messages in merged:
        rows = np.flatnonzero(wanted[messages.connection])
        rank, seen = rows + seen, seen + len(messages)
        while len(rows):
            room = size - count
            part, rows = rows[:room], rows[room:]
            held.append((rank[:room], messages.chosen(part)))
            rank = rank[room:]
            count += len(part)
            bulk += len(messages.data)
            if count >= size or bulk >= _BATCH_BYTES:
                yield _together(held)
                held, count, bulk = [], 0, 0
    if held:
        yield _together(held)


def _together(held: list[tuple[np.ndarray, RawMessages]]) -> tuple[np.ndarray, RawMessages]:
    return np.concatenate([rank for rank, _ in held]), joined([messages for _, messages in held])
