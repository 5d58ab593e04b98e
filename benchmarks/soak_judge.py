"""The independent judge: holds every answer against the truth and against what was sent (`soak_rule`).

A force marked GOOD may differ from the truth by three times its force_stddev; where the model itself is off by more
than two of them on undisturbed input, by one more than it is. Nothing else is allowed, but for what nobody could have
known from the messages: each such stretch has an excuse in words, is counted, and its worst error is reported.
"""

import time
from collections import Counter, defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field
from math import isfinite

import numpy as np
from soak_plant import LIMITS, NAMES, SAFE, TEMPERATURE
from soak_rule import COMMAND_AGE, MAX_AGE, RACE, Displacement, Slow
from soak_wire import Commands, Forces, States

GOOD, STALE = 0, 4
SIGMAS = 3.0
RECENT = 5000  # messages
LAGGING = 0.05  # s to an answer
LATCH = 0.8  # s without GOOD after the rule's 0.2 s: a second after the cause
FOLLOWS = 0.1  # s that commands may lag behind what is sent
MEMORY = 0.15  # s for which the force remembers what nobody could know
BEYOND = 0.1 * (LIMITS[1] - LIMITS[0])
ROLES = {
    "current": (LIMITS[0] - BEYOND, LIMITS[1] + BEYOND, COMMAND_AGE), "temperature": TEMPERATURE,
    "acceleration": (-1e4, 1e4, 0.1),
}  # fmt: skip


@dataclass
class Sent:
    """One displacement message on its way; lists over the dampers."""

    time: float
    truth: np.ndarray
    undisturbed: np.ndarray
    verdicts: list[str]
    excuses: list[str]
    kinds: tuple[str, ...]
    handed: float


@dataclass
class Tally:
    """Of one fault kind."""

    rounds: int = 0
    good: int = 0
    beyond: int = 0
    excused: int = 0
    worst: float = 0.0
    worst_excused: float = 0.0
    violations: int = 0


@dataclass
class Judge:
    """Of one campaign; ``violations`` in words with the time of the first of each, in order."""

    step: int
    heeds_temperature: list[bool]
    stddev: np.ndarray
    rules: list[Displacement] = field(init=False)
    slow: dict[str, list[Slow]] = field(init=False)
    pending: dict[int, Sent] = field(default_factory=dict)
    tallies: dict[str, Tally] = field(default_factory=lambda: defaultdict(Tally))
    violations: dict[str, str] = field(default_factory=dict)
    excuses: Counter[str] = field(default_factory=Counter)
    missing: list[int] = field(default_factory=lambda: [0] * len(NAMES))
    malformed: int = 0
    round: int = 0
    unheard: int = 0  # answers that were lost on their way to us
    is_paused: bool = True
    is_fused: bool = False  # whether the accelerometers are taken in
    is_safe_changed: bool = False  # while another safe current than SAFE may be commanded
    wished: list[float] = field(default_factory=lambda: [float("-inf")] * len(NAMES))  # when each was, finite

    def __post_init__(self) -> None:
        self.start()

    def start(self) -> None:
        """Begins with a node that has heard nothing yet."""
        self.rules = [Displacement(self.step) for _ in NAMES]
        self.slow = {role: [Slow(*bounds) for _ in NAMES] for role, bounds in ROLES.items()}
        self.pending.clear()
        self.missing, self.malformed = [0] * len(NAMES), 0
        self._recent: dict[int, Sent] = {}
        self._sequence, self._lagging_until = 0, float("-inf")
        self._excused = [("", float("-inf"))] * len(NAMES)
        self._fine = [float("-inf")] * len(NAMES)  # last time that GOOD was there, or was not to be expected
        self._followed = [float("-inf")] * len(NAMES)
        self._free = [float("-inf")] * len(NAMES)  # last time that a sample might be GOOD

    def pause(self, is_paused: bool, now: float) -> None:
        """While the node need not answer."""
        self.is_paused = is_paused
        self.expect_nothing(range(len(NAMES)), now)
        self._free = [now] * len(NAMES)

    def expect_nothing(self, dampers: Iterable[int], now: float) -> None:
        """GOOD and a loop that follows are not expected of some dampers at this time."""
        for k in dampers:
            self._fine[k] = self._followed[k] = now

    def excuse(self, k: int, reason: str, until: float) -> None:
        """What nobody could know of one damper, up to a time."""
        self._excused[k] = reason, until

    def hear_slow(self, role: str, k: int, value: float, now: float) -> None:
        """A message of a slow channel is sent."""
        if role in self.slow:
            self.slow[role][k].take(value, now)
            if self.slow[role][k].is_wrong and self._is_heeded(role, k):
                self.expect_nothing([k], now)

    def hear(self, m: States, now: float, age: float, kinds: tuple[str, ...], handed: float) -> None:
        """A displacement message is sent at the steady time ``handed``, s; ``age`` in s of its stamp."""
        if not m.fits:
            self.malformed += 1
            return
        answered = False
        verdicts, excuses = [""] * len(NAMES), [""] * len(NAMES)
        for k, name in enumerate(NAMES):
            place = m.names.index(name) if name in m.names else len(m.values)
            if place >= len(m.values):
                self.missing[k] += 1
                continue
            rule = self.rules[k]
            is_answered = rule.take(m.stamp, m.values[place])
            answered |= is_answered
            if is_answered and age > MAX_AGE + RACE:
                rule.forbid("too old on arrival")
            if is_answered and m.foreign:
                rule.forbid("two publishers")
            verdicts[k] = rule.verdict(m.stamp) or self._slow_verdict(k, now)
            excuses[k] = self._excuse(k, now)
            if not verdicts[k]:
                self._free[k] = now
        if answered:
            sent = self.pending[m.stamp] = Sent(now, m.truth, m.undisturbed, verdicts, excuses, kinds, handed)
            self._recent[m.stamp] = sent
            if len(self._recent) > RECENT:
                del self._recent[next(iter(self._recent))]

    def _is_heeded(self, role: str, k: int) -> bool:
        """Whether the estimate of a damper depends on a channel."""
        return {"current": True, "temperature": self.heeds_temperature[k], "acceleration": self.is_fused}[role]

    def _slow_verdict(self, k: int, now: float) -> str:
        for role in (role for role in ROLES if self._is_heeded(role, k)):
            verdict = self.slow[role][k].verdict(now)
            if verdict:
                return f"{role}: {verdict}"
        return ""

    def _excuse(self, k: int, now: float) -> str:
        reason, until = self._excused[k]
        if now <= until:
            return reason
        for role in ("current", "acceleration") if self.is_fused else ("current",):
            heard = self.slow[role][k].heard
            if heard is not None and now - heard > 3.5e-9 * self.step:
                self.expect_nothing([k], now)
                self.excuse(k, f"the {role} is silent, but not yet beyond its age", now + MEMORY)
                return self._excused[k][0]
        return ""

    def waited(self, now: float, stopped: float, excuse: str) -> None:
        """The node goes on after it stood still since ``stopped``; what was handed over in that time and is too old by
        now must not be GOOD, and the rest has an excuse."""
        before = time.monotonic() - MAX_AGE - RACE
        for sent in self.pending.values():
            sent.excuses = [own or excuse for own in sent.excuses]
            if stopped + RACE < sent.handed < before:
                sent.verdicts = [verdict or "waited too long" for verdict in sent.verdicts]
        self._fine = [now] * len(NAMES)

    def answer(self, forces: Forces) -> Sent | None:
        """Judges one message of the node; what it answers."""
        if STALE in forces.status:
            return None
        if forces.stamp not in self.pending:
            return None
        while (first := next(iter(self.pending))) != forces.stamp:  # answers come in order
            del self.pending[first]
            self.unheard += 1
        sent = self.pending.pop(forces.stamp)
        self._consider_lag(sent)
        for name, force, status in zip(forces.names, forces.force, forces.status, strict=True):
            k = NAMES.index(name)
            if not isfinite(force):
                self.violate("a force that is no number", sent.kinds, sent.time)
            elif status == GOOD:
                self._judge_good(k, force, sent)
            if status == GOOD or sent.verdicts[k] or self.is_paused:
                self._fine[k] = sent.time
            elif sent.time - self._fine[k] > LATCH:
                self._fine[k] = sent.time
                self.violate(
                    f"{name} was not GOOD again a second after the cause (status {status})", sent.kinds, sent.time
                )
        return sent

    def _consider_lag(self, sent: Sent) -> None:
        """Where node or machine cannot keep up, samples wait: then they meet the current of a later time, and
        may be too old."""
        lag = time.monotonic() - sent.handed
        if lag > LAGGING:
            self._lagging_until = sent.time + MEMORY
        if sent.time <= self._lagging_until:
            sent.excuses = [own or "the machine could not keep up" for own in sent.excuses]
        if lag > 0.5 * MAX_AGE:
            self.expect_nothing(range(len(NAMES)), sent.time)

    def _judge_good(self, k: int, force: float, sent: Sent) -> None:
        if sent.verdicts[k]:
            self.violate(f"GOOD although: {sent.verdicts[k]}", sent.kinds, sent.time)
        sigma, truth = self.stddev[k], sent.truth[k]
        error = abs(force - truth)
        model = abs(sent.undisturbed[k] - truth)
        is_off = error > max(SIGMAS * sigma, model + sigma)
        for kind in sent.kinds or ("no fault",):
            tally = self.tallies[kind]
            tally.good += 1
            if sent.excuses[k]:
                tally.worst_excused = max(tally.worst_excused, error / sigma)
                tally.excused += is_off
            else:
                tally.worst = max(tally.worst, error / sigma)
                tally.beyond += error > SIGMAS * sigma
        if is_off and sent.excuses[k]:
            self.excuses[sent.excuses[k]] += 1
        elif is_off:
            what = f"GOOD but {error / sigma:.1f} standard deviations off"
            self.violate(what, sent.kinds, sent.time, f"{NAMES[k]}: {force:.0f} N, truth {truth:.0f} N, "
                         f"undisturbed {sent.undisturbed[k]:.0f} N", "GOOD but off")  # fmt: skip

    def command(self, k: int, value: float, now: float) -> None:
        """Judges one command; ``now`` is the time of the last sample that was answered."""
        if not (isfinite(value) and LIMITS[0] <= value <= LIMITS[1]):
            self.violate(f"a command outside the limits: {value:g} A", (), now, key="a command outside the limits")
        if value != SAFE:
            self._followed[k] = now

    def stamped_command(self, own: Commands, now: float) -> None:
        """Judges a stamped command against what was sent with its stamp."""
        if own.sequence <= self._sequence:
            self.violate(f"command {own.sequence} after {self._sequence}", (), now, key="commands are numbered wrong")
        self._sequence = own.sequence
        sent = self._recent.get(own.stamp)
        for name, current, is_valid in zip(own.names, own.current, own.valid, strict=True):
            kinds, k = sent.kinds if sent else (), NAMES.index(name)
            if not (isfinite(current) and LIMITS[0] <= current <= LIMITS[1]):
                self.violate(
                    f"a command outside the limits: {current:g} A", kinds, now, key="a command outside the limits"
                )
            if not is_valid and current != SAFE and not self.is_safe_changed:
                self.violate(f"{current:g} A instead of the safe current", kinds, now, key="not the safe current")
            if is_valid and sent and sent.verdicts[k] and not self.is_paused:
                self.violate(f"followed although: {sent.verdicts[k]}", kinds, now)

    def watch_loop(self, now: float, commanded: list[float], kinds: tuple[str, ...], is_backed_up: bool) -> None:
        """Whether the loop follows, and whether it is left at the safe current where it must be."""
        for k, name in enumerate(NAMES):
            free, wished = now - self._free[k] <= FOLLOWS, now - self.wished[k] <= FOLLOWS
            if self.is_paused or is_backed_up or not (free and wished):
                self._followed[k] = max(self._followed[k], now)
            elif now - self._followed[k] > LATCH:
                self._followed[k] = now
                self.violate(f"{name}: the loop did not follow again within a second", kinds, now)
            silent = now - self._free[k] > 3.0 * FOLLOWS or now - self.wished[k] > 3.0 * FOLLOWS
            if silent and not is_backed_up and not self.is_paused and not self.is_safe_changed and commanded[k] != SAFE:
                self.violate(f"commanded {commanded[k]:.2f} A where the safe current was due", kinds, now, name,
                             "commanded where the safe current was due")  # fmt: skip

    def violate(self, what: str, kinds: tuple[str, ...], now: float, more: str = "", key: str = "") -> None:
        """Notes a violation; the first of its sort in words."""
        for kind in kinds or ("no fault",):
            self.tallies[kind].violations += 1
        during = " + ".join(kinds) or "no fault"
        sort = f"{key or what} ({during})"
        if sort not in self.violations:
            self.violations[sort] = (
                f"round {self.round}, at {now:.3f} s: {what}; during or after {during} {more}".rstrip()
            )
            print(f"VIOLATION {self.violations[sort]}", flush=True)
