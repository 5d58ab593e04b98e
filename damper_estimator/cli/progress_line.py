"""Progress of long work on one line of standard error: activity, share, time."""

import sys
from time import monotonic
from types import TracebackType
from typing import TextIO

_EVERY = 0.2  # s between two updates of the line


class ProgressLine:
    """A line that is overwritten on a terminal; elsewhere one line per activity. Call it with text and share.

    Use it in a ``with`` block, which removes the line at its end.
    """

    def __init__(self, name: str, stream: TextIO | None = None) -> None:
        self.name = name
        self.stream = sys.stderr if stream is None else stream
        self.overwrites = self.stream.isatty()
        self.begun = monotonic()
        self.shown = -float("inf")
        self.last = ""

    def __enter__(self) -> "ProgressLine":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self.overwrites and self.last:
            self.stream.write("\r\x1b[K")
            self.stream.flush()

    def __call__(self, text: str, share: float) -> None:
        """Shows the current activity and the completed share of the work, 0 to 1."""
        now = monotonic()
        if self.overwrites:
            if now - self.shown < _EVERY:
                return
            self.stream.write(f"\r\x1b[K{self._line(text, share, now - self.begun)}")
        elif text != self.last:
            self.stream.write(f"{self._line(text, share, now - self.begun)}\n")
        self.stream.flush()
        self.last, self.shown = text, now

    def _line(self, text: str, share: float, seconds: float) -> str:
        return f"{self.name}: {100.0 * share:3.0f} %  {text}  ({seconds:.0f} s)"
