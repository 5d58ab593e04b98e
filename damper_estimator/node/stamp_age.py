"""The age of samples on arrival. Independent of ROS."""

RELATED = 60.0  # s by which two clocks of the same time can differ
RISE = 0.05  # s per s, by which the age of the fastest sample rises
LONGEST_RISE = 0.1  # s between two samples that count; in a longer pause they are delayed
_WINDOW = 60_000_000_000  # ns over which the fastest message is remembered, twice
_OUT_OF_ORDER = (
    100_000_000  # ns by which a message can come after a newer one; a larger step back is a clock that was set
)


class StampAge:
    """Whether the messages of one topic took too long; final.

    The age of a sample is the time between its stamp and its arrival. A stamp ahead of this machine's clock shows that
    the clocks differ: then the age counts from the youngest sample of the last minutes, or since the sender's clock was
    set back. If even the youngest is more than ``RELATED`` old or ahead, the stamps belong to another clock (a
    recording that is being played), and the age is unknown.

    Attributes:
        age: s, of the last sample, by the clocks.
        late: number of samples that were too old.
        fastest: s, age of the youngest recent sample; rises slowly, so that it follows a clock that was set by less
            than samples come out of order. Infinite before the first.
    """

    def __init__(self) -> None:
        self.age = float("nan")
        self.late = 0
        self.fastest = float("inf")
        self._now = 0
        self._windows = [float("inf"), float("inf")]  # age of the youngest of this window and of the one before
        self._youngest = float("inf")  # of both
        self._began = -(2**63)
        self._stamp = 0

    @property
    def is_related(self) -> bool:
        """Whether the stamps are of this machine's time; true before the first."""
        return self._youngest == float("inf") or abs(self._youngest) <= RELATED

    def is_late(self, stamp: int, now: int, max_age: float, is_simulated: bool = False) -> bool:
        """Takes a sample; both times in ns, ``max_age`` in s, 0 judges nothing.

        Simulated time is the same for all nodes: if a stamp is ahead of it, the clock's message has not arrived yet.
        """
        if is_simulated and now < stamp:
            now = stamp
        age = self.age = (now - stamp) * 1e-9
        is_set_back = stamp < self._stamp - _OUT_OF_ORDER
        if is_set_back:
            self.fastest = float("inf")
        passed = (now - self._now) * 1e-9
        if passed > 0.0:
            self.fastest += RISE * (passed if passed < LONGEST_RISE else LONGEST_RISE)
        if age < self.fastest:
            self.fastest = age
        self._now = now
        if is_set_back or not self._began <= now < self._began + _WINDOW:
            self._turn(now, is_set_back)
        self._stamp = stamp
        if age < self._windows[0]:
            self._windows[0] = age
            self._youngest = min(self._windows)
        ahead = self._youngest if self._youngest < 0.0 else 0.0
        if not 0.0 < max_age < age - ahead or not self.is_related:  # nearly always
            return False
        self.late += 1
        return True

    def _turn(self, now: int, is_other_clock: bool) -> None:
        follows = self._began + _WINDOW <= now < self._began + 2 * _WINDOW and not is_other_clock
        self._windows = [float("inf"), self._windows[0] if follows else float("inf")]
        self._youngest, self._began = min(self._windows), now
