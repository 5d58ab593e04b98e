"""The independent judge: compares every answer with the truth and with the sent messages (`soak_rule`).

A force marked GOOD may differ from the truth by at most three times its force_stddev, except for faults that the
messages cannot reveal: each such period has an excuse in words, is counted, and its worst error is reported.
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
RECENT, LAGGING = 5000, 0.05  # messages; s until an answer
LATCH = 0.8  # s without GOOD after the rule's 0.2 s: one second after the cause
FOLLOWS, MEMORY = 0.1, 0.15  # s, largest lag of commands; s, memory of the force for unknowable inputs
SET_BACK, FORGET = 0.1, 0.05  # s, step back of a clock; s per s, decay of the age of the fastest sample
DIFFERENT = 0.02  # A
BELIEVED = "a wrong current that recent commands allow, or have contradicted only briefly"
WAITED_LITTLE = "a delayed sample is used with the present current, which has no stamp"
ROLES = {
    "current": (1.1 * LIMITS[0] - 0.1 * LIMITS[1], 1.1 * LIMITS[1] - 0.1 * LIMITS[0], COMMAND_AGE),
    "temperature": TEMPERATURE, "acceleration": (-1e4, 1e4, FELT_AGE),
}  # fmt: skip


@dataclass
class Judge:
    """The judge of one campaign; ``violations`` in words with the time of the first of each, in order."""

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
    unheard: int = 0  # answers lost on their way to this process
    is_paused: bool = True
    is_fused: bool = False  # whether the accelerometers are used
    is_safe_changed: bool = False  # while a safe current other than SAFE can be commanded
    desired_at: list[float] = field(default_factory=lambda: [float("-inf")] * len(NAMES))  # s, last finite request

    def __post_init__(self) -> None:
        self.start()

    def start(self) -> None:
        """Starts with a node that has received nothing yet."""
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
        self._fine = [float("-inf")] * len(NAMES)  # last time of GOOD, or at which GOOD was not expected
        self._followed = [float("-inf")] * len(NAMES)
        self._free = [float("-inf")] * len(NAMES)  # last time at which a sample could be GOOD

    def pause(self, is_paused: bool, now: float) -> None:
        """Sets whether the node need not answer."""
        self.is_paused = is_paused
        for rule in self.rules:
            rule.relearn()
        self.expect_nothing(range(len(NAMES)), now)
        self._free = [now] * len(NAMES)

    def expect_nothing(self, dampers: Iterable[int], now: float) -> None:
        """Some dampers need not be GOOD nor follow at this time."""
        for k in dampers:
            self._fine[k] = self._followed[k] = now

    def excuse(self, k: int, reason: str, until: float) -> None:
        """Excuses one damper for an unknowable fault up to a time."""
        self._excused[k] = reason, until

    def hear_slow(self, role: str, k: int, value: float, right: float, now: float) -> None:
        """A message of a slow channel is sent; ``right`` is its true value."""
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
            if rule.is_unknown:  # the node may or may not know the sensor's noise by now
                self.excuse(k, "it is constant, its noise was not observed long enough", now + MEMORY)
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
        """s, additional delay of a sample relative to the fastest recent one, on the same clock."""
        if stamp < self._stamp - SET_BACK * 1e9:
            self._fastest = float("inf")
        self._fastest = min(age, self._fastest + FORGET * min(max(handed - self._handed, 0.0), 0.1))
        self._stamp, self._handed = stamp, handed
        return age - self._fastest

    def _is_racing(self, m: States, now: float) -> bool:
        """Whether a second publisher has just started: the order of both is unknown."""
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
                self.excuse(k, f"the {role} is silent, but not yet too old", now + MEMORY)
                return self._excused[k][0]
        return ""

    def waited(self, now: float, stopped: float, excuse: str) -> None:
        """The node continues after a stop since ``stopped``; samples from that time that are too old now must not be
        GOOD, the others are excused."""
        before = time.monotonic() - MAX_AGE - RACE
        for sent in self.pending.values():
            sent.excuses = [reason or excuse for reason in sent.excuses]
            if stopped + RACE < sent.handed < before:
                sent.verdicts = [verdict or "waited too long" for verdict in sent.verdicts]
        self._fine = [now] * len(NAMES)

    def answer(self, forces: Forces) -> Sent | None:
        """Judges one message of the node; returns the message that it answers."""
        if STALE in forces.status or forces.stamp not in self.pending:
            return None
        while (first := next(iter(self.pending))) != forces.stamp:  # answers arrive in order
            del self.pending[first]
            self.unheard += 1
        sent = self.pending.pop(forces.stamp)
        self._consider_lag(sent)
        for name, force, status in zip(forces.names, forces.force, forces.status, strict=True):
            k = NAMES.index(name)
            if not isfinite(force):
                self.violate("a non-finite force", sent.kinds, sent.time)
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
        """If node or machine cannot keep up, samples wait: they are then used with a later current and can be too
        old."""
        lag = time.monotonic() - sent.handed
        if lag > LAGGING:
            self._lagging_until = sent.time + MEMORY
        if sent.time <= self._lagging_until:
            sent.excuses = [reason or "the machine could not keep up" for reason in sent.excuses]
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

    def stamped_command(self, message: Commands, now: float) -> None:
        """Judges a stamped command against what was sent with its stamp."""
        if message.sequence <= self._sequence:
            what = f"command {message.sequence} after {self._sequence}"
            self.violate(what, (), now, key="commands are numbered wrong")
        self._sequence = message.sequence
        sent = self._recent.get(message.stamp)
        for name, current, is_valid in zip(message.names, message.current, message.valid, strict=True):
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
        """Checks that the loop follows, and is left at the safe current when required."""
        for k, name in enumerate(NAMES):
            free, desired = now - self._free[k] <= FOLLOWS, now - self.desired_at[k] <= FOLLOWS
            if self.is_paused or is_backed_up or not (free and desired):
                self._followed[k] = max(self._followed[k], now)
            elif now - self._followed[k] > LATCH:
                self._followed[k] = now
                self.violate(f"{name}: the loop did not follow again within a second", kinds, now)
            silent = now - self._free[k] > 3.0 * FOLLOWS or now - self.desired_at[k] > 3.0 * FOLLOWS
            if silent and not is_backed_up and not self.is_paused and not self.is_safe_changed and commanded[k] != SAFE:
                self.violate(f"commanded {commanded[k]:.2f} A when the safe current was due", kinds, now, name,
                             "commanded when the safe current was due")  # fmt: skip

    def violate(self, what: str, kinds: tuple[str, ...], now: float, more: str = "", key: str = "") -> None:
        """Records a violation; the first of its kind in words."""
        for kind in kinds or ("no fault",):
            self.tallies[kind].violations += 1
        during = " + ".join(kinds) or "no fault"
        sort = f"{key or what} ({during})"
        if sort not in self.violations:
            self.violations[sort] = (
                f"round {self.round}, at {now:.3f} s: {what}; during or after {during} {more}".rstrip()
            )
            print(f"VIOLATION {self.violations[sort]}", flush=True)
