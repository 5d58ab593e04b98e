"""Writes recordings: mcap files for rosbag2, Foxglove and PlotJuggler."""

from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
from mcap.writer import CompressionType, Writer

from damper_estimator import __version__
from damper_estimator.errors import InputError
from damper_estimator.files import replacing
from damper_estimator.recordings.batch import Batch
from damper_estimator.recordings.definitions import Schema, builtin_schema, builtin_store
from damper_estimator.recordings.encode import encode

# The default profile (reliable, volatile, last ten) as written by rosbag2 of Jazzy.
_QOS = """- history: keep_last
  depth: 10
  reliability: reliable
  durability: volatile
  deadline:
    sec: 9223372036
    nsec: 854775807
  lifespan:
    sec: 9223372036
    nsec: 854775807
  liveliness: automatic
  liveliness_lease_duration:
    sec: 9223372036
    nsec: 854775807
  avoid_ros_namespace_conventions: false"""


@dataclass(frozen=True, eq=False)
class Stream:
    """Serialised messages of a built-in type for one topic, at log times (n,) int64 ns that never step back."""

    topic: str
    type: str
    log: np.ndarray
    messages: Sequence[bytes]


class BagWriter:
    """Writes one ``.mcap`` file (ros2 profile, CDR, full schemas, zstd chunks); final; a context manager.

    The file is written next to its path and moved there when the block ends without an error; after an error nothing is
    left. Messages should come roughly in the order of their log times.

    Raises:
        InputError: if the path is no ``.mcap`` file or cannot be written.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        if self.path.suffix != ".mcap":
            raise InputError(f"{self.path}: recordings are written as mcap; give a name ending in .mcap")
        if not self.path.parent.is_dir():
            raise InputError(f"{self.path}: cannot be written (there is no folder {self.path.parent}); create it first")
        self._stack = ExitStack()

    def __enter__(self) -> "BagWriter":
        with ExitStack() as stack:
            partial = stack.enter_context(replacing(self.path))
            self._sink = _Sink(stack.enter_context(open(partial, "wb")))
            self._stack = stack.pop_all()
        return self

    def __exit__(self, *error: object) -> None:
        if error[0] is not None:
            self._stack.__exit__(*error)
            return
        with self._stack:
            self._sink.finish()

    def write_columns(self, topic: str, type_name: str, log: np.ndarray, fields: Mapping[str, object]) -> None:
        """Writes n messages of one shape; ``log`` (n,) int64 ns, ``fields`` as in `encode`."""
        self.write_messages(topic, type_name, log, encode(type_name, len(log), fields))

    def write_messages(self, topic: str, type_name: str, log: np.ndarray, messages: Sequence[bytes]) -> None:
        """Writes serialised messages of a built-in type at their log times (n,) int64 ns."""
        channel = self._sink.channel(topic, builtin_schema(type_name))
        for time, data in zip(np.asarray(log).tolist(), messages, strict=True):
            self._sink.add(channel, time, data)

    def write_streams(self, streams: Iterable[Stream]) -> None:
        """Writes several topics together, message by message by log time (equal times in the order of the streams)."""
        streams = list(streams)
        channels = [self._sink.channel(stream.topic, builtin_schema(stream.type)) for stream in streams]
        logs = [np.asarray(stream.log, np.int64) for stream in streams]
        source = np.repeat(np.arange(len(streams)), [len(log) for log in logs])
        times = np.concatenate([*logs, np.empty(0, np.int64)])
        remaining = [iter(stream.messages) for stream in streams]
        order = np.argsort(times, kind="stable")
        for number, time in zip(source[order].tolist(), times[order].tolist(), strict=True):
            self._sink.add(channels[number], time, next(remaining[number]))

    def write_raw(self, topic: str, type_name: str, log_ns: int, data: bytes, schema: Schema | None = None) -> None:
        """Writes one serialised message; ``schema`` for types that are not built in."""
        self._sink.add(self._sink.channel(topic, schema or builtin_schema(type_name)), log_ns, data)

    def write_batch(self, batch: Batch) -> None:
        """Copies all messages of a batch unchanged, with the definitions of their recording."""
        channels: dict[int, int] = {}
        for connection, log_ns, data in batch.raw():
            channel = channels.get(id(connection))
            if channel is None:
                schema = _with_text(connection.schema)
                channel = channels[id(connection)] = self._sink.channel(
                    connection.topic, schema, connection.encoding, dict(connection.metadata)
                )
            self._sink.add(channel, log_ns, data)


class LiveBagWriter:
    """Writes one ``.mcap`` file that stays readable, however the process ends; final.

    The file has its final path from the beginning. The messages before the last `flush` survive a killed process:
    `open_bag` reads all whole chunks of a file that was not closed.

    Raises:
        OSError: if the file cannot be created, or the disk is full; also from every method.
    """

    def __init__(self, path: Path) -> None:
        """Never overwrites: the file must not exist."""
        self.path = path
        self._file = open(path, "xb")
        self._sink = _Sink(self._file)

    def write_raw(self, topic: str, type_name: str, log_ns: int, data: bytes) -> None:
        """Writes one serialised message of a built-in type."""
        self._sink.add(self._sink.channel(topic, builtin_schema(type_name)), log_ns, data)

    def flush(self) -> int:
        """Ends the chunk and passes it to the operating system; returns the size of the file in bytes."""
        self._sink.flush()
        return self._file.tell()

    def close(self) -> None:
        """Completes the file."""
        try:
            self._sink.finish()
        finally:
            self._file.close()

    def abandon(self) -> None:
        """Closes the file without completing it, if the disk is full."""
        with suppress(OSError):
            self._file.close()


class _Sink:
    """Writes messages with their definitions to one open file; final."""

    def __init__(self, file: BinaryIO) -> None:
        self._schemas: dict[Schema, int] = {}
        self._channels: dict[tuple[str, Schema], int] = {}
        self._sequence: dict[int, int] = {}
        self._writer = Writer(file, compression=CompressionType.ZSTD)
        self._writer.start(profile="ros2", library=f"damper_estimator {__version__}")

    def flush(self) -> None:
        self._writer.flush()

    def finish(self) -> None:
        self._writer.finish()

    def add(self, channel: int, log_ns: int, data: bytes) -> None:
        sequence = self._sequence[channel] = self._sequence[channel] + 1
        self._writer.add_message(channel, log_ns, data, log_ns, sequence)

    def channel(
        self, topic: str, schema: Schema, encoding: str = "cdr", metadata: Mapping[str, str] | None = None
    ) -> int:
        key = (topic, schema)
        if key not in self._channels:
            if schema not in self._schemas:
                self._schemas[schema] = self._writer.register_schema(schema.type, schema.encoding, schema.text.encode())
            extra = _metadata(schema) if metadata is None else dict(metadata)
            self._channels[key] = self._writer.register_channel(topic, encoding, self._schemas[schema], extra)
            self._sequence[self._channels[key]] = 0
        return self._channels[key]


def _with_text(schema: Schema) -> Schema:
    """Adds the definition of a built-in type, if an old recording lacks it."""
    if schema.text or schema.type not in builtin_store().fielddefs:
        return schema
    return builtin_schema(schema.type)


def _metadata(schema: Schema) -> dict[str, str]:
    return {"offered_qos_profiles": _QOS, "topic_type_hash": builtin_store().hash_rihs01(schema.type)}
