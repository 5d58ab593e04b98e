"""Tells how long a search will go on: nothing in the first seconds, then a line from time to time."""

from collections.abc import Callable
from time import perf_counter

QUIET = 3.0
"""s after which a search begins to tell."""

_EVERY = 2.0  # s between two lines


class Remaining:
    """Turns the evaluations that are still expected into a time, by those that were made; final."""

    def __init__(self, report: Callable[[str], None], clock: Callable[[], float] = perf_counter) -> None:
        """``tell`` receives lines; ``clock`` gives s."""
        self._tell, self._clock = report, clock
        self._begun, self._told = clock(), -float("inf")

    def __call__(self, text: str, done: float, left: float) -> None:
        """Says what is done.

        Args:
            text: what goes on.
            done, left: samples on which the model was run so far, and on which it will probably still be run.
        """
        now = self._clock()
        if now - self._begun < QUIET or now - self._told < _EVERY or done <= 0.0:
            return
        self._told = now
        self._tell(f"{text}: about {max((now - self._begun) * left / done, 1.0):.0f} s left")
