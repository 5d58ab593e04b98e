"""Raw messages of a recording: blocks from the storage files in arrival order."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from damper_estimator.recordings.definitions import Schema


@dataclass(frozen=True)
class Connection:
    """One stream of messages of a storage file.

    Attributes:
        topic, schema: its name and message type.
        encoding: of the serialised messages; only ``cdr`` can be decoded.
        messages: their number.
        metadata: ``(key, value)`` pairs in the storage, such as the offered quality of service.
    """

    topic: str
    schema: Schema
    encoding: str
    messages: int
    metadata: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True, eq=False)
class RawMessages:
    """Messages ``data[start[i] : start[i] + length[i]]`` of connection ``connection[i]``, arrived at ``log[i]`` ns."""

    data: bytes
    connection: np.ndarray
    log: np.ndarray
    start: np.ndarray
    length: np.ndarray

    def __len__(self) -> int:
        return len(self.log)

    def chosen(self, which: np.ndarray | slice) -> "RawMessages":
        """Some of the messages, in the given order."""
        return replace(
            self,
            connection=self.connection[which],
            log=self.log[which],
            start=self.start[which],
            length=self.length[which],
        )


@dataclass(frozen=True, eq=False)
class Span:
    """A part of a storage file, not yet loaded: no message in it is earlier than ``start`` ns."""

    file: int
    number: int
    start: int
    load: Callable[[], RawMessages]


def joined(parts: list[RawMessages]) -> RawMessages:
    """Several blocks as one, in their order."""
    if len(parts) == 1:
        return parts[0]
    shifts = np.cumsum([0, *(len(part.data) for part in parts[:-1])])
    return RawMessages(
        b"".join(part.data for part in parts),
        np.concatenate([part.connection for part in parts]),
        np.concatenate([part.log for part in parts]),
        np.concatenate([part.start + shift for part, shift in zip(parts, shifts, strict=True)]),
        np.concatenate([part.length for part in parts]),
    )


def in_arrival_order(spans: Iterable[Span], shifts: np.ndarray) -> Iterator[RawMessages]:
    """Messages by log time, equal times by file and position; keeps only spans that overlap in time in memory.

    Args:
        spans: by their start.
        shifts: number of the first connection of each file, added to the file's connection numbers.
    """
    waiting: list[tuple[Span, RawMessages]] = []
    for span in spans:
        ready, waiting = _split(waiting, span.start)
        if ready:
            yield _sorted(ready)
        messages = span.load()
        waiting.append((span, replace(messages, connection=messages.connection + shifts[span.file])))
    if waiting:
        yield _sorted(waiting)


def _split(waiting: list[tuple[Span, RawMessages]], until: int) -> tuple[list, list]:
    ready, kept = [], []
    for span, messages in waiting:
        early = messages.log < until
        if early.all():
            ready.append((span, messages))
        elif not early.any():
            kept.append((span, messages))
        else:
            ready.append((span, messages.chosen(early)))
            kept.append((span, messages.chosen(~early)))
    return ready, kept


def _sorted(waiting: list[tuple[Span, RawMessages]]) -> RawMessages:
    place = sorted(waiting, key=lambda item: (item[0].file, item[0].number))
    messages = joined([part for _, part in place])
    if (np.diff(messages.log) >= 0).all():
        return messages
    return messages.chosen(np.argsort(messages.log, kind="stable"))


def gathered(buffer: np.ndarray, start: np.ndarray, size: int) -> np.ndarray:
    """Runs of bytes of one size as the rows of a matrix (n, size)."""
    if size == 0 or len(start) == 0:
        return np.empty((len(start), size), np.uint8)
    return np.lib.stride_tricks.sliding_window_view(buffer, size)[start]
