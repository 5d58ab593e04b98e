"""Soak: the node at 1 kHz with random faults, for half an hour; memory, and every counter against what was injected.

Not part of the tests: `make soak`, or with SECONDS and RATE on the command line. Reliable transport, so that what was
sent is what came. Each second has a few faults of a random kind; the count of each is known from the rule of admission,
which this program applies by itself. Ends with status 1 where memory grew by more than 5 % after the first tenth, where
a counter is wrong, or a force was no number.
"""

import argparse
import os
import subprocess
import sys
import sysconfig
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np

EXECUTABLE = Path(sysconfig.get_path("scripts")) / "estimator_node"
NAMES = ["front_left", "front_right", "rear_left", "rear_right"]
TOPIC = "/suspension/displacement"
START = 1_700_000_000_000_000_000
MAX_GAP = 100_000_000
GROWTH = 0.05
WINDOW = 150  # messages that may be unanswered


class Expected:
    """What the node must count for one damper; the rule of admission in its own words; final."""

    def __init__(self) -> None:
        self.counts: Counter[str] = Counter()
        self._last: int | None = None

    def take(self, stamp: int, value: float) -> bool:
        """One sample; whether it is answered."""
        self.counts["samples"] += 1
        if not abs(value) < 1e6:
            self.counts["dropped: not finite"] += 1
            return False
        if self._last is not None:
            step = stamp - self._last
            if step == 0:
                self.counts["dropped: equal stamp"] += 1
                return False
            if -MAX_GAP <= step < 0:
                self.counts["dropped: older stamp"] += 1
                return False
            self.counts["resets: gap"] += step > MAX_GAP
            self.counts["resets: clock stepped back"] += step < -MAX_GAP
        self._last = stamp
        self.counts["estimates"] += 1
        return True


class Source:
    """Displacement with faults; final."""

    def __init__(self, rate: float, seed: int) -> None:
        self._random = np.random.default_rng(seed)
        self._step = round(1e9 / rate)
        self._stamp = START
        self._index = 0
        self.expected = {name: Expected() for name in NAMES}
        self.missing: Counter[str] = Counter()
        self.malformed = 0

    def next(self) -> tuple[bytes, bool]:
        """A serialised message, and whether it is answered."""
        from damper_estimator.recordings import joint_states

        self._index += 1
        self._stamp += self._step
        phase = self._index * self._step / 1e9
        values = 0.03 * np.sin(9.0 * phase + np.arange(4.0))
        names, stamp = list(NAMES), self._stamp
        fault = self._random.integers(12) if self._random.random() < 0.005 else -1
        if fault == 0:
            values[self._random.integers(4)] = self._random.choice([np.nan, np.inf, -np.inf, 1e300])
        elif fault == 1:
            stamp -= self._step
        elif fault == 2:
            stamp -= 20 * self._step
        elif fault == 3:
            self._stamp = stamp = stamp + int(self._random.integers(1, 4000)) * 1_000_000
        elif fault == 4:
            self._stamp = stamp = max(stamp - int(self._random.integers(200, 4000)) * 1_000_000, START)
        elif fault == 5:
            names = [names[i] for i in self._random.permutation(4)]
        elif fault == 6:
            names[int(self._random.integers(4))] = f"stranger_{self._random.integers(1000)}"
        elif fault == 7:
            names, values = [], values[:0]
        elif fault == 8:
            values[self._random.integers(4)] += 0.3
        elif fault == 9:
            values = values[:2]
        elif fault == 10:
            self.malformed += 1
            return b"\0\1\0\0" + self._random.bytes(7), False
        elif fault == 11:
            time.sleep(0.2)
        position = values[None] if values.size else None
        (message,) = joint_states(names, np.array([stamp]), position=position)
        return message, self._count(names, values, stamp)

    def _count(self, names: list[str], values: np.ndarray, stamp: int) -> bool:
        answered = False
        for name, expected in self.expected.items():
            place = names.index(name) if name in names else len(values)
            if place < len(values):
                answered |= expected.take(stamp, float(values[place]))
            else:
                self.missing[name] += 1
        return answered


def resident(pid: int) -> int:
    """Bytes of memory of a process."""
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def soak(seconds: float, rate: float, seed: int, folder: Path) -> list[str]:
    """Runs it; what was wrong."""
    import rclpy
    from damper_msgs.msg import DamperForces

    from damper_estimator.node.player import Player

    parameters = {
        "model": "carrera_akutain", "dampers": f"[{', '.join(NAMES)}]", "qos_reliability": "reliable",
        "qos_depth": 2000, "record": folder, "record_size": 20, "record_files": 3, "stale_after": 0.15,
    }  # fmt: skip
    words = [word for name, value in parameters.items() for word in ("-p", f"{name}:={value}")]
    process = subprocess.Popen([EXECUTABLE, "--ros-args", "--log-level", "warn", *words])
    rclpy.init()
    source, wrong, memory = Source(rate, seed), [], []
    player = Player(process=process)
    tally = Counter()

    def hear(message: DamperForces) -> None:
        tally["stale" if DamperForces.STALE in message.status else "answers"] += 1
        tally["not numbers"] += not np.isfinite(message.force).all()

    player.listen_instead(hear)
    player.connect({TOPIC: "sensor_msgs/msg/JointState"})
    begin, sent, told = time.monotonic(), 0, 0.0
    while (now := time.monotonic() - begin) < seconds and process.poll() is None:
        message, is_answered = source.next()
        player.publish(TOPIC, message)
        sent += is_answered
        while sent - tally["answers"] > WINDOW or time.monotonic() - begin < source._index / rate:
            player.spin(0.001)
            if time.monotonic() - begin > now + 30.0:
                break
        if now - told > seconds / 20.0:
            told = now
            memory.append(resident(process.pid))
            print(f"{now:6.0f} s: {sent} to answer, {tally['answers']} answered, {memory[-1] / 1e6:.1f} MB", flush=True)
    health = player.health
    seen = len(health)
    player.wait(lambda: len(health) > seen + 2, "the last report")
    wrong += _held_against(source, health[-1], tally, sent)
    early = max(2, len(memory) // 10)
    growth = max(memory[early:]) / max(memory[:early]) - 1.0 if len(memory) > early else 0.0
    print(
        f"memory grew by {100 * growth:.1f} %; {tally['stale']} stale messages; {sum(source.missing.values())} missing"
    )
    wrong += [f"memory grew by {100 * growth:.1f} %"] if growth > GROWTH else []
    wrong += [] if process.poll() is None else [f"the node ended with status {process.poll()}"]
    player.close()
    rclpy.shutdown()
    process.terminate()
    process.wait()
    return wrong


def _held_against(source: Source, health: object, tally: Counter, sent: int) -> list[str]:
    wrong = [] if tally["answers"] == sent else [f"{tally['answers']} answers, expected {sent}"]
    wrong += [f"{tally['not numbers']} messages held a force that is no number"] if tally["not numbers"] else []
    values = {s.name.split(": ", 1)[1]: {pair.key: pair.value for pair in s.values} for s in health.status}
    for name, expected in source.expected.items():
        for key, count in (expected.counts | {"not in the message": source.missing[name]}).items():
            if int(values[name][key]) != count:
                wrong.append(f"{name}: {key} is {values[name][key]}, expected {count}")
    malformed = int(values[f"input {TOPIC}"]["malformed"])
    return wrong + ([] if malformed == source.malformed else [f"malformed is {malformed}, expected {source.malformed}"])


def main() -> int:
    """The exit status is 1 where something was wrong."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("seconds", type=float, nargs="?", default=1800.0)
    parser.add_argument("rate", type=float, nargs="?", default=1000.0)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    from damper_estimator.node.domain import own_domain

    with own_domain(), tempfile.TemporaryDirectory() as folder:
        wrong = soak(arguments.seconds, arguments.rate, arguments.seed, Path(folder))
    print("\n".join(wrong) or "all counters right")
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
