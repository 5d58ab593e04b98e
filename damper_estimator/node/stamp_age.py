"""How old samples are when they arrive. Knows no ROS."""

RELATED = 60.0  # s by which two clocks that mean the same time may differ
_WINDOW = 60.0  # s over which the fastest message is remembered, twice
_OUT_OF_ORDER = 0.1  # s by which a message may come after a newer one; a larger step back is a clock that was set


class StampAge:
    """Whether the messages of one topic waited too long on their way; final.

    The age of a sample is the time between its stamp and its arrival. A stamp ahead of this machine's clock shows that
    the clocks differ: then the age counts from the youngest sample of the last minutes, or since the sender's clock was
    set back. Where even the youngest is more than ``RELATED`` old or ahead, the stamps belong to another clock (a
    recording that is being played), and nothing can be said.

    Attributes:
        age: s, of the last sample, as the clocks have it.
        late: how many samples were too old.
    """

    def __init__(self) -> None:
        self.age = float("nan")
        self.late = 0
        self._youngest = [float("inf"), float("inf")]  # of this window and of the one before
        self._began = float("-inf")
        self._stamp = 0

    @property
    def is_related(self) -> bool:
        """Whether the stamps mean this machine's time; true before the first."""
        youngest = min(self._youngest)
        return youngest == float("inf") or abs(youngest) <= RELATED

    def is_late(self, stamp: int, now: int, max_age: float) -> bool:
        """Takes a sample in; both times in ns, ``max_age`` in s, 0 to judge nothing."""
        self.age = (now - stamp) / 1e9
        is_set_back = stamp < self._stamp - _OUT_OF_ORDER * 1e9
        if is_set_back or not self._began <= now / 1e9 < self._began + _WINDOW:
            self._turn(now / 1e9, is_set_back)
        self._stamp = stamp
        self._youngest[0] = min(self._youngest[0], self.age)
        is_late = max_age > 0.0 and self.is_related and self.age - min(0.0, *self._youngest) > max_age
        self.late += is_late
        return is_late

    def _turn(self, now: float, is_other_clock: bool) -> None:
        follows = self._began + _WINDOW <= now < self._began + 2.0 * _WINDOW and not is_other_clock
        self._youngest = [float("inf"), self._youngest[0] if follows else float("inf")]
        self._began = now
