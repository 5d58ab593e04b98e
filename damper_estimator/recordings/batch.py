"""A part of a recording in arrival order, and its numbers."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
import zstandard
from rosbags.serde import SerdeError

from damper_estimator.errors import InputError
from damper_estimator.recordings.cdr_layout import MalformedMessage, layout_of
from damper_estimator.recordings.decode import Decoder
from damper_estimator.recordings.definitions import Schema, definition_of, store_of
from damper_estimator.recordings.library_errors import LIBRARY_ERRORS, explained, one_line
from damper_estimator.recordings.raw_messages import Connection, RawMessages


@dataclass(frozen=True, eq=False)
class Columns:
    """Fields of one topic, a row per message in arrival order.

    Attributes:
        log: (n,) int64, ns, time of recording.
        stamp: (n,) int64, ns, ``header.stamp``; the log time if the type has no header.
        rank: (n,) int64, place of the message among all messages of the recording.
        values: (n, k) float64.
        present: (n, k) bool, False if the message has no such name or index (its value is NaN then).
    """

    log: np.ndarray
    stamp: np.ndarray
    rank: np.ndarray
    values: np.ndarray
    present: np.ndarray


def joined_columns(parts: list[Columns], width: int) -> Columns:
    """Consecutive columns as one; empty ones of ``width`` if there are none."""
    if not parts:
        none = np.empty(0, np.int64)
        return Columns(none, none, none, np.empty((0, width)), np.empty((0, width), bool))
    return Columns(*(np.concatenate([getattr(part, name) for part in parts]) for name in Columns.__dataclass_fields__))


class DecodingContext:
    """The shared data of all batches of a recording: its connections, and the decoders used so far; final."""

    def __init__(self, path: str, connections: tuple[Connection, ...], compressed: bool) -> None:
        self.path = path
        self.connections = connections
        self._compressed = compressed
        self._decoders: dict[tuple[Schema, tuple[str, ...]], Decoder] = {}

    def chosen(self, topics: Iterable[str] | None) -> np.ndarray:
        """Whether each connection belongs to the topics (all): (connections,) bool."""
        names = None if topics is None else set(topics)
        return np.array([names is None or connection.topic in names for connection in self.connections], bool)

    def named(self, topic: str) -> str:
        """The topic as in the recording, with or without the leading ``/``."""
        existing = {connection.topic for connection in self.connections}
        return next((name for name in (topic, f"/{topic}", topic.removeprefix("/")) if name in existing), topic)

    def check(self, topic: str, paths: tuple[str, ...]) -> None:
        """Raises the InputError that reading these fields would raise."""
        for connection in self.connections:
            if connection.topic == topic:
                self.decoder(connection, paths)

    def decoder(self, connection: Connection, paths: tuple[str, ...]) -> Decoder:
        key = (connection.schema, paths)
        if key not in self._decoders:
            self._refuse_other_encodings(connection)
            try:
                self._decoders[key] = Decoder(definition_of(connection.schema), paths)
            except InputError as error:
                raise self.error(connection.topic, str(error)) from error
        return self._decoders[key]

    def decode_whole(self, connection: Connection, raw: bytes) -> object:
        self._refuse_other_encodings(connection)
        schema = connection.schema
        try:
            try:
                return store_of(schema).deserialize_cdr(raw, schema.type)
            except SerdeError:
                return store_of(schema).deserialize_cdr(_without_padding(raw, schema), schema.type)
        except InputError as error:
            raise self.error(connection.topic, str(error)) from error
        except (SerdeError, *LIBRARY_ERRORS) as error:
            raise self.malformed(connection, str(error)) from error

    def unpacked(self, raw: RawMessages) -> RawMessages:
        """The messages as sent, if the recording compressed each separately."""
        if not self._compressed:
            return raw
        ends = raw.start + raw.length
        with explained(self.path, "copy the recording again"):
            plain = [
                zstandard.ZstdDecompressor().decompressobj().decompress(raw.data[start:end])
                for start, end in zip(raw.start.tolist(), ends.tolist(), strict=True)
            ]
        length = np.array([len(item) for item in plain], np.int64)
        return RawMessages(b"".join(plain), raw.connection, raw.log, np.cumsum(length) - length, length)

    def error(self, topic: str, what: str) -> InputError:
        return InputError(one_line(f"{self.path}: topic {topic}: {what}"))

    def malformed(self, connection: Connection, what: str) -> InputError:
        what = f"a message does not fit its type {connection.schema.type} ({what})"
        return self.error(connection.topic, f"{what}; record the topic again, with the definition of its publisher")

    def _refuse_other_encodings(self, connection: Connection) -> None:
        if connection.encoding != "cdr":
            what = f"its messages are encoded as {connection.encoding!r}; only cdr (ROS 2) can be decoded"
            raise self.error(connection.topic, what)


def _without_padding(raw: bytes, schema: Schema) -> bytes:
    """The message up to the end of its last field; unchanged if that is unknown."""
    try:
        return raw[: layout_of(raw, definition_of(schema), {}, 0).end]
    except MalformedMessage:
        return raw


@dataclass(frozen=True, eq=False)
class Batch:
    """Consecutive messages of a recording (of the requested topics) in arrival order.

    Attributes:
        rank: (n,) int64, place of each message among all messages of the recording.
    """

    _context: DecodingContext
    _raw: RawMessages
    rank: np.ndarray

    def __len__(self) -> int:
        return len(self.rank)

    @property
    def log(self) -> np.ndarray:
        """Log times, (n,) int64, ns."""
        return self._raw.log

    def columns(self, topic: str, paths: Iterable[str]) -> Columns:
        """Fields of one topic; empty if none of its messages is in this batch.

        Raises:
            InputError: if the type or a field is unknown (lists the existing ones), or a message is malformed.
        """
        paths = tuple(paths)
        rows, groups = self._rows(topic)
        count = len(rows)
        log = self._raw.log[rows]
        result = Columns(
            log, log.copy(), self.rank[rows], np.empty((count, len(paths))), np.empty((count, len(paths)), bool)
        )
        for connection, places in groups:
            decoder = self._context.decoder(connection, paths)
            raw = self._raw.chosen(rows[places])
            try:
                numbers = decoder.decode(raw.data, raw.start, raw.length)
            except MalformedMessage as error:
                raise self._context.malformed(connection, str(error)) from error
            result.values[places], result.present[places] = numbers.values, numbers.present
            if numbers.stamp is not None:
                result.stamp[places] = numbers.stamp
        return result

    def messages(self, topic: str) -> Iterator[tuple[int, object]]:
        """Log time (ns) and decoded message (of rosbags), one by one; general and slow.

        Raises:
            InputError: if the type is unknown or a message is malformed.
        """
        for row in self._rows(topic)[0]:
            connection = self._context.connections[self._raw.connection[row]]
            yield int(self._raw.log[row]), self._context.decode_whole(connection, self._bytes(row))

    def raw(self) -> Iterator[tuple[Connection, int, bytes]]:
        """Connection, log time (ns) and serialised bytes of every message, for copying."""
        connections, raw = self._context.connections, self._raw
        columns = (raw.connection.tolist(), raw.log.tolist(), raw.start.tolist(), (raw.start + raw.length).tolist())
        for connection, log, start, end in zip(*columns, strict=True):
            yield connections[connection], log, raw.data[start:end]

    def _bytes(self, row: int) -> bytes:
        start = self._raw.start[row]
        return self._raw.data[start : start + self._raw.length[row]]

    def _rows(self, topic: str) -> tuple[np.ndarray, list[tuple[Connection, np.ndarray]]]:
        """Rows of a topic, and for each message definition among them the places in these rows."""
        chosen = self._context.chosen([self._context.named(topic)])
        rows = np.flatnonzero(chosen[self._raw.connection])
        of_row = self._raw.connection[rows]
        by_schema: dict[Schema, list[int]] = {}
        for number in np.unique(of_row).tolist():
            by_schema.setdefault(self._context.connections[number].schema, []).append(number)
        return rows, [
            (self._context.connections[numbers[0]], np.flatnonzero(np.isin(of_row, numbers)))
            for numbers in by_schema.values()
        ]
