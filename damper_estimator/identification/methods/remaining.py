"""Reports the remaining time of a search: nothing in the first seconds, then a line from time to time."""

from collections.abc import Callable
from time import perf_counter

QUIET = 3.0
"""s after which the first line is reported."""

_EVERY = 2.0  # s between two lines


class Remaining:
    """Estimates the remaining time from the expected evaluations and the time of those made; final."""

    def __init__(self, report: Callable[[str], None], clock: Callable[[], float] = perf_counter) -> None:
        """``report`` receives lines; ``clock`` returns s."""
        self._report, self._clock = report, clock
        self._begun, self._reported = clock(), -float("inf")

    def __call__(self, text: str, done: float, left: float) -> None:
        """Reports a line where it is time for one.

        Args:
            text: the current work.
            done, left: samples on which the model was run so far, and those expected to follow.
        """
        now = self._clock()
        if now - self._begun < QUIET or now - self._reported < _EVERY or done <= 0.0:
            return
        self._reported = now
        self._report(f"{text}: about {max((now - self._begun) * left / done, 1.0):.0f} s left")
