"""The independent judge: holds every answer against the truth and against what was sent (`soak_rule`).

A force marked GOOD may differ from the truth by three times its force_stddev. Nothing else is allowed, but for what
nobody could have known from the messages: each such stretch has an excuse in words, is counted, and its worst error is
reported.
"""

import time
from collections import Counter, defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field
from math import isfinite

import numpy as np
from soak_plant import LIMITS, NAMES, SAFE, TEMPERATURE
from soak_rule import AHEAD, COMMAND_AGE, FELT_AGE, MAX_AGE, RACE, SETTLING, Current, Displacement, Slow
from soak_tally import Sent, Tally
from soak_wire import Commands, Forces, States

GOOD, STALE, SIGMAS = 0, 4, 3.0
RECENT, LAGGING = 5000, 0.05  # messages; s to an answer
LATCH = 0.8  # s without GOOD after the rule's 0.2 s: a second after the cause
FOLLOWS, MEMORY = 0.1, 0.15  # s that commands may lag; s for which the force remembers what nobody could know
SET_BACK, FORGET = 0.1, 0.05  # s of a step back of a clock; s per s by which the age of the fastest is forgotten
DIFFERENT = 0.02  # A
BELIEVED = "a wrong current that the commands of the last moment allow, or have not contradicted for long"
WAITED_LITTLE = "a sample that waited for a moment meets the current of now, which has no stamp"
ROLES = {
    "current": (1.1 * LIMITS[0] - 0.1 * LIMITS[1], 1.1 * LIMITS[1] - 0.1 * LIMITS[0], COMMAND_AGE),
    "temperature": TEMPERATURE, "acceleration": (-1e4, 1e4, FELT_AGE),
}  # fmt: skip


@dataclass
class Judge:
    """Of one campaign; ``violations`` in words with the time of the first of each, in order."""

    step: int
    heeds_temperature: list[bool]
    stddev: np.ndarray
    rules: list[Displacement] = field(init=False)
    slow: dict[str, list[Slow]] = field(init=False)
    currents: list[Current] = field(init=False)
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
        self.currents = [Current(*LIMITS) for _ in NAMES]
        self.slow = {role: [Slow(*bounds) for _ in NAMES] for role, bounds in ROLES.items()}
        self.pending.clear()
        self.missing, self.malformed = [0] * len(NAMES), 0
        self._recent: dict[int, Sent] = {}
        self._sequence = 0
        self._lagging_until = self._foreign = self._racing_since = float("-inf")
        self._stamp, self._fastest, self._handed = 0, float("inf"), 0.0
        self._excused = [("", float("-inf"))] * len(NAMES)
        self._fine = [float("-inf")] * len(NAMES)  # last time that GOOD was there, or was not to be expected
        self._followed = [float("-inf")] * len(NAMES)
        self._free = [float("-inf")] * len(NAMES)  # last time that a sample might be GOOD

    def pause(self, is_paused: bool, now: float) -> None:
        """While the node need not answer."""
        self.is_paused = is_paused
        for rule in self.rules:
            rule.relearn()
        self.expect_nothing(range(len(NAMES)), now)
        self._free = [now] * len(NAMES)

    def expect_nothing(self, dampers: Iterable[int], now: float) -> None:
        """GOOD and a loop that follows are not expected of some dampers at this time."""
        for k in dampers:
            self._fine[k] = self._followed[k] = now

    def excuse(self, k: int, reason: str, until: float) -> None:
        """What nobody could know of one damper, up to a time."""
        self._excused[k] = reason, until

    def hear_slow(self, role: str, k: int, value: float, right: float, now: float) -> None:
        """A message of a slow channel is sent; ``right`` is what it should say."""
        if role == "current":
            self.currents[k].take(value, now, time.time_ns())
            if abs(value - right) > DIFFERENT:
                self.expect_nothing([k], now)
                self.excuse(k, BELIEVED, now + MEMORY)
        if role in self.slow:
            self.slow[role][k].take(value, now)
            if self.slow[role][k].is_wrong and self._is_heeded(role, k):
                self.expect_nothing([k], now)

    def hear(self, m: States, now: float, age: float, kinds: tuple[str, ...], handed: float) -> None:
        """A displacement message is sent at the steady time ``handed``, s; ``age`` in s of its stamp."""
        if not m.fits:
            self.malformed += 1
            return
        answered, is_racing = False, self._is_racing(m, now)
        waited = self._waited(m.stamp, age, handed)
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
            ahead = self.currents[k].came_after(m.stamp, m.stamp + round(age * 1e9)) - age + waited
            if is_answered and ahead > AHEAD + RACE:
                rule.forbid("waited while currents came")
            elif is_answered and age > AHEAD:
                self.excuse(k, WAITED_LITTLE, now + MEMORY)
            if rule.is_unknown:  # by now the node may know the sensor's noise or not
                self.excuse(k, "it stands still, its noise was not seen for long", now + MEMORY)
                self.expect_nothing([k], now + SETTLING * 1e-9)
            if max(age, waited) > 0.5 * AHEAD:
                self.expect_nothing([k], now)
            race = RACE if now - self._foreign <= 1.0 else 0.0  # messages of two publishers overtake each other
            verdicts[k] = "" if is_racing else rule.verdict(m.stamp, race) or self._slow_verdict(k, now)
            excuses[k] = "two publishers race" if is_racing else self._excuse(k, now)
            if not verdicts[k]:
                self._free[k] = now
        if answered:
            sent = self.pending[m.stamp] = Sent(now, m.truth, m.undisturbed, verdicts, excuses, kinds, handed)
            self._recent[m.stamp] = sent
            if len(self._recent) > RECENT:
                del self._recent[next(iter(self._recent))]

    def _waited(self, stamp: int, age: float, handed: float) -> float:
        """s for which a sample waited longer than the fastest one of late, of the same clock."""
        if stamp < self._stamp - SET_BACK * 1e9:
            self._fastest = float("inf")
        self._fastest = min(age, self._fastest + FORGET * min(max(handed - self._handed, 0.0), 0.1))
        self._stamp, self._handed = stamp, handed
        return age - self._fastest

    def _is_racing(self, m: States, now: float) -> bool:
        """Whether a second publisher has only just begun: which of both comes first is not known."""
        if m.foreign:
            if now - self._foreign > 1.0:
                self._racing_since = now
            self._foreign = now
        return now - self._racing_since <= RACE

    def _is_heeded(self, role: str, k: int) -> bool:
        """Whether the estimate of a damper depends on a channel."""
        return {"current": True, "temperature": self.heeds_temperature[k], "acceleration": self.is_fused}[role]

    def _slow_verdict(self, k: int, now: float) -> str:
        if self.currents[k].is_contradicted(now):
            return "current: contradicts the commands"
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
        if STALE in forces.status or forces.stamp not in self.pending:
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
        if lag > AHEAD:
            self.expect_nothing(range(len(NAMES)), sent.time)

    def _judge_good(self, k: int, force: float, sent: Sent) -> None:
        if sent.verdicts[k]:
            self.violate(f"GOOD although: {sent.verdicts[k]}", sent.kinds, sent.time)
        sigma, truth = self.stddev[k], sent.truth[k]
        error = abs(force - truth)
        is_off = error > SIGMAS * sigma
        for kind in sent.kinds or ("no fault",):
            tally = self.tallies[kind]
            tally.good += 1
            if sent.excuses[k]:
                tally.worst_excused = max(tally.worst_excused, error / sigma)
                tally.excused += is_off
            else:
                tally.worst = max(tally.worst, error / sigma)
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
