"""The mcap storage: one pass over the record headers finds all records, chunks are loaded when needed.

The mcap library parses records, decompresses and checks chunks. The messages inside a chunk are separated here: the
library creates an object for each, which costs ten times as much. An incomplete file is read as far as it is whole.
"""

import logging
import os
import struct
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Statistics
from mcap.records import Schema as SchemaRecord
from mcap.stream_reader import get_chunk_data_stream

from damper_estimator.compiled import compiled
from damper_estimator.errors import InputError
from damper_estimator.recordings.definitions import Schema
from damper_estimator.recordings.library_errors import explained
from damper_estimator.recordings.raw_messages import Connection, RawMessages, Span, gathered

MAGIC = b"\x89MCAP0\r\n"
_LOG = logging.getLogger(__name__)  # by default it writes to standard error
_HEAD = struct.Struct("<BQ")
_MESSAGE_HEAD = np.dtype([("channel", "<u2"), ("sequence", "<u4"), ("log", "<i8"), ("published", "<i8")])
_CHUNK_TIMES = struct.Struct("<QQQ")
_PLAIN_SPAN = 1 << 20  # bytes of messages outside chunks that are loaded together


@dataclass(frozen=True)
class _Place:
    """The position of messages in the file: one chunk record, or a run of message records outside chunks."""

    start: int
    offset: int
    size: int
    in_chunk: bool


class McapFile:
    """One ``.mcap`` file; final. Close it after use.

    Raises:
        InputError: if the file is damaged, cut off before its first messages, or no mcap file.
    """

    def __init__(self, path: Path, name: str | None = None) -> None:
        self._name = name or str(path)
        self._remedy = f"recover the readable part with: mcap recover {self._name} -o recovered.mcap"
        self._schemas: dict[int, SchemaRecord] = {}
        self._channels: dict[int, Channel] = {}
        self._counts: Counter[int] | None = None
        self._places: list[_Place] = []
        with explained(self._name, self._remedy):
            self._file: BinaryIO = open(path, "rb")
        try:
            self._scan(os.fstat(self._file.fileno()).st_size)
            if self._counts is None or len(self._counts.keys() - self._channels.keys()):
                self._count_messages()
            with explained(self._name, self._remedy):
                self.connections = tuple(self._connection(channel) for channel in self._channels.values())
        except BaseException:
            self._file.close()
            raise
        # The first channel of a number counts, as in every reader: later records are repetitions.
        self._index = np.full(1 << 16, -1, np.int32)
        self._index[list(self._channels)] = np.arange(len(self._channels))

    def close(self) -> None:
        self._file.close()

    def spans(self, file: int) -> Iterator[Span]:
        """The spans of the file by start time."""
        for number, place in sorted(enumerate(self._places), key=lambda numbered: numbered[1].start):
            yield Span(file, number, place.start, lambda place=place: self._load(place))

    def _load(self, place: _Place) -> RawMessages:
        data, channel, log, start, length = self._cut(place)
        connection = self._index[channel]
        if (connection < 0).any():
            raise InputError(f"{self._name}: damaged (a message of an unknown channel); {self._remedy}")
        if len(log) and log.min() < place.start:
            raise InputError(f"{self._name}: damaged (message times contradict the index); {self._remedy}")
        return RawMessages(data, connection, log, start, length)

    def _scan(self, size: int) -> None:
        file = self._file
        with explained(self._name, self._remedy):
            head, tail = file.read(len(MAGIC)), b""
            if size >= 2 * len(MAGIC):
                file.seek(-len(MAGIC), os.SEEK_END)
                tail = file.read(len(MAGIC))
        if head != MAGIC:
            raise InputError(f"{self._name}: no mcap file; give an .mcap file or a rosbag2 folder")
        is_cut = tail != MAGIC
        position, end = len(MAGIC), size if is_cut else size - len(MAGIC)
        while position < end:
            with explained(self._name, self._remedy):
                file.seek(position)
                head = file.read(_HEAD.size)
                if is_cut and not _is_whole(head, position, end):
                    break
                opcode, length = _HEAD.unpack(head)
                if position + _HEAD.size + length > end:
                    raise ValueError(f"record at byte {position} reaches beyond the end")
                self._note(opcode, length, position)
            position += _HEAD.size + length
        if is_cut:
            self._salvage(size - position)

    def _salvage(self, lost: int) -> None:
        """A file whose recorder was killed, or with a full disk: whole messages are used, the loss is logged."""
        if not self._places:
            raise InputError(f"{self._name}: cut off before the first messages were complete; {self._remedy}")
        self._counts = None
        self._count_messages()
        _LOG.warning(
            "%s: cut off (its recorder was ended, or the disk was full): %d messages are whole and used, "
            "the last %d bytes are lost",
            self._name,
            self._counts.total(),
            lost,
        )

    def _note(self, opcode: int, length: int, position: int) -> None:
        """Remembers one record outside of chunks."""
        file, size = self._file, _HEAD.size + length
        if opcode == Opcode.CHUNK:
            earliest, _, uncompressed = _CHUNK_TIMES.unpack(file.read(_CHUNK_TIMES.size))
            if uncompressed:
                self._places.append(_Place(earliest, position, size, True))
        elif opcode == Opcode.MESSAGE:
            log = np.frombuffer(file.read(_MESSAGE_HEAD.itemsize), _MESSAGE_HEAD)["log"][0]
            self._note_message(int(log), position, size)
        elif opcode == Opcode.STATISTICS:
            statistics = Statistics.read(ReadDataStream(BytesIO(file.read(length))))
            self._counts = Counter(statistics.channel_message_counts)
        elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            self._note_definition(opcode, file.read(length))

    def _note_message(self, log: int, position: int, size: int) -> None:
        last = self._places[-1] if self._places else None
        if last and not last.in_chunk and last.offset + last.size == position and last.size < _PLAIN_SPAN:
            self._places[-1] = _Place(min(last.start, log), last.offset, last.size + size, False)
        else:
            self._places.append(_Place(log, position, size, False))

    def _note_definition(self, opcode: int, content: bytes) -> None:
        stream = ReadDataStream(BytesIO(content))
        if opcode == Opcode.SCHEMA:
            schema = SchemaRecord.read(stream)
            self._schemas.setdefault(schema.id, schema)
        else:
            channel = Channel.read(stream)
            self._channels.setdefault(channel.id, channel)

    def _count_messages(self) -> None:
        """For files without statistics or without repeated channels: reads every chunk."""
        self._counts = Counter()
        for place in self._places:
            channels, counts = np.unique(self._cut(place, definitions=True)[1], return_counts=True)
            self._counts.update(dict(zip(channels.tolist(), counts.tolist(), strict=True)))

    def _cut(self, place: _Place, definitions: bool = False) -> tuple[bytes, np.ndarray, ...]:
        """The bytes of a place, and channel, log time, start and length of every message in them."""
        with explained(self._name, self._remedy):
            self._file.seek(place.offset)
            data = self._file.read(place.size)
            if place.in_chunk:
                chunk = Chunk.read(ReadDataStream(BytesIO(data[_HEAD.size :])))
                stream, size = get_chunk_data_stream(chunk, validate_crc=True)
                data = stream.read(size)
            opcode, start, length = _records(data)
            if definitions:
                for row in np.flatnonzero((opcode == Opcode.SCHEMA) | (opcode == Opcode.CHANNEL)):
                    self._note_definition(opcode[row], data[start[row] : start[row] + length[row]])
            messages = opcode == Opcode.MESSAGE
            heads = gathered(np.frombuffer(data, np.uint8), start[messages], _MESSAGE_HEAD.itemsize)
            heads = heads.view(_MESSAGE_HEAD)[:, 0]
            start, length = start[messages] + _MESSAGE_HEAD.itemsize, length[messages] - _MESSAGE_HEAD.itemsize
            if (length < 0).any():
                raise ValueError("a message record is too short")
        return data, heads["channel"], heads["log"], start, length

    def _connection(self, channel: Channel) -> Connection:
        record = self._schemas.get(channel.schema_id)
        schema = Schema("") if record is None else Schema(
            _full_name(record.name), record.encoding, str(record.data, "utf-8", "replace")
        )  # fmt: skip
        metadata = tuple(sorted(channel.metadata.items()))
        return Connection(channel.topic, schema, channel.message_encoding, self._counts[channel.id], metadata)


def _is_whole(head: bytes, position: int, end: int) -> bool:
    """Whether the record at this position is completely in the file."""
    if len(head) < _HEAD.size:
        return False
    opcode, length = _HEAD.unpack(head)
    return opcode != 0 and position + _HEAD.size + length <= end


def _records(data: bytes) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Opcode, start and length of the content of every record."""
    most = len(data) // _HEAD.size
    opcode, start, length = np.empty(most, np.uint8), np.empty(most, np.int64), np.empty(most, np.int64)
    count = _walk(np.frombuffer(data, np.uint8), opcode, start, length)
    if count < 0:
        raise ValueError("a record reaches beyond its chunk")
    return opcode[:count].copy(), start[:count].copy(), length[:count].copy()


@compiled
def _walk(data, opcode, start, length):
    """Notes every record of ``data`` (bytes,) uint8 and returns their number; -1 if the last is not whole."""
    position, count, end = 0, 0, data.size
    while position < end:
        # The highest byte of a length that fits into any memory is zero.
        if position + 9 > end or data[position + 8] != 0:
            return -1
        size = 0
        for i in range(7):
            size += int(data[position + 1 + i]) << (8 * i)
        opcode[count], start[count], length[count] = data[position], position + 9, size
        position += 9 + size
        count += 1
    return count if position == end else -1


def _full_name(type_name: str) -> str:
    """The full form of names such as ``std_msgs/String``, which some writers use."""
    package, _, name = type_name.partition("/")
    return type_name if "/" in name else f"{package}/msg/{name}"
