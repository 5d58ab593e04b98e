"""Duration of the first and the second command after an installation: each verb and the node with an empty cache.

Prints a table: compare, fit and diagnose from start to end, the node from its start to the first force on its topic.
Without ROS the node is skipped. Usage: python benchmarks/bench_cold_start.py
"""

import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path
from time import monotonic

NODE = Path(sysconfig.get_path("scripts")) / "estimator_node"
BAGS = Path(__file__).resolve().parents[1] / "bags"
COMMANDS = {
    "compare": "compare hidden_unseen.mcap -m mine.yaml",
    "fit": "fit hidden_base.mcap -m viscous_curve -o again.yaml",
    "diagnose": "diagnose hidden_fit.mcap --validate hidden_unseen.mcap -m mine.yaml",
}
RATE = 100.0  # Hz of the displacement messages to the node
LONGEST = 600.0  # s to the first force


def main() -> int:
    """Measures and prints."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        for bag in BAGS.glob("hidden_*.mcap"):
            shutil.copy(bag, place)
        seconds(place, "fit hidden_base.mcap -m viscous_curve -o mine.yaml", place / "other")
        print(f"{'':10} {'first':>8} {'second':>8} {'gap':>8}   s")
        for name, command in COMMANDS.items():
            cache = place / f"cache_{name}"
            first, second = (seconds(place, command, cache) for _ in range(2))
            print(line(name, first, second), flush=True)
        if NODE.exists():
            first, second = (first_force(place / "mine.yaml", place / "cache_node") for _ in range(2))
            print(line("node", first, second))
    return 0


def line(name: str, first: float, second: float) -> str:
    """A row of the table."""
    return f"{name:10} {first:8.1f} {second:8.1f} {first - second:8.1f}"


def seconds(place: Path, command: str, cache: Path) -> float:
    """Duration of a command in a folder, with the machine code in ``cache``."""
    begun = monotonic()
    subprocess.run(
        [sys.executable, "-m", "damper_estimator", *command.split()], cwd=place, check=True, capture_output=True,
        env={**os.environ, "NUMBA_CACHE_DIR": str(cache), "PYTHONPATH": str(BAGS.parent)},
    )  # fmt: skip
    return monotonic() - begun


def first_force(model: Path, cache: Path) -> float:
    """Time from the start of the node to its first force, while displacements are sent."""
    import rclpy
    from damper_msgs.msg import DamperForces
    from sensor_msgs.msg import JointState

    rclpy.init()
    node = rclpy.create_node("driver", start_parameter_services=False)
    publisher = node.create_publisher(JointState, "/suspension/displacement", 10)
    answers: list[object] = []
    node.create_subscription(DamperForces, "/damper_estimator/force", answers.append, 10)

    def send() -> None:
        message = JointState(name=["front"], position=[0.01])
        message.header.stamp = node.get_clock().now().to_msg()
        publisher.publish(message)

    node.create_timer(1.0 / RATE, send)
    words = [NODE, "--ros-args", "-r", "__node:=damper_estimator", "--log-level", "error"]
    begun = monotonic()
    process = subprocess.Popen(
        [*words, "-p", f"model:={model}", "-p", "dampers:=[front]"],
        env={**os.environ, "NUMBA_CACHE_DIR": str(cache), "ROS_LOG_DIR": str(cache)},
    )
    try:
        while not answers:
            rclpy.spin_once(node, timeout_sec=0.1)
            if process.poll() is not None or monotonic() - begun > LONGEST:
                raise SystemExit("the node published no force")
        return monotonic() - begun
    finally:
        rclpy.shutdown()
        process.terminate()
        process.wait()


if __name__ == "__main__":
    sys.exit(main())
