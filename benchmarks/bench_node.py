"""The node against a relay that only republishes the same message: losses, round trip, CPU; from separate processes.

Node and relay run in turns, each alone with the process that measures: it publishes JointState at a fixed rate, best
effort, and measures the time until the answer with the same stamp returns. The relay is the minimum of a node in
Python: it subscribes and republishes on the same executor. Each run of the node is divided by the adjacent run of the
relay; the medians of these ratios are printed, which other load on the machine disturbs least. Besides plain estimation
(with limits) the node is measured while it inverts a model, while its parameters change, and while it raises an alarm:
the relay's run receives the same additional messages, but ignores them.

The default takes some minutes; ``--full`` takes 25 minutes: 60 s a run and five pairs for cases with limits, 20 s and
three pairs for others. The rows of the table of docs/real_time.md are printed at the end. On a machine with other load,
start with ``chrt -f 5`` or ``nice -n -15``. The node's memory is excluded from garbage collection (`node.process`), and
the collector of the measuring process is off.
"""

import argparse
import gc
import os
import subprocess
import sys
import sysconfig
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from bench_node_cases import CASES, Case

EXECUTABLE = Path(sysconfig.get_path("scripts")) / "estimator_node"
TOPIC = "/suspension/displacement"
WARM_UP = 1.0  # s at the same rate that do not count
DRAIN = 0.5  # s to wait for answers after the last message
START = 120.0  # s
PERCENTILES = {"p50": 50.0, "p99": 99.0, "p99.9": 99.9, "max": 100.0}
BARS = {"p50": 1.15, "p99": 1.2, "cpu": 1.3}
FULL_WITH_BARS, FULL, LOOK = (60.0, 5), (20.0, 3), (8.0, 3)  # s of a run, and pairs of runs
HEAD = """| dampers, rate | round trip, median | 99 % | 99.9 % | longest | processor |
| --- | --- | --- | --- | --- | --- |"""


@dataclass(frozen=True)
class Run:
    """The result of one run: messages sent and answered, round trips in ms by ``PERCENTILES``, CPU of the answering
    process in cores as ``cpu``."""

    sent: int
    answered: int
    values: dict[str, float]


def relay() -> None:
    """The relay process; the executor's name is the argument."""
    import rclpy
    from rclpy.executors import ExternalShutdownException
    from rclpy.qos import QoSProfile, ReliabilityPolicy
    from sensor_msgs.msg import JointState

    from damper_estimator.node.executors import make_executor

    rclpy.init()
    node = rclpy.create_node("relay")
    publisher = node.create_publisher(JointState, "relayed", 100)
    quality = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
    node.create_subscription(JointState, TOPIC, publisher.publish, quality)
    executor = make_executor(sys.argv[2], node.get_logger())
    executor.add_node(node)
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        while rclpy.ok():
            executor.spin_once(timeout_sec=0.1)


def measured(kind: str, executor: str, case: Case, seconds: float, folder: Path) -> Run:
    """One run of the node or the relay."""
    import rclpy

    environment = os.environ | {"ROS_LOG_DIR": "/tmp"}
    if kind == "relay":
        words = [sys.executable, __file__, "relay", executor]
    else:
        parameters = {"dampers": f"[{', '.join(case.names)}]", "executor": executor, "stale_after": 60.0}
        parameters |= case.parameters(folder)
        words = [EXECUTABLE, "--ros-args", "-r", "__node:=damper_estimator", "--log-level", "error"]
        words += [word for name, value in parameters.items() for word in ("-p", f"{name}:={value}")]
    process = subprocess.Popen(words, env=environment)
    rclpy.init()
    try:
        return _drive(process, kind, case, seconds)
    finally:
        rclpy.shutdown()
        process.terminate()
        process.wait()


def _drive(process: subprocess.Popen, kind: str, case: Case, seconds: float) -> Run:
    import rclpy
    from damper_msgs.msg import DamperForces
    from rclpy.experimental.events_executor import EventsExecutor
    from rclpy.qos import QoSProfile, ReliabilityPolicy
    from sensor_msgs.msg import JointState

    from damper_estimator.recordings import joint_states

    node = rclpy.create_node("driver", start_parameter_services=False)
    quality = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
    publisher = node.create_publisher(JointState, TOPIC, quality)
    before_message = case.before_message(node, kind == "node")
    answers: list[tuple[bytes, float]] = []
    topic, answer = ("relayed", JointState) if kind == "relay" else ("/damper_estimator/force", DamperForces)
    take = lambda data: answers.append((data[4:12], time.perf_counter()))  # noqa: E731
    subscription = node.create_subscription(answer, topic, take, quality, raw=True)
    executor = EventsExecutor()
    executor.add_node(node)
    rate, count = case.rate, int(case.rate * (seconds + WARM_UP))
    stamps = time.time_ns() + (np.arange(count) * (1e9 / rate)).astype(np.int64)
    position = 0.01 * np.sin(np.arange(count)[:, None] / rate * 9.0 + np.arange(len(case.names)))
    messages = joint_states(list(case.names), stamps, position=position)
    _await(executor, process, lambda: publisher.get_subscription_count() and node.count_publishers(topic) > 0)
    gc.collect()
    gc.disable()
    sent, cpu = _send(executor, process, publisher.publish, messages, rate, before_message)
    gc.enable()
    node.destroy_subscription(subscription)
    back, first = dict(answers), int(rate * WARM_UP)
    trips = [1e3 * (back[m[4:12]] - t) for m, t in zip(messages[first:], sent[first:], strict=True) if m[4:12] in back]
    node.destroy_node()
    values = dict(zip(PERCENTILES, np.percentile(trips, list(PERCENTILES.values())).tolist(), strict=True))
    return Run(count - first, len(trips), values | {"cpu": cpu})


def _await(executor: object, process: subprocess.Popen, is_there: Callable[[], object]) -> None:
    """Waits for the other side, and one more second."""
    end = time.monotonic() + START
    while not is_there():
        executor.spin_once(timeout_sec=0.05)
        if process.poll() is not None or time.monotonic() > end:
            raise SystemExit("the process did not start")
    settle = time.monotonic() + 1.0
    while time.monotonic() < settle:
        executor.spin_once(timeout_sec=0.05)


def _send(
    executor: object, process: subprocess.Popen, publish: Callable, messages: list[bytes], rate: float,
    before_message: Callable[[int], None],
) -> tuple[np.ndarray, float]:  # fmt: skip
    """Sends at the rate; returns the times of sending (n,) in s, and the CPU of the process in cores."""
    sent, start, cpu, begin = np.zeros(len(messages)), time.perf_counter() + 0.01, 0.0, 0.0
    for i, message in enumerate(messages):
        due = start + i / rate
        while (now := time.perf_counter()) < due:
            executor.spin_once(timeout_sec=max(due - now, 0.0))
        if i == int(rate * WARM_UP):
            cpu, begin = _cpu(process.pid), now
        before_message(i)
        sent[i] = time.perf_counter()
        publish(message)
    used = (_cpu(process.pid) - cpu) / (time.perf_counter() - begin)
    until = time.perf_counter() + DRAIN
    while time.perf_counter() < until:
        executor.spin_once(timeout_sec=0.02)
    return sent, used


def _cpu(pid: int) -> float:
    """CPU time of a process so far, s."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def compare(executor: str, case: Case, seconds: float, pairs: int) -> str:
    """Runs both alternately, and prints medians and the medians of their ratios.

    Returns:
        The node's medians and these ratios as a row of a table.
    """
    runs: dict[str, list[Run]] = {"relay": [], "node": []}
    with tempfile.TemporaryDirectory() as folder:
        for pair in range(pairs):
            for kind in ("relay", "node") if pair % 2 else ("node", "relay"):
                runs[kind].append(measured(kind, executor, case, seconds, Path(folder)))
    print(f"{case.title}, {len(case.names)} dampers at {case.rate:g} Hz, {executor}, {seconds:g} s, {pairs} pairs:")
    names = (*PERCENTILES, "cpu")
    medians = {
        kind: {name: float(np.median([run.values[name] for run in done])) for name in names}
        for kind, done in runs.items()
    }
    for kind, done in runs.items():
        middle = medians[kind]
        lost = int(np.median([run.sent - run.answered for run in done]))
        trips = ", ".join(f"{name} {middle[name]:.3f}" for name in PERCENTILES)
        print(f"  {kind:5s} lost {lost:5d} of {done[0].sent}   round trip ms {trips}   CPU {100 * middle['cpu']:.1f} %")
    sentences, ratios = [], {}
    for name in names:
        pairs_of = zip(runs["node"], runs["relay"], strict=True)
        ratio = ratios[name] = float(np.median([node.values[name] / relay.values[name] for node, relay in pairs_of]))
        bar = BARS.get(name) if case.has_bars else None
        verdict = "" if bar is None else f" (bar {bar:g}{'' if ratio <= bar else ', MISSED'})"
        sentences.append(f"{name} {ratio:.2f} x{verdict}")
    print(f"  node / relay: {', '.join(sentences)}", flush=True)
    rate = f"{case.rate / 1e3:g} kHz" if case.rate >= 1e3 else f"{case.rate:g} Hz"
    title = "" if case.title == "estimation" else f"{case.title}, "
    middle_of_node = medians["node"]
    trips = [f"{middle_of_node[name]:.2f} ms, {ratios[name]:.2f} x" for name in PERCENTILES]
    cells = [f"{title}{len(case.names)}, {rate}", *trips, f"{100 * middle_of_node['cpu']:.0f} %, {ratios['cpu']:.2f} x"]
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Every case."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--full", action="store_true", help="longer runs, and five pairs for cases with limits")
    parser.add_argument("--seconds", type=float, help="of one run (default: 8; with --full 60 with limits, else 20)")
    parser.add_argument("--pairs", type=int, help="of node and relay (default: 3; with --full 5 with limits)")
    parser.add_argument("--executor", default="events", choices=("events", "single"))
    parser.add_argument("--only", metavar="TITLE", default="", help="only cases whose title begins with this")
    arguments = parser.parse_args()
    from damper_estimator.node.playback.domain import free_ros_domain

    rows = []
    with free_ros_domain():
        for case in (case for case in CASES if case.title.startswith(arguments.only)):
            seconds, pairs = (FULL_WITH_BARS if case.has_bars else FULL) if arguments.full else LOOK
            rows.append(compare(arguments.executor, case, arguments.seconds or seconds, arguments.pairs or pairs))
    print("", HEAD, *rows, sep="\n")


if __name__ == "__main__":
    relay() if sys.argv[1:2] == ["relay"] else main()
