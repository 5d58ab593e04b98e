"""The node against a relay that only republishes the same message: losses, round trip, CPU; from separate processes.

Node and relay run one after the other, in turns, each alone with the process that measures: it publishes JointState at
a fixed rate, best effort, and takes the time until the answer with the same stamp is back. The relay is the least that
a node in Python can do: it subscribes, and publishes what came, on the same executor. Printed are the medians of the
rounds, and the node's share of the relay. By default a look of about five minutes; ``--full`` is what the bars are for:
60 s a run, five rounds, 35 minutes on a quiet machine.
"""

import argparse
import os
import subprocess
import sys
import sysconfig
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

EXECUTABLE = Path(sysconfig.get_path("scripts")) / "estimator_node"
TOPIC = "/suspension/displacement"
WARM_UP = 1.0  # s at the same rate that are not judged
DRAIN = 0.5  # s after the last message in which answers are waited for
START = 120.0  # s
MODEL = "carrera_akutain"
CASES = ((4, 1000.0), (4, 2000.0), (8, 500.0))  # dampers, Hz
BARS = {"p50": 1.3, "p99": 1.5, "cpu": 1.6}


@dataclass(frozen=True)
class Run:
    """What one run gave: messages sent and answered, round trip in ms, CPU of the answering process in cores."""

    sent: int
    answered: int
    p50: float
    p99: float
    cpu: float


def relay() -> None:
    """The process that only republishes; the executor's name is the argument."""
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


def measured(kind: str, executor: str, dampers: int, rate: float, seconds: float) -> Run:
    """One run of the node or the relay."""
    import rclpy

    names = [f"damper_{i}" for i in range(dampers)]
    environment = os.environ | {"ROS_LOG_DIR": "/tmp"}
    if kind == "relay":
        words = [sys.executable, __file__, "relay", executor]
    else:
        parameters = {"model": MODEL, "dampers": f"[{', '.join(names)}]", "executor": executor, "stale_after": 60.0}
        words = [EXECUTABLE, "--ros-args", "-r", "__node:=damper_estimator", "--log-level", "warn"]
        words += [word for name, value in parameters.items() for word in ("-p", f"{name}:={value}")]
    process = subprocess.Popen(words, env=environment)
    rclpy.init()
    try:
        return _drive(process, kind, names, rate, seconds)
    finally:
        rclpy.shutdown()
        process.terminate()
        process.wait()


def _drive(process: subprocess.Popen, kind: str, names: list[str], rate: float, seconds: float) -> Run:
    import rclpy
    from damper_msgs.msg import DamperForces
    from rclpy.experimental.events_executor import EventsExecutor
    from rclpy.qos import QoSProfile, ReliabilityPolicy
    from sensor_msgs.msg import JointState

    from damper_estimator.recordings import joint_states

    node = rclpy.create_node("driver", start_parameter_services=False)
    quality = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
    publisher = node.create_publisher(JointState, TOPIC, quality)
    answers: list[tuple[bytes, float]] = []
    topic, answer = ("relayed", JointState) if kind == "relay" else ("/damper_estimator/force", DamperForces)
    take = lambda data: answers.append((data[4:12], time.perf_counter()))  # noqa: E731
    subscription = node.create_subscription(answer, topic, take, quality, raw=True)
    executor = EventsExecutor()
    executor.add_node(node)
    count = int(rate * (seconds + WARM_UP))
    stamps = 1_700_000_000 * 10**9 + (np.arange(count) * (1e9 / rate)).astype(np.int64)
    position = 0.03 * np.sin(np.arange(count)[:, None] / rate * 9.0 + np.arange(len(names)))
    messages = joint_states(names, stamps, position=position)
    end = time.monotonic() + START
    while publisher.get_subscription_count() < 1 or not _connected(node, topic):
        executor.spin_once(timeout_sec=0.05)
        if process.poll() is not None or time.monotonic() > end:
            raise SystemExit(f"{kind} did not come up")
    settle = time.monotonic() + 1.0
    while time.monotonic() < settle:
        executor.spin_once(timeout_sec=0.05)
    sent = np.zeros(count)
    start, cpu = time.perf_counter() + 0.01, 0.0
    for i, message in enumerate(messages):
        due = start + i / rate
        while (now := time.perf_counter()) < due:
            executor.spin_once(timeout_sec=max(due - now, 0.0))
        if i == int(rate * WARM_UP):
            cpu, begin = _cpu(process.pid), now
        sent[i] = time.perf_counter()
        publisher.publish(message)
    used, took = _cpu(process.pid) - cpu, time.perf_counter() - begin
    until = time.perf_counter() + DRAIN
    while time.perf_counter() < until:
        executor.spin_once(timeout_sec=0.02)
    node.destroy_subscription(subscription)
    back = dict(answers)
    first = int(rate * WARM_UP)
    trips = [1e3 * (back[m[4:12]] - t) for m, t in zip(messages[first:], sent[first:], strict=True) if m[4:12] in back]
    node.destroy_node()
    return Run(count - first, len(trips), *np.percentile(trips, [50, 99]).tolist(), used / took)


def _connected(node: object, topic: str) -> bool:
    return node.count_publishers(topic) > 0


def _cpu(pid: int) -> float:
    """CPU time of a process so far, s."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def compare(executor: str, dampers: int, rate: float, seconds: float, rounds: int) -> None:
    """Runs both in turns and prints medians and shares."""
    runs: dict[str, list[Run]] = {"relay": [], "node": []}
    for _ in range(rounds):
        for kind, done in runs.items():
            done.append(measured(kind, executor, dampers, rate, seconds))
    middle = {
        kind: {name: float(np.median([getattr(run, name) for run in done])) for name in BARS}
        for kind, done in runs.items()
    }
    lost = {kind: int(np.median([run.sent - run.answered for run in done])) for kind, done in runs.items()}
    print(f"{dampers} dampers at {rate:g} Hz, {executor}, {seconds:g} s, {rounds} rounds:", flush=True)
    for kind, own in middle.items():
        print(
            f"  {kind:5s} lost {lost[kind]:5d} of {runs[kind][0].sent}   round trip p50 {own['p50']:.3f} ms, "
            f"p99 {own['p99']:.3f} ms   CPU {100 * own['cpu']:.1f} % of a core"
        )
    shares = {name: middle["node"][name] / middle["relay"][name] for name in BARS}
    told = ", ".join(
        f"{name} {shares[name]:.2f} x (bar {bar:g}{'' if shares[name] <= bar else ', MISSED'})"
        for name, bar in BARS.items()
    )
    print(f"  node / relay: {told}; lost {'no more' if lost['node'] <= lost['relay'] else 'MORE'}", flush=True)


def main() -> None:
    """Every case that has a bar, and 2 kHz."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--full", action="store_true", help="60 s a run, five rounds")
    parser.add_argument("--seconds", type=float, help="of one run (default: 8, with --full 60)")
    parser.add_argument("--rounds", type=int, help="of node and relay in turns (default: 3, with --full 5)")
    parser.add_argument("--executor", default="events", choices=("events", "single"))
    arguments = parser.parse_args()
    seconds, rounds = (60.0, 5) if arguments.full else (8.0, 3)
    from damper_estimator.node.domain import own_domain

    with own_domain():
        for dampers, rate in CASES:
            compare(arguments.executor, dampers, rate, arguments.seconds or seconds, arguments.rounds or rounds)


if __name__ == "__main__":
    relay() if sys.argv[1:2] == ["relay"] else main()
