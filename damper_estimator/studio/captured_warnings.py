"""Collects warnings of the readers for the page instead of the terminal."""

import logging
import threading
from collections.abc import Iterator
from contextlib import contextmanager

_PACKAGE = logging.getLogger("damper_estimator")


class _Listener(logging.Handler):
    """Keeps the warnings of one thread; final."""

    def __init__(self, thread: int, warnings: list[str]) -> None:
        super().__init__(logging.WARNING)
        self._thread, self._warnings = thread, warnings

    def emit(self, record: logging.LogRecord) -> None:
        if record.thread == self._thread:
            self._warnings.append(" ".join(record.getMessage().split()))


@contextmanager
def captured_warnings() -> Iterator[list[str]]:
    """A list to which warnings of this thread are added, such as that a recording is truncated."""
    warnings: list[str] = []
    listener = _Listener(threading.get_ident(), warnings)
    _PACKAGE.addHandler(listener)
    try:
        yield warnings
    finally:
        _PACKAGE.removeHandler(listener)
