"""Whether the current that a driver reports can be the one that flowed at a sample. Knows no ROS.

A current has no stamp. Two things tell that it is not the one that the model must see:

- *It contradicts the node's own commands*: a driver follows within its lag, so what it reports lies between the lowest
  and the highest command of the last ``lag`` s, give or take a tenth of what can be commanded. A stuck, disconnected or
  wrongly scaled sensor and a driver that does not follow leave that band.
- *It came after the sample was taken*: a sample that waited on its way meets the current of a later moment.
"""

from collections import deque

AHEAD = 50_000_000  # ns by which a current may have come after the sample's time
TOLERANCE = 0.1  # of the width of the limits
_FRESH = 0.25  # s since the last command from which on the node no longer commands


class CurrentCheck:
    """The current of one damper, as the node commands it and as its driver reports it; final.

    Attributes:
        heard_at: ns of this machine's clock, when the last report came; 0 before the first.
        is_contradicted: whether it contradicts the commands.
        measured, low, high: A, the last report and the band in which it was to be.
    """

    def __init__(self, width: float, lag: float) -> None:
        """``width`` in A of the commands that are possible, NaN where there are none; ``lag`` in s within which the
        driver follows, 0 to compare nothing."""
        self.heard_at, self.is_contradicted = 0, False
        self.measured = self.low = self.high = float("nan")
        self._tolerance, self._lag = TOLERANCE * width, lag
        self._commands: deque[tuple[float, float]] = deque()  # steady time and A, the oldest older than the lag

    def command(self, value: float, now: float) -> None:
        """A command in A leaves at the steady time ``now``, s."""
        if not self._lag:
            return
        own = self._commands
        if own and not 0.0 <= now - own[-1][0] <= _FRESH:  # nothing is known of what was commanded in between
            own.clear()
        own.append((now, value))
        while len(own) > 1 and own[1][0] <= now - self._lag:
            own.popleft()

    def take(self, value: float, now: float, received: int) -> None:
        """A report in A comes at the steady time ``now``, s, and ``received`` in ns of this machine's clock."""
        self.heard_at, own = received, self._commands
        if not own:
            return
        if not (own[0][0] <= now - self._lag and now - own[-1][0] <= _FRESH):
            self.is_contradicted = False
            return
        flowed = [command for _, command in own]
        self.measured, self.low, self.high = value, min(flowed) - self._tolerance, max(flowed) + self._tolerance
        # NaN is not taken in by the line, and judged there.
        self.is_contradicted = value < self.low or value > self.high

    def is_ahead(self, stamp: int, fastest: float) -> bool:
        """Whether the report came after a sample of this stamp (ns) was taken; ``fastest`` in s is how long the fastest
        of the samples took to arrive."""
        return self.heard_at - stamp > fastest * 1e9 + AHEAD

    def complaint(self) -> str:
        """What is wrong, in words; "" where nothing is."""
        if not self.is_contradicted:
            return ""
        return (
            f"the driver reports {self.measured:.3g} A, the commands allow {self.low:.3g} to {self.high:.3g} A: it "
            "does not follow within command_lag, its report is wrong, or another node commands it"
        )
