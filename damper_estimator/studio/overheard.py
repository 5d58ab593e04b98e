"""What the rooms below warn of while they read, for the page instead of the terminal."""

import logging
import threading
from collections.abc import Iterator
from contextlib import contextmanager

_ROOMS = logging.getLogger("damper_estimator")


class _Listener(logging.Handler):
    """Keeps the warnings of one thread; final."""

    def __init__(self, thread: int, told: list[str]) -> None:
        super().__init__(logging.WARNING)
        self._thread, self._told = thread, told

    def emit(self, record: logging.LogRecord) -> None:
        if record.thread == self._thread:
            self._told.append(" ".join(record.getMessage().split()))


@contextmanager
def overheard() -> Iterator[list[str]]:
    """A list that fills with the warnings that this thread's reading gives, such as that a recording is cut off."""
    told: list[str] = []
    listener = _Listener(threading.get_ident(), told)
    _ROOMS.addHandler(listener)
    try:
        yield told
    finally:
        _ROOMS.removeHandler(listener)
