"""Records inputs and estimates while the node runs, in a separate thread; written messages survive ``kill -9``.

Twice a second the new messages are put into a chunk and passed to the operating system. A full or slow disk costs
recorded messages, which are counted, and never estimates. Files are ``damper_estimator_<date>_<time>_<number>.mcap``.
"""

import sys
import time
from collections import deque
from pathlib import Path
from threading import Event, Thread
from typing import TYPE_CHECKING

from diagnostic_msgs.msg import DiagnosticStatus

from damper_estimator.errors import InputError
from damper_estimator.node.background import SWITCH

if TYPE_CHECKING:
    from damper_estimator.recordings import LiveBagWriter

PERIOD = 0.5  # s between chunks
PATIENCE = 10.0  # s until a full disk is tried again
MOST_WAITING = 100_000  # messages; more are not kept
PREFIX = "damper_estimator_"


def _writer_class() -> "type[LiveBagWriter]":
    """The writer of the files; imported here, because a node that does not record runs without its packages."""
    try:
        from damper_estimator.recordings import LiveBagWriter
    except ModuleNotFoundError as error:
        package = (error.name or "").partition(".")[0]
        raise InputError(
            f"parameter record: the Python package {package} is not installed; install it (pip install {package}) "
            "or leave record empty"
        ) from error
    return LiveBagWriter


class Recorder:
    """A series of files in one folder; final."""

    def __init__(self, folder: str, size: int, files: int) -> None:
        """``size`` of a file in MB; number of ``files`` to keep, 0 for all.

        Raises:
            InputError: if the folder cannot be created or written to, or a package that writes files is missing.
        """
        self._writer_class = _writer_class()
        self._folder, self._size, self._files = Path(folder).expanduser(), size * 1_000_000, files
        self._waiting: deque[tuple[str, str, int, bytes]] = deque()
        self._end = Event()
        self._thread: Thread | None = None
        self._writer: LiveBagWriter | None = None
        self._number = self._written = self._bytes = self._lost = self._reported = 0
        self._complaint = ""
        self._full_until = 0.0
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            probe = self._folder / f".{PREFIX}probe"
            probe.touch()
            probe.unlink()
        except OSError as error:
            raise InputError(
                f"parameter record: {folder}: cannot be written to ({error.strerror}); choose another folder"
            ) from error

    def start(self) -> None:
        """Begins a new file with the next message."""
        sys.setswitchinterval(SWITCH)
        self._end.clear()
        self._thread = Thread(target=self._run, name="recorder", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Completes the file; does nothing if it is not recording."""
        if self._thread is not None:
            self._end.set()
            self._thread.join()
            self._thread = None

    def keep(self, topic: str, type_name: str, data: bytes) -> None:
        """Records a serialised message as received or sent now."""
        if len(self._waiting) < MOST_WAITING:
            self._waiting.append((topic, type_name, time.time_ns(), data))
        else:
            self._lost += 1

    def health(self) -> tuple[bytes, str, dict[str, object]]:
        """Level, message and values for ``/diagnostics``."""
        values = {
            "folder": self._folder,
            "file": self._writer.path.name if self._writer else "",
            "messages": self._written,
            "not recorded": self._lost,
            "bytes": self._bytes,
        }
        new, self._reported = self._lost - self._reported, self._lost
        if self._complaint:
            return DiagnosticStatus.ERROR, self._complaint, values
        if new:
            return DiagnosticStatus.WARN, f"{new} messages were not recorded; the disk is too slow", values
        return DiagnosticStatus.OK, "recording" if self._thread else "not recording", values

    def _run(self) -> None:
        while not self._end.wait(PERIOD):
            self._write()
        self._write()
        self._close()

    def _write(self) -> None:
        """Writes the waiting messages; a failure costs these messages and ends the file."""
        batch = [self._waiting.popleft() for _ in range(len(self._waiting))]
        if not batch:
            return
        if time.monotonic() < self._full_until:
            self._lost += len(batch)
            return
        try:
            if self._writer is None:
                self._open()
            for topic, type_name, log, data in batch:
                self._writer.write_raw(topic, type_name, log, data)
            size = self._writer.flush()
        except OSError as error:
            self._lost += len(batch)
            self._full_until = time.monotonic() + PATIENCE
            self._complaint = f"recording to {self._folder} stopped: {error.strerror}; tried again every {PATIENCE:g} s"
            if self._writer is not None:
                self._writer.abandon()
                self._writer = None
            return
        self._complaint = ""
        self._written += len(batch)
        self._bytes = size
        if size >= self._size:
            self._close()

    def _open(self) -> None:
        """Opens the next file, and deletes the oldest ones beyond the number to keep."""
        if self._files:
            existing = sorted(self._folder.glob(f"{PREFIX}*.mcap"), key=lambda path: path.stat().st_mtime)
            for path in existing[: max(len(existing) - self._files + 1, 0)]:
                path.unlink()
        while True:
            self._number += 1
            moment = time.strftime("%Y%m%d_%H%M%S")
            try:
                self._writer = self._writer_class(self._folder / f"{PREFIX}{moment}_{self._number:04d}.mcap")
                return
            except FileExistsError:
                continue

    def _close(self) -> None:
        if self._writer is None:
            return
        try:
            self._writer.close()
        except OSError as error:
            self._complaint = f"recording {self._writer.path} could not be completed: {error.strerror}"
        self._writer = None
