"""Subscribes to a running node for the studio: prints estimates and health as lines of JSON, keeps messages in memory.

    python -m damper_estimator.node.watch --minutes 5

Four times a second one line is written to standard output: ``dampers`` (by name ``force`` and ``residual``, each
``[times in s, values in N]`` of the new samples, thinned; ``status`` of the last estimate; ``level`` and ``message`` of
``/diagnostics``; ``alarm`` if the error against the gauge has grown) and ``held`` (``seconds`` and ``messages`` in
memory). A line ``{"save": PATH}`` on standard input writes the messages in memory as a recording; the answer is a line
with ``saved`` or ``failed``. It ends when standard input is closed.
"""

import argparse
import json
import os
import sys
import threading
import time
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message

from damper_estimator.node.inputs import message_type
from damper_estimator.recordings import LiveBagWriter

PERIOD = 0.25  # s between two lines
DISCOVER = 1.0  # s between two searches for topics
MOST_BYTES = 500_000_000  # in memory
BIN = 0.02  # s, of which the smallest and largest value are shown
STATUSES = ("good", "warming up", "extrapolating", "degraded", "stale")
FORCES, JOINTS, HEALTH = (
    "damper_msgs/msg/DamperForces", "sensor_msgs/msg/JointState", "diagnostic_msgs/msg/DiagnosticArray",
)  # fmt: skip
RECORDED = (
    FORCES, JOINTS, "std_msgs/msg/Float64", "sensor_msgs/msg/Temperature", "sensor_msgs/msg/FluidPressure",
    "geometry_msgs/msg/AccelStamped",
)  # fmt: skip
_GREW = "error grew from"  # in a drift alarm


@dataclass
class Damper:
    """What came of one damper since the last line."""

    force: list[tuple[float, float]] = field(default_factory=list)
    residual: list[tuple[float, float]] = field(default_factory=list)
    status: str = ""
    level: int = 0
    message: str = ""


class Watch:
    """Subscribes to all inputs and outputs of the node; final. rclpy must be initialised."""

    def __init__(self, seconds: float) -> None:
        """``seconds`` of the messages stay in memory."""
        self._seconds = seconds
        self._node = Node("damper_studio", start_parameter_services=False)
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self._node)
        self._kept: deque[tuple[str, str, int, bytes]] = deque()
        self._bytes = 0
        self._subscribed: set[str] = set()
        self._dampers: dict[str, Damper] = {}

    def discover(self) -> None:
        """Subscribes to topics that are new."""
        quality = QoSProfile(depth=2000, reliability=ReliabilityPolicy.BEST_EFFORT)
        for topic, kinds in self._node.get_topic_names_and_types():
            if topic in self._subscribed or not set(kinds) & {*RECORDED, HEALTH}:
                continue
            kind = next(name for name in kinds if name in (*RECORDED, HEALTH))
            self._subscribed.add(topic)

            def take(data: bytes, topic: str = topic, kind: str = kind) -> None:
                self._take(topic, kind, data)

            self._node.create_subscription(message_type(kind), topic, take, quality, raw=True)

    def listen(self, seconds: float) -> None:
        """Receives messages for a while."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=left)

    def line(self) -> dict[str, object]:
        """What came since the last line."""
        dampers = {
            name: {
                "force": thinned(damper.force), "residual": thinned(damper.residual), "status": damper.status,
                "level": damper.level, "message": damper.message, "alarm": _GREW in damper.message,
            }
            for name, damper in self._dampers.items()
        }  # fmt: skip
        for damper in self._dampers.values():
            damper.force, damper.residual = [], []
        seconds = (self._kept[-1][2] - self._kept[0][2]) * 1e-9 if self._kept else 0.0
        return {"dampers": dampers, "held": {"seconds": seconds, "messages": len(self._kept)}}

    def save(self, path: Path) -> dict[str, object]:
        """Writes the messages in memory, first to a file next to ``path``; returns the answer to the request."""
        partial = path.with_name(f".{path.name}.part")
        try:
            partial.unlink(missing_ok=True)
            writer = LiveBagWriter(partial)
            for message in list(self._kept):
                writer.write_raw(*message)
            writer.close()
            if path.exists():
                raise FileExistsError(17, "the file exists")
            os.replace(partial, path)
        except OSError as error:
            partial.unlink(missing_ok=True)
            return {"failed": f"{path.name}: cannot be written ({error.strerror})"}
        return {"saved": path.name, "messages": len(self._kept)}

    def close(self) -> None:
        """Destroys the subscriptions."""
        self._node.destroy_node()

    def _take(self, topic: str, kind: str, data: bytes) -> None:
        now = time.time_ns()
        if kind == HEALTH:
            self._take_health(deserialize_message(data, message_type(kind)))
            return
        self._kept.append((topic, kind, now, data))
        self._bytes += len(data)
        oldest = now - round(self._seconds * 1e9)
        while self._kept and (self._kept[0][2] < oldest or self._bytes > MOST_BYTES):
            self._bytes -= len(self._kept.popleft()[3])
        if kind == FORCES:
            self._take_forces(deserialize_message(data, message_type(kind)))
        elif kind == JOINTS and topic.endswith("/residual"):
            residuals = deserialize_message(data, message_type(kind))
            for name, value in zip(residuals.name, residuals.effort, strict=False):
                self._dampers.setdefault(name, Damper()).residual.append((_seconds(residuals), float(value)))

    def _take_forces(self, forces: object) -> None:
        for name, force, status in zip(forces.name, forces.force, forces.status, strict=False):
            damper = self._dampers.setdefault(name, Damper())
            damper.force.append((_seconds(forces), float(force)))
            damper.status = STATUSES[int(status)] if int(status) < len(STATUSES) else str(status)

    def _take_health(self, health: object) -> None:
        for status in health.status:
            damper = self._dampers.get(status.name.rpartition(": ")[2])
            if damper is not None:
                level = status.level[0] if isinstance(status.level, bytes) else int(status.level)
                damper.level, damper.message = level, status.message


def thinned(points: Sequence[tuple[float, float]]) -> list[list[float]]:
    """Times and values; of each 20 ms the smallest and the largest value, in order of time. NaN is dropped."""
    bins: dict[int, list[tuple[float, float]]] = {}
    for time_s, value in points:
        if value == value:
            bins.setdefault(int(time_s / BIN), []).append((time_s, value))
    kept = []
    for points_in_bin in bins.values():
        ends = {min(points_in_bin, key=lambda point: point[1]), max(points_in_bin, key=lambda point: point[1])}
        kept += sorted(ends)
    return [[point[0] for point in kept], [point[1] for point in kept]]


def _seconds(message: object) -> float:
    stamp = message.header.stamp
    return stamp.sec + 1e-9 * stamp.nanosec


def main() -> int:
    """Runs until standard input is closed."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--minutes", type=float, default=5.0, help="of messages that stay in memory (5)")
    arguments = parser.parse_args()
    requests: deque[str] = deque()
    ended = threading.Event()

    def read() -> None:
        for text in sys.stdin:
            requests.append(text)
        ended.set()

    threading.Thread(target=read, daemon=True).start()
    rclpy.init()
    watch = Watch(60.0 * arguments.minutes)
    discovered = 0.0
    try:
        while not ended.is_set():
            if time.monotonic() - discovered > DISCOVER:
                watch.discover()
                discovered = time.monotonic()
            watch.listen(PERIOD)
            while requests:
                print(json.dumps(watch.save(Path(json.loads(requests.popleft())["save"]))), flush=True)
            print(json.dumps(watch.line()), flush=True)
    except (BrokenPipeError, KeyboardInterrupt):
        pass
    finally:
        watch.close()
        rclpy.try_shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
