"""The judge's status rule: the sent messages decide when an estimate must not be GOOD.

It is an upper bound. If two topics race, or a value is close to a threshold, an estimate may be GOOD or not.

    a start, a gap above max_gap or a step back by more: not GOOD for 0.2 s
    a sample that is not finite, older than an earlier one, a jump, or several usual steps late: not GOOD for 0.2 s
    a stamp older than max_age when the sample is published: that sample, and 0.2 s after
    the same value for longer than its noise allows: not GOOD
    a channel that affects the damper's force is older than its limit, or its last value is impossible: not GOOD
    a current that the recent commands do not allow: not GOOD
"""

from collections import Counter, deque
from dataclasses import dataclass, field
from math import isfinite

SETTLING = 200_000_000  # ns
MAX_GAP = 100_000_000  # ns
MAX_AGE = 0.5  # s
LARGEST = 1e6  # m; a larger displacement counts as not finite
JUMP, SPEED = 0.001, 5.0  # m and m/s, limits of a plausible step
LATE = 7  # usual steps; the node allows three, of a learned step
RECENT, LONGEST_ONES = 100, 20  # steps that the node can have learned from, and steps whose mean bounds the learned one
RACE = 0.03  # s by which messages of two topics can overtake each other
COMMAND_AGE, FELT_AGE = 0.05, 0.02  # s, of channels sent with every sample
COMMAND_LAG = 0.03  # s, lag of the drivers in the node's parameters
AHEAD = 0.05  # s, largest delay of a sample if a current arrived since
LEARNING = 10.0  # s after which a sensor's noise is known
STILL = 0.1  # s for which the noisy displacement can be constant


@dataclass
class Displacement:
    """The displacement of one damper; stamps in ns. ``counts`` by the names of /diagnostics."""

    step: int
    counts: Counter[str] = field(default_factory=Counter)
    last: int | None = None
    value: float = 0.0
    still: int = 0  # ns for which equal values have come; a gap between two of them hides what came in it
    forbidden_until: int = -(2**62)
    reason: str = ""
    since: int = 0  # ns, start of the node's learning of the sensor's noise
    is_unknown: bool = False  # whether it is constant before the noise is known
    steps: deque[int] = field(default_factory=lambda: deque(maxlen=RECENT))  # ns, the last ones

    @property
    def usual(self) -> float:
        """ns, the longest step that the node can consider usual: above the nominal one if this machine is too slow and
        stamps leap often; unlimited before the first step."""
        longest = sorted(self.steps)[-LONGEST_ONES:]
        return sum(longest) / len(longest) if longest else float("inf")

    def take(self, stamp: int, value: float) -> bool:
        """Processes one sample; returns whether it is answered."""
        counts = self.counts
        counts["samples"] += 1
        if not (isfinite(value) and abs(value) <= LARGEST):
            counts["dropped: not finite"] += 1
            self.forbid("not finite")
            return False
        step = 0 if self.last is None else stamp - self.last
        if self.last is not None:
            if step == 0:
                counts["dropped: equal stamp"] += 1
                return False
            if -MAX_GAP <= step < 0:
                counts["dropped: older stamp"] += 1
                self.forbid("older stamp")
                return False
            if not -MAX_GAP <= step <= MAX_GAP:
                counts["resets: gap" if step > 0 else "resets: clock stepped back"] += 1
                self.forbidden_until = stamp
                self.last = stamp
                self.forbid("reset")
                self.steps.clear()
            elif step > LATE * self.step and step > LATE * self.usual:
                self.last = stamp
                self.forbid("late")
            elif abs(value - self.value) > max(JUMP, SPEED * step / 1e9):
                self.last = stamp
                self.forbid("jump")
            if 0 < step <= MAX_GAP:
                self.steps.append(step)
        else:
            self.last = stamp
            self.forbid("start")
        counts["estimates"] += 1
        self.still = self.still + min(max(step, 0), 2 * self.step) if value == self.value else 0
        self.last, self.value = stamp, value
        is_still, self.since = self.still > STILL * 1e9, self.since or stamp
        self.is_unknown = is_still and stamp - self.since < LEARNING * 1e9
        if is_still and not self.is_unknown:
            self.forbid("stands still")
        return True

    def relearn(self) -> None:
        """The node can have lost the learned properties of the sensor."""
        self.since = 0
        self.steps.clear()

    def forbid(self, reason: str) -> None:
        """Forbids GOOD from the last good sample on."""
        if self.last is not None:
            self.forbidden_until, self.reason = max(self.forbidden_until, self.last + SETTLING), reason

    def verdict(self, stamp: int, race: float = 0.0) -> str:
        """Why a sample must not be GOOD, "" if it may be; ``race`` in s, by which the node can have received the cause
        before it was sent."""
        return self.reason if stamp + round(race * 1e9) < self.forbidden_until else ""


@dataclass
class Current:
    """The current reported by a driver compared with its commands; A, and times of the campaign in s."""

    low: float
    high: float
    commands: deque[tuple[float, float]] = field(default_factory=deque)
    since: float | None = None
    handed: deque[int] = field(default_factory=lambda: deque(maxlen=5000))

    def command(self, value: float, now: float) -> None:
        """A command received by the driver."""
        self.commands.append((now, value))
        while len(self.commands) > 1 and self.commands[1][0] <= now - COMMAND_LAG - RACE:
            self.commands.popleft()

    def came_after(self, stamp: int, clock: int) -> float:
        """s from a stamp to the newest report that cannot be delayed by a race at a clock; both in ns."""
        while len(self.handed) > 1 and self.handed[1] <= clock - RACE * 1e9:
            self.handed.popleft()
        is_old = bool(self.handed) and self.handed[0] <= clock - RACE * 1e9
        return (self.handed[0] - stamp) / 1e9 if is_old else float("-inf")

    def take(self, value: float, now: float, clock: int = 0) -> None:
        """One report, sent at a clock in ns."""
        self.handed.append(clock)
        allowed, slack = [command for _, command in self.commands], 0.15 * (self.high - self.low)
        is_right = not allowed or min(allowed) - slack <= value <= max(allowed) + slack
        self.since = None if is_right else now if self.since is None else self.since

    def is_contradicted(self, now: float) -> bool:
        """Whether the reports have contradicted the commands long enough to be detected."""
        return self.since is not None and now - self.since > RACE and bool(self.commands) and (
            now - self.commands[-1][0] <= RACE
        )  # fmt: skip


@dataclass
class Slow:
    """A slow channel of one damper; times are those of the campaign, s."""

    low: float
    high: float
    age: float
    heard: float | None = None
    is_wrong: bool = False
    changed: float = float("-inf")

    def take(self, value: float, now: float) -> None:
        """One message."""
        is_wrong = not (isfinite(value) and self.low <= value <= self.high)
        if is_wrong != self.is_wrong:
            self.is_wrong, self.changed = is_wrong, now
        if self.heard is not None and now - self.heard > self.age:
            self.changed = max(self.changed, now)
        self.heard = now

    def verdict(self, now: float) -> str:
        """Why a sample at this time must not be GOOD, "" if it may be."""
        if self.is_wrong and now - self.changed > RACE:
            return "impossible value"
        if self.heard is not None and now - self.heard > self.age + RACE:
            return "silent"
        return ""
