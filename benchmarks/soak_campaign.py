"""The campaign: plant, drivers, node and judge sample by sample, and the rounds of faults."""

import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import rclpy
from rclpy.signals import SignalHandlerOptions
from soak_counters import Counters
from soak_faults import Fault, Kind
from soak_judge import MEMORY, Judge
from soak_node import DISPLACEMENT, SoakedNode
from soak_plant import AMBIENT, NAMES, SAFE, STEP, WARMING, Corner, Driver, Sample, Sensors, damper
from soak_rounds import Rounds
from soak_rule import COMMAND_LAG
from soak_slow import Slow
from soak_truth import Filter, Undisturbed
from soak_wire import SECOND, States, commands_in, forces_in, number_in

CUTOFF = 60.0  # Hz
WINDOW = 40  # largest number of unanswered displacement messages
BEHIND = 0.03  # s of delay before the stamps leap
QUIET = 1.4  # s without faults after every round
CHECK_EVERY = 15  # rounds between two checks of the counters
RESTARTS = 0.3  # share of the time in which the process can end, so that memory growth is visible in the rest
PROGRESS_EVERY = 15.0  # s
STUCK = 60.0  # s, longest time without an answer
PATIENCE = 2.0  # s, longest wait for a single answer


class Campaign:
    """The state of one run; final.

    Attributes:
        time: s, of the plant.
        shift: ns, offset of the sender's clock.
        is_held: whether the node is stopped on purpose.
        memory: bytes of the node's process, a list per process.
        behind: number of leaps of the stamps because this process was too slow.
    """

    def __init__(self, folder: Path, models: Path, rate: float, seed: int, kinds: Sequence[Kind], first: int) -> None:
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        self.seed, self.rounds, self._models = seed, Rounds(kinds, seed, first), models
        self._rate, self._steps, self.step_ns = rate, round(1.0 / rate / STEP), round(SECOND / rate)
        self.node = SoakedNode({
            "model": str(models / "models"), "signals": str(models / "plain.yaml"), "safe_current": SAFE,
            "command_lag": COMMAND_LAG,
            "dampers": f"[{', '.join(NAMES)}]", "qos_reliability": "reliable", "qos_depth": 4000, "record": str(folder),
            "record_size": 20, "record_files": 2,
        })  # fmt: skip
        self.corners = [
            Corner(seed % 10_000 + k, damper(WARMING[k], AMBIENT[k], AMBIENT[k])) for k in range(len(NAMES))
        ]
        self.drivers = [Driver() for _ in NAMES]
        self.sensors, self._noise = Sensors(), np.random.default_rng([seed, 1])
        self._undisturbed = Undisturbed(models / "models", models / "plain.yaml")
        self.judge = Judge(self.step_ns, self._undisturbed.heeds_temperature, self._undisturbed.stddev)
        self.time, self.shift, self.stamp, self.is_held = 0.0, 0, 0, False
        self.active: list[Fault] = []
        self._slow = Slow(self.node, self.judge, self.active, self.sensors, self._noise)
        self._recent: list[tuple[str, float]] = []
        self._next, self.sent, self.behind = 1.5, 0, 0
        self._answered, self._heard_at = 0.0, time.monotonic()
        self.memory: list[list[int]] = []
        self.counters = Counters()
        self._filter: Filter | None = None
        self._index = 0

    def run(self, seconds: float) -> None:
        """Drives for ``seconds`` of wall time."""
        print(f"seed {self.seed}", flush=True)
        samples = [self._drive(k) for k in range(len(NAMES))]  # compiles before the first samples
        self._undisturbed.take(0, *np.zeros((2, len(NAMES))).tolist(), samples, [0.0] * len(NAMES))
        self.restart()
        begin, reported = time.monotonic(), 0.0
        while (passed := time.monotonic() - begin) < seconds or self.active:
            self.tick()
            if not self.active and self.time >= self._next and passed < seconds:
                self._begin_round(may_restart=passed < RESTARTS * seconds)
            if passed > reported:
                reported = passed + PROGRESS_EVERY
                print(
                    f"{passed:6.0f} s, {self.time:.0f} s driven, round {self.rounds.number}, "
                    f"{self.node.memory / 1e6:.0f} MB, {len(self.judge.violations)} kinds of violations",
                    flush=True,
                )
        self.check_counts()

    def restart(self) -> None:
        """Starts a new process."""
        self.node.start()
        self.judge.start()
        self._anchor()
        self.judge.pause(False, self.time)
        self.counters.forget()
        self.memory.append([])

    def _anchor(self) -> None:
        """Aligns plant time with wall time."""
        self._wall, self._epoch = time.monotonic() - self.time, time.time_ns() - round(self.time * SECOND)
        self._heard_at = time.monotonic()

    def tick(self) -> None:
        """Runs one sample of plant, node and judge."""
        self._pace()
        self._index += 1
        self.time = self._index / self._rate
        self.stamp = self._epoch + round(self.time * SECOND) + self.shift
        samples = [self._drive(k) for k in range(len(NAMES))]
        random, sensors = self._noise, self.sensors
        displacement = [sensors.displacement_of(sample.travel, random) for sample in samples]
        current = [sample.current + sensors.current * random.standard_normal() for sample in samples]
        felt = [s.acceleration + sensors.offset + sensors.acceleration * random.standard_normal() for s in samples]
        force = np.array([sample.force for sample in samples])
        self._filter = self._filter or Filter(CUTOFF, 1.0 / self._rate, force)
        filtered = self._filter.take(force)
        undisturbed, _ = self._undisturbed.take(round(self.time * SECOND), displacement, current, samples, felt)
        self.truth = force if self._undisturbed.is_fused else filtered
        self._advance_faults()
        is_felt = felt if self._undisturbed.is_fused else None
        self._slow.send(self._index, self.time, self.stamp, self.drivers, samples, current, is_felt, force)
        messages = [States(list(NAMES), displacement, self.stamp, truth=self.truth, undisturbed=undisturbed)]
        for fault in self.active:
            if fault.kind.role == "displacement":
                messages = [changed for m in messages for changed in fault.kind.act(fault, m)]
                fault.k += 1
        for m in messages:
            self.send_states(m)
        self._take()
        if self._index % 10 == 0:
            backed_up = self.is_held or (bool(self.judge.pending) and self.time - self._oldest() > 0.1)
            self.judge.watch_loop(self.time, [d.commanded for d in self.drivers], self._kinds(), backed_up)

    def _oldest(self) -> float:
        return next(iter(self.judge.pending.values())).time

    def _drive(self, k: int) -> Sample:
        return self.corners[k].drive(self._steps, self.drivers[k].step(self.time, 1.0 / self._rate))

    def _pace(self) -> None:
        """Waits for the time of the next sample, and for answers; if this process is too slow the stamps leap."""
        self._paced = time.monotonic()
        due = self._wall + self.time + 1.0 / self._rate
        while time.monotonic() < due or (
            len(self.judge.pending) > WINDOW and not (self.is_held or self.judge.is_paused)
        ):
            if not self._take():
                time.sleep(0.0005)
            self._give_up_lost()
        if time.monotonic() - due > BEHIND and not self.is_held:
            self.behind += 1
            self._anchor()

    def _give_up_lost(self) -> None:
        """Gives up lost answers: the node queues only 100, and after a burst this process can be too slow."""
        if time.monotonic() - self._heard_at > STUCK:
            raise RuntimeError(f"no answer for {STUCK:g} s during {' + '.join(self._kinds())}")
        if len(self.judge.pending) > WINDOW and time.monotonic() - max(self._heard_at, self._paced) > PATIENCE:
            self.judge.unheard += len(self.judge.pending)
            self.judge.pending.clear()

    def send_states(self, m: States, publish: Callable[[bytes], None] | None = None) -> None:
        """Sends a displacement message and informs the judge."""
        data = m.data()
        age = (time.time_ns() - m.stamp) / SECOND
        self.judge.hear(m, self.time, age, self._kinds(), time.monotonic())
        self.sent += 1
        if publish is None:
            self.node.publish(DISPLACEMENT, data)
        else:
            publish(data)

    def _take(self) -> bool:
        """Receives and judges answers; returns whether any arrived."""
        if not self.node.poll():
            return False
        while self.node.forces:
            sent = self.judge.answer(forces_in(self.node.forces.popleft()))
            if sent is not None:
                self._answered, self._heard_at = sent.time, time.monotonic()
        self.take_commands()
        return True

    def take_commands(self) -> None:
        """Passes received commands to the drivers and the judge."""
        while self.node.commands:
            name, data = self.node.commands.popleft()
            k, value = NAMES.index(name), number_in(data)
            self.judge.currents[k].command(value, self.time)
            self.judge.command(k, value, max(self._answered, self.time - 0.05))
            self.drivers[k].take(value, self.time)
        while self.node.stamped_commands:
            self.judge.stamped_command(commands_in(self.node.stamped_commands.popleft()), self.time)

    def settle(self) -> None:
        """Waits until all messages are answered."""
        end = time.monotonic() + PATIENCE
        while self.judge.pending and time.monotonic() < end:
            if not self._take():
                time.sleep(0.002)
        self.judge.unheard += len(self.judge.pending)
        self.judge.pending.clear()

    def rest(self, is_resting: bool) -> None:
        """Sets whether the node is inactive."""
        self.judge.pause(is_resting, self.time)
        self.judge.pending.clear()

    def expect_safe(self, what: str) -> None:
        """Checks that the last command was the safe current."""
        for _ in range(20):
            self._take()
            time.sleep(0.005)
        for k, driver in enumerate(self.drivers):
            if driver.commanded != SAFE:
                self.judge.violate(f"{NAMES[k]} was left at {driver.commanded:.2f} A", self._kinds(), self.time,
                                   what, "not left at the safe current")  # fmt: skip

    def take_turns(self) -> None:
        """Toggles the use of the accelerometers for the next configuration."""
        signals = self._models / ("plain.yaml" if self._undisturbed.is_fused else "fused.yaml")
        self.node.parameters["signals"] = str(signals)
        self._undisturbed = Undisturbed(self._models / "models", signals)
        self.judge.is_fused = self._undisturbed.is_fused

    def _kinds(self) -> tuple[str, ...]:
        return tuple(
            dict.fromkeys([f.kind.name for f in self.active] + [n for n, until in self._recent if self.time < until])
        )

    def _advance_faults(self) -> None:
        for fault in list(self.active):
            fault.is_last = self.time >= fault.until
            if fault.kind.excuse and self.time - fault.began <= fault.kind.excused_for:
                for k in fault.dampers:
                    self.judge.excuse(k, fault.kind.excuse, self.time + MEMORY)
            if fault.kind.is_unsure:
                self.judge.expect_nothing(fault.dampers, self.time)
            is_over = fault.is_last and fault.store.get("announced", False)
            if fault.run is not None:
                is_over = next(fault.run, self) is self
            elif fault.is_last:
                fault.store["announced"] = True  # it acts on one more sample
            if is_over:
                self.active.remove(fault)
                self._recent = [(n, u) for n, u in self._recent if self.time < u] + [(fault.kind.name, self.time + 1.0)]
                self._next = self.time + QUIET

    def _begin_round(self, may_restart: bool) -> None:
        if self.rounds.number % CHECK_EVERY == CHECK_EVERY - 1:
            self.check_counts()
        self.judge.round = self.rounds.number
        for fault in self.rounds.next(self.time, self._undisturbed.is_fused, may_restart):
            fault.run = fault.kind.act(fault, self) if not fault.kind.role else None
            self.active.append(fault)
            self.judge.tallies[fault.kind.name].rounds += 1

    def check_counts(self) -> None:
        """Compares the counters of /diagnostics with the messages sent since the last check; waits for two reports."""
        self.settle()
        self.node.health.clear()
        self.node.wait(lambda: (self._take() and False) or len(self.node.health) > 1, "a report")
        self.counters.check(self.node.values(), self.judge, self.time)
        self.memory[-1].append(self.node.memory)
        self._anchor()
        self.judge.pause(False, self.time)
        self._next = self.time + QUIET

    def close(self) -> None:
        """Ends the node and leaves ROS."""
        self.node.close()
        rclpy.shutdown()
