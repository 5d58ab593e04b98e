"""A recording: its topics, and its messages in arrival order."""

import heapq
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.recordings.batch import Batch, Columns, DecodingContext, joined_columns
from damper_estimator.recordings.library_errors import one_line
from damper_estimator.recordings.raw_messages import RawMessages, in_arrival_order, joined
from damper_estimator.recordings.storage_files import contents_of, open_storage

_BATCH = 65536
_BATCH_BYTES = 64 << 20  # for smaller batches of large messages (images)


@dataclass(frozen=True)
class Topic:
    """A topic of a recording: name, message type (such as ``sensor_msgs/msg/JointState``), number of messages."""

    name: str
    type: str
    messages: int


class Bag:
    """An opened recording; final. A context manager, created by `open_bag`.

    Attributes:
        path: as given.
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
        self._context = DecodingContext(str(path), connections, contents.compressed_messages)
        self.topics = _topics(connections)

    def __enter__(self) -> "Bag":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Closes the files, and deletes unpacked copies."""
        self._stack.close()

    def batches(self, topics: Iterable[str] | None = None, size: int = _BATCH, ends: bool = False) -> Iterator[Batch]:
        """The messages in arrival (log time) order over all files, equal times in the order of the files.

        Args:
            topics: to read (all); the leading `/` can be left out.
            size: maximum number of messages in a batch.
            ends: only the first and the last chunk, which suffices to find the time of recording.

        Raises:
            InputError: for an unknown topic (lists the existing ones), and for damaged files.
        """
        names = None if topics is None else [self.topic(name).name for name in topics]
        chosen = self._context.chosen(names)
        for rank, messages in _grouped(self._merged(ends), chosen, size):
            yield Batch(self._context, self._context.unpacked(messages), rank)

    def topic(self, name: str) -> Topic:
        """The topic of this name, with or without its leading ``/``.

        Raises:
            InputError: if it is not in the recording; lists the existing topics.
        """
        by_name = {topic.name: topic for topic in self.topics}
        for candidate in (name, f"/{name}", name.removeprefix("/")):
            if candidate in by_name:
                return by_name[candidate]
        existing = ", ".join(by_name) or "none at all"
        raise InputError(one_line(f"{self.path}: has no topic {name!r}; there are: {existing}"))

    def read(self, fields: Mapping[str, Iterable[str]]) -> dict[str, Columns]:
        """Several topics in one pass over the whole recording: field paths by topic to columns by topic.

        Raises:
            InputError: as `batches` and `Batch.columns`.
        """
        fields_by_topic = {name: tuple(paths) for name, paths in fields.items()}
        parts: dict[str, list[Columns]] = {name: [] for name in fields_by_topic}
        for name, paths in fields_by_topic.items():
            self._context.check(self.topic(name).name, paths)
        for batch in self.batches(fields_by_topic):
            for name, paths in fields_by_topic.items():
                parts[name].append(batch.columns(name, paths))
        return {name: joined_columns(parts[name], len(paths)) for name, paths in fields_by_topic.items()}

    def columns(self, topic: str, paths: Iterable[str]) -> Columns:
        """Fields of one topic over the whole recording.

        Raises:
            InputError: as `batches` and `Batch.columns`.
        """
        return self.read({topic: paths})[topic]

    def _merged(self, ends: bool) -> Iterator[RawMessages]:
        """All messages, or the first and the last, in arrival order; connections are numbered over all files."""
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
        InputError: if it is missing, unreadable, cut off, damaged or no recording; with the remedy.
    """
    return Bag(path)


def _topics(connections: Iterable) -> tuple[Topic, ...]:
    found: dict[str, Topic] = {}
    for connection in connections:
        name = connection.topic
        before = found[name].messages if name in found else 0
        found[name] = Topic(name, connection.schema.type, before + connection.messages)
    return tuple(found[name] for name in sorted(found))


def _grouped(merged: Iterable[RawMessages], chosen: np.ndarray, size: int) -> Iterator[tuple[np.ndarray, RawMessages]]:
    """Ranks and messages of the ``chosen`` connections in groups of ``size``, fewer if they are large."""
    waiting: list[tuple[np.ndarray, RawMessages]] = []
    seen, count, bulk = 0, 0, 0
    for messages in merged:
        rows = np.flatnonzero(chosen[messages.connection])
        rank, seen = rows + seen, seen + len(messages)
        while len(rows):
            free = size - count
            part, rows = rows[:free], rows[free:]
            waiting.append((rank[:free], messages.chosen(part)))
            rank = rank[free:]
            count += len(part)
            bulk += len(messages.data)
            if count >= size or bulk >= _BATCH_BYTES:
                yield _as_one(waiting)
                waiting, count, bulk = [], 0, 0
    if waiting:
        yield _as_one(waiting)


def _as_one(parts: list[tuple[np.ndarray, RawMessages]]) -> tuple[np.ndarray, RawMessages]:
    return np.concatenate([rank for rank, _ in parts]), joined([messages for _, messages in parts])
