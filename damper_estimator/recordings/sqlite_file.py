"""The sqlite3 storage of rosbag2, all its schema versions."""

import sqlite3
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from damper_estimator.recordings.definitions import Schema
from damper_estimator.recordings.library_errors import explained
from damper_estimator.recordings.raw_messages import Connection, RawMessages, Span

MAGIC = b"SQLite format 3\0"
_PAGE = 4096  # messages loaded together
_PAGE_BYTES = 16 << 20  # for fewer large messages


class SqliteFile:
    """One ``.db3`` file; final. Close it after use.

    Raises:
        InputError: if the file is damaged or contains no recording.
    """

    def __init__(self, path: Path, name: str | None = None) -> None:
        self._name = name or str(path)
        self._remedy = f"correct a copy with: sqlite3 {self._name} .recover | sqlite3 new.db3"
        # Read-only media need immutable; a write-ahead log left by a crash is read only without it.
        mode = "mode=ro" if path.with_name(path.name + "-wal").exists() else "mode=ro&immutable=1"
        with explained(self._name, self._remedy):
            self._database = sqlite3.connect(f"{path.resolve().as_uri()}?{mode}", uri=True)
        try:
            with explained(self._name, self._remedy):
                self._ids, self.connections = self._read_topics()
        except BaseException:
            self._database.close()
            raise

    def close(self) -> None:
        self._database.close()

    def _columns(self, table: str) -> set[str]:
        return {row[1] for row in self._database.execute(f"PRAGMA table_info({table})")}

    def _read_topics(self) -> tuple[np.ndarray, tuple[Connection, ...]]:
        if not {"topic_id", "timestamp", "data"} <= self._columns("messages"):
            raise ValueError("the tables of a rosbag2 recording are missing")
        schemas = self._read_schemas()
        counts = dict(self._database.execute("SELECT topic_id, count(*) FROM messages GROUP BY topic_id"))
        qos = "offered_qos_profiles" if "offered_qos_profiles" in self._columns("topics") else "''"
        rows = self._database.execute(f"SELECT id, name, type, serialization_format, {qos} FROM topics ORDER BY id")
        ids, connections = [], []
        for number, topic, type_name, encoding, profiles in rows.fetchall():
            ids.append(number)
            schema = schemas.get(type_name, Schema(str(type_name)))
            metadata = (("offered_qos_profiles", str(profiles)),)
            connections.append(Connection(str(topic), schema, str(encoding), counts.get(number, 0), metadata))
        return np.array(ids, np.int64), tuple(connections)

    def _read_schemas(self) -> dict[str, Schema]:
        if not self._columns("message_definitions"):
            return {}
        rows = self._database.execute(
            "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
        )
        return {name: Schema(name, str(encoding), str(text)) for name, encoding, text in rows}

    def spans(self, file: int) -> Iterator[Span]:
        """The spans of the file by start time; each must be loaded before the next is requested."""
        with explained(self._name, self._remedy):
            cursor = self._database.execute("SELECT topic_id, timestamp, data FROM messages ORDER BY timestamp, id")
            ahead = cursor.fetchone()
        number = 0
        while ahead is not None:
            loaded: list[tuple] = []

            def load(first: tuple = ahead, loaded: list = loaded) -> RawMessages:
                with explained(self._name, self._remedy):
                    rows, following = _page(first, cursor)
                    loaded.append(following)
                    return self._raw(rows)

            with explained(self._name, self._remedy):
                start = int(ahead[1])
            yield Span(file, number, start, load)
            ahead, number = loaded[0], number + 1

    def _raw(self, rows: list[tuple]) -> RawMessages:
        topic, log, data = zip(*rows, strict=True)
        topics = np.array(topic, np.int64)
        connection = np.searchsorted(self._ids, topics)
        if (self._ids[np.minimum(connection, len(self._ids) - 1)] != topics).any():
            raise ValueError("a message of an unknown topic")
        length = np.array([len(item) for item in data], np.int64)
        return RawMessages(b"".join(data), connection, np.array(log, np.int64), np.cumsum(length) - length, length)


def _page(first: tuple, cursor: sqlite3.Cursor) -> tuple[list[tuple], tuple | None]:
    """The rows from ``first`` on that are loaded together, and the next one."""
    rows, size = [first], len(first[2])
    for row in cursor:
        if len(rows) >= _PAGE or size >= _PAGE_BYTES:
            return rows, row
        rows.append(row)
        size += len(row[2])
    return rows, None
