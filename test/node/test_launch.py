"""The launch files start what they say: their own code, resolved by a stand-in for ``launch``, and real processes.

No wheel of ``launch`` exists; with ROS sourced the same files are run by ``ros2 launch``.
"""

import subprocess
from pathlib import Path

import numpy as np
import pytest
import yaml
from launch_stand_in import commands
from rig import Rig

from damper_estimator.recordings import accelerations, floats

ROOT = Path(__file__).resolve().parents[2]
LAUNCH = ROOT / "launch"


@pytest.fixture
def launch(monkeypatch):
    """Starts what a launch file says; the processes end with the test."""
    running = []

    def run(name: str, **arguments: str) -> list[subprocess.Popen]:
        started = [subprocess.Popen(words) for words in commands(LAUNCH / name, ROOT, arguments, monkeypatch)]
        running.extend(started)
        return started

    yield run
    for process in running:
        process.terminate()
    for process in running:
        assert process.wait(60.0) == 0


@pytest.fixture
def car(domain):
    """Drives an estimator of the namespace ``/car_7``."""
    import rclpy

    rclpy.init()
    rig = Rig("/car_7/damper_estimator")
    yield rig
    rig.close()
    rclpy.shutdown()


def drive(car: Rig, topic: str, condition, what: str) -> None:
    """Sends displacements until a condition holds."""
    from rig import MS, joint_state

    publisher = car.publisher(topic)
    for i in range(100_000):
        publisher.publish(joint_state([0.01 * np.sin(0.02 * i)], ["left"], car.stamp + i * MS))
        car.listen(0.002)
        if condition():
            return
    raise AssertionError(f"{what} did not come")


def test_an_argument_that_is_not_declared_is_refused(monkeypatch):
    with pytest.raises(KeyError, match="modle"):
        commands(LAUNCH / "estimator.launch.py", ROOT, {"modle": "coulomb"}, monkeypatch)


def test_the_estimator_is_launched_with_its_arguments(launch, car):
    launch(
        "estimator.launch.py", model="linear_viscous", namespace="car_7", displacement="stroke", log_level="warn"
    )  # fmt: skip
    drive(car, "/car_7/stroke", lambda: len(car.forces) > 3, "forces")
    assert car.get("model") == "linear_viscous" and car.get("max_gap") == 0.1


@pytest.mark.parametrize("by_table", [False, True])
def test_estimator_and_controller_are_launched_together_and_command_currents(by_table, launch, car, tmp_path):
    from std_msgs.msg import Float64

    from damper_estimator.model import load_model
    from damper_estimator.model.export import force_table, write_tables

    signals = {"dampers": {"left": {"command": {"limits": [0.0, 2.0], "topic": "suspension/left/current"}}}}
    (tmp_path / "map.yaml").write_text(yaml.safe_dump(signals))
    given = {"model": "semi_active_on_mount", "signals": str(tmp_path / "map.yaml"), "law": "skyhook"}
    if by_table:
        model = load_model(given["model"])
        forces = force_table(model, np.array([-0.5, -0.1, 0.1, 0.5]), commands=(0.0, 2.0))
        given["table"] = str(write_tables(model, forces, tmp_path / "tables")[0])
    assert len(launch("semi_active.launch.py", namespace="car_7", damping="2000.0", **given)) == 2
    currents = []
    car.node.create_subscription(Float64, "/car_7/suspension/left/current_command", currents.append, 100)
    felt = car.publisher_unmatched("/car_7/suspension/left/body_acceleration", "geometry_msgs/msg/AccelStamped")
    current = car.publisher("/car_7/suspension/left/current", "std_msgs/msg/Float64")

    def is_controlled() -> bool:
        felt.publish(accelerations(np.array([car.stamp]), np.array([3.0 * np.sin(0.01 * len(car.forces))]))[0])
        current.publish(floats(np.array([0.5]))[0])
        return len({message.data for message in currents}) > 5

    drive(car, "/car_7/suspension/displacement", is_controlled, "currents")
    assert all(0.0 <= message.data <= 2.0 for message in currents)
