"""Whether the current that a driver reports can be the one that flowed at a sample. Independent of ROS.

A current has no stamp. Two facts show that it is not the current that the model needs:

- *It contradicts the node's commands*: a driver follows within its lag, so the reported current lies between the lowest
  and the highest command of the last ``lag`` s, with a tolerance of a tenth of the command range. A stuck, disconnected
  or wrongly scaled sensor and a driver that does not follow leave that band.
- *It came after the sample was taken*: a sample that was delayed meets the current of a later moment.
"""

from collections import deque

AHEAD = 50_000_000  # ns by which a current can come after the sample's time
TOLERANCE = 0.1  # of the width of the limits
_FRESH = 0.25  # s after the last command until the node counts as not commanding


class CurrentCheck:
    """The current of one damper, as the node commands it and as its driver reports it; final.

    Attributes:
        reported_at: ns of this machine's clock, when the last report came; 0 before the first.
        is_contradicted: whether it contradicts the commands.
        measured, low, high: A, the last report and the band that the commands allow.
    """

    def __init__(self, width: float, lag: float) -> None:
        """``width`` in A of the command range, NaN if there is none; ``lag`` in s within which the driver follows, 0 to
        compare nothing.
        """
        self.reported_at, self.is_contradicted = 0, False
        self.measured = self.low = self.high = float("nan")
        self._tolerance, self._lag = TOLERANCE * width, lag
        self._commands: deque[tuple[float, float]] = deque()  # steady time and A, the oldest older than the lag

    def note_command(self, value: float, now: float) -> None:
        """Notes a command in A at the steady time ``now``, s."""
        if not self._lag:
            return
        commands = self._commands
        if commands and not 0.0 <= now - commands[-1][0] <= _FRESH:  # the commands in between are unknown
            commands.clear()
        commands.append((now, value))
        while len(commands) > 1 and commands[1][0] <= now - self._lag:
            commands.popleft()

    def note_report(self, value: float, now: float, received: int) -> None:
        """Notes a report in A at the steady time ``now``, s, and ``received`` in ns of this machine's clock."""
        self.reported_at, commands = received, self._commands
        if not commands:
            return
        if not (commands[0][0] <= now - self._lag and now - commands[-1][0] <= _FRESH):
            self.is_contradicted = False
            return
        flowed = [command for _, command in commands]
        self.measured, self.low, self.high = value, min(flowed) - self._tolerance, max(flowed) + self._tolerance
        # The line rejects and counts NaN.
        self.is_contradicted = value < self.low or value > self.high

    def is_ahead(self, stamp: int, fastest: float) -> bool:
        """Whether the report came after a sample of this stamp (ns) was taken; ``fastest`` in s is the shortest time
        that a sample took to arrive.
        """
        return self.reported_at - stamp > fastest * 1e9 + AHEAD

    def complaint(self) -> str:
        """The contradiction in words; "" if there is none."""
        if not self.is_contradicted:
            return ""
        return (
            f"the driver reports {self.measured:.3g} A, the commands allow {self.low:.3g} to {self.high:.3g} A: it "
            "does not follow within command_lag, its report is wrong, or another node commands it"
        )
