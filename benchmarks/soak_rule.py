"""The judge's own status rule, in plain words: what was sent decides when an estimate must not be GOOD.

It is an upper bound. Where two topics race, or a threshold is close, it says nothing: neither that an estimate must not
be GOOD nor that it has to be.

    a start, a gap above max_gap or a step back by more: not GOOD for 0.2 s
    a sample that is no number, older than one before, a jump, or several steps late: not GOOD for 0.2 s
    a stamp that is older than max_age when the sample is handed over: that sample, and 0.2 s after
    a channel that the damper's force depends on is silent beyond its age, or its last value cannot be: not GOOD
"""

from collections import Counter
from dataclasses import dataclass, field
from math import isfinite

SETTLING = 200_000_000  # ns
MAX_GAP = 100_000_000  # ns
MAX_AGE = 0.5  # s
LARGEST = 1e6  # m; beyond, a displacement counts as no number
JUMP, SPEED = 0.001, 5.0  # m, and m/s beyond which it is one
LATE = 7  # usual steps; the node counts from three on, of a step that it learns
RACE = 0.03  # s by which messages of two topics may overtake each other
COMMAND_AGE = 0.5  # s, longest; a command that comes often is silent sooner


@dataclass
class Displacement:
    """Of one damper; stamps in ns. ``counts`` by the names of /diagnostics."""

    step: int
    counts: Counter[str] = field(default_factory=Counter)
    last: int | None = None
    value: float = 0.0
    forbidden_until: int = -(2**62)
    reason: str = ""

    def take(self, stamp: int, value: float) -> bool:
        """One sample; whether it is answered."""
        counts = self.counts
        counts["samples"] += 1
        if not (isfinite(value) and abs(value) <= LARGEST):
            counts["dropped: not finite"] += 1
            self.forbid("no number")
            return False
        if self.last is not None:
            step = stamp - self.last
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
            elif step > LATE * self.step:
                self.last = stamp
                self.forbid("late")
            elif abs(value - self.value) > max(JUMP, SPEED * step / 1e9):
                self.last = stamp
                self.forbid("jump")
        else:
            self.last = stamp
            self.forbid("start")
        counts["estimates"] += 1
        self.last, self.value = stamp, value
        return True

    def forbid(self, reason: str) -> None:
        """From the last good sample on."""
        if self.last is not None:
            self.forbidden_until, self.reason = max(self.forbidden_until, self.last + SETTLING), reason

    def verdict(self, stamp: int) -> str:
        """Why a sample must not be GOOD, "" where it may be."""
        return self.reason if stamp < self.forbidden_until else ""


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
        """Why a sample at this time must not be GOOD, "" where it may be."""
        if self.is_wrong and now - self.changed > RACE:
            return "value that cannot be"
        if self.heard is not None and now - self.heard > self.age + RACE:
            return "silent"
        return ""
