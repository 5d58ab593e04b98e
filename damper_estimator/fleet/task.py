"""A task: one recording and damper, what is asked of it, and where its results lie."""

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
    """What is done with every recording, and how; the verbs of a fleet are in ``fleet.verbs``. Abstract.

    Attributes:
        verb: its name.
        start, stop: s from the start of the recording, None where all is used.
    """

    verb: ClassVar[str]
    start: float | None = None
    stop: float | None = None

    @property
    def words(self) -> tuple[str, ...]:
        """The options as on the command line, for the record."""
        return words(("from", self.start), ("to", self.stop))

    @abstractmethod
    def run(self, task: "Task") -> Mapping[str, object]:
        """Does the work on one recording and damper, writes its results under ``Task.place``, and gives the values of
        the row's columns.

        Raises:
            InputError: where the recording cannot be used.
        """


def words(*options: tuple[str, object]) -> tuple[str, ...]:
    """``--name=value`` of each option that is given."""
    return tuple(f"--{name}={value}" for name, value in options if value is not None)


@dataclass(frozen=True)
class Task:
    """One recording and damper; all that its results depend on.

    Attributes:
        options: what is done.
        recording, signals, model: as the verb takes them; ``signals`` may be "".
        damper: its name; "" where the recording could not even be opened.
        folder: where this recording's results lie.
        pages: whether a page is written.
        facts: columns of the row that are known before the work: vehicle, checksums, begin, temperature.
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
        """Name of what is done."""
        return self.options.verb

    @property
    def fingerprint(self) -> str:
        """Equal where the results are equal: checksums of what goes in, the options, the package's version."""
        sums = [self.facts[name] for name in ("recording_checksum", "model_checksum", "signals_checksum")]
        return digest([self.verb, self.options.words, self.damper, self.pages, *sums, __version__])

    def place(self, ending: str) -> Path:
        """Path of one of the results."""
        return Path(self.folder) / f"{quote(self.damper, safe=' ') or 'recording'}.{self.verb}.{ending}"


def digest(what: object) -> str:
    """A short checksum of anything that JSON can hold."""
    return hashlib.sha256(json.dumps(what, sort_keys=True).encode()).hexdigest()[:24]


def task_folder(output: Path, recording: str) -> Path:
    """Where the results of one recording lie: named after it, and told from others of that name by its path."""
    return output / TASKS / f"{Path(recording).stem}-{digest(recording)[:8]}"


def signature(recording: str) -> list[list[object]]:
    """Name, size and time of change of each file of a recording; empty where there is none."""
    path = Path(recording)
    try:
        files = sorted(p for p in path.rglob("*") if p.is_file()) if path.is_dir() else [path]
        told = [(os.path.relpath(p, path), p.stat()) for p in files]
    except OSError:
        return []
    return [[name, status.st_size, status.st_mtime_ns] for name, status in told]


def checksum(recording: str) -> str:
    """SHA-256 of the contents of all files of a recording.

    Raises:
        OSError: where one cannot be read.
    """
    path = Path(recording)
    total = hashlib.sha256()
    for file in sorted(p for p in path.rglob("*") if p.is_file()) if path.is_dir() else [path]:
        total.update(os.path.relpath(file, path).encode() + b"\0")
        with file.open("rb") as opened:
            total.update(hashlib.file_digest(opened, "sha256").digest())
    return total.hexdigest()[:24]
