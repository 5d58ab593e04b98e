"""Output whose reader may leave early, as ``head`` does: what a verb computes and writes to files goes on."""

import os
from collections.abc import Callable
from typing import Any, TextIO


class ClosableOutput:
    """A text stream that discards what nobody reads any more.

    Attributes:
        is_closed: whether the reader has left.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self.is_closed = False

    def write(self, text: str) -> int:
        """As for any text stream."""
        return self._unless_closed(lambda: self._stream.write(text), len(text))

    def flush(self) -> None:
        """As for any text stream."""
        self._unless_closed(self._stream.flush, None)

    def _unless_closed(self, act: Callable[[], Any], otherwise: Any) -> Any:
        try:
            return act()
        except BrokenPipeError:
            self.is_closed = True
            # What the stream still holds has to go somewhere, also when Python flushes it at exit.
            os.dup2(os.open(os.devnull, os.O_WRONLY), self._stream.fileno())
            return otherwise

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)
