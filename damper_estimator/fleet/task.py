"""A task: one recording and damper, what to do with it, and where its results are stored."""

import hashlib
import json
import os
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar
from urllib.parse import quote

from damper_estimator import __version__

TASKS = "tasks"


@dataclass(frozen=True)
class Options:
    """The verb to run on every recording and its options; the verbs are in ``fleet.verbs``. Abstract.

    Attributes:
        verb: its name.
        start, stop: s from the start of the recording; None for no limit.
    """

    verb: ClassVar[str]
    start: float | None = None
    stop: float | None = None

    @property
    def words(self) -> tuple[str, ...]:
        """The options as on the command line, for the results."""
        return words(("from", self.start), ("to", self.stop))

    @abstractmethod
    def run(self, task: "Task") -> Mapping[str, object]:
        """Runs the verb on one recording and damper, writes its results under ``Task.place`` and returns the values of
        the row's columns.

        Raises:
            InputError: if the recording cannot be used.
        """


def words(*options: tuple[str, object]) -> tuple[str, ...]:
    """``--name=value`` of each option that is given."""
    return tuple(f"--{name}={value}" for name, value in options if value is not None)


@dataclass(frozen=True)
class Task:
    """One recording and damper with everything that its results depend on.

    Attributes:
        options: verb and options.
        recording, signals, model: as the verb accepts them; ``signals`` may be "".
        damper: its name; "" if the recording could not be opened.
        folder: results of this recording.
        pages: whether a page is written.
        facts: columns of the row that are known beforehand: vehicle, checksums, begin, temperature.
    """

    options: Options
    recording: str
    damper: str
    signals: str
    model: str
    folder: str
    pages: bool
    facts: Mapping[str, object]

    @property
    def verb(self) -> str:
        """Name of the verb."""
        return self.options.verb

    @property
    def fingerprint(self) -> str:
        """Checksum of everything that the results depend on: inputs, options, version of the package."""
        sums = [self.facts[name] for name in ("recording_checksum", "model_checksum", "signals_checksum")]
        return digest([self.verb, self.options.words, self.damper, self.pages, *sums, __version__])

    def place(self, ending: str) -> Path:
        """Path of the result with this ending."""
        return Path(self.folder) / f"{quote(self.damper, safe=' ') or 'recording'}.{self.verb}.{ending}"


def digest(value: object) -> str:
    """A short checksum of a value that JSON can represent."""
    return hashlib.sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()[:24]


def task_folder(output: Path, recording: str) -> Path:
    """Folder for the results of one recording: its name and a checksum of its path."""
    return output / TASKS / f"{Path(recording).stem}-{digest(recording)[:8]}"


def signature(recording: str) -> list[list[object]]:
    """Name, size and modification time of each file of a recording; empty if it does not exist."""
    path = Path(recording)
    try:
        files = sorted(p for p in path.rglob("*") if p.is_file()) if path.is_dir() else [path]
        states = [(os.path.relpath(p, path), p.stat()) for p in files]
    except OSError:
        return []
    return [[name, status.st_size, status.st_mtime_ns] for name, status in states]


def checksum(recording: str) -> str:
    """SHA-256 of the contents of all files of a recording.

    Raises:
        OSError: if one cannot be read.
    """
    path = Path(recording)
    total = hashlib.sha256()
    for file in sorted(p for p in path.rglob("*") if p.is_file()) if path.is_dir() else [path]:
        total.update(os.path.relpath(file, path).encode() + b"\0")
        with file.open("rb") as opened:
            total.update(hashlib.file_digest(opened, "sha256").digest())
    return total.hexdigest()[:24]
