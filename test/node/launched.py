"""Fixtures of the tests of the launch files: a launch per test, and the car whose topics its nodes use."""

import os
import signal
import subprocess
import sys
import sysconfig
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from rig import MS, Rig, joint_state

ROOT = Path(__file__).resolve().parents[2]
RUNNER = Path(__file__).with_name("launch_runner.py")
ENDED_WITHIN = 300.0  # s, far more than a launch needs on a busy machine
CONFIGURE, ACTIVATE = 1, 3


@pytest.fixture(scope="module")
def package(tmp_path_factory) -> Path:
    """The checkout as an installed package: a prefix in which launch finds its executables and files."""
    try:
        import launch.actions  # noqa: F401  (the checkout has a folder of this name)
        import launch_ros.actions  # noqa: F401
    except ModuleNotFoundError as error:
        pytest.skip(f"launch is not here ({error}): no ROS is sourced, and tools/environment found no sources of it")
    prefix = tmp_path_factory.mktemp("prefix")
    for folder in ("share/ament_index/resource_index/packages", "share/damper_estimator", "lib/damper_estimator"):
        (prefix / folder).mkdir(parents=True)
    (prefix / "share/ament_index/resource_index/packages/damper_estimator").touch()
    for name in ("launch", "config", "package.xml"):
        (prefix / "share/damper_estimator" / name).symlink_to(ROOT / name)
    for name in ("estimator_node", "controller_node"):
        (prefix / "lib/damper_estimator" / name).symlink_to(Path(sysconfig.get_path("scripts")) / name)
    return prefix


@pytest.fixture
def launch(package, tmp_path) -> Iterator[Callable[..., subprocess.Popen]]:
    """Launches a file of the project, or one with the given text; remaining processes end with the test by SIGINT."""
    running = []
    environment = os.environ | {
        "AMENT_PREFIX_PATH": os.pathsep.join([str(package), os.environ.get("AMENT_PREFIX_PATH", sys.prefix)])
    }

    def run(file: str, text: str = "", **arguments: object) -> subprocess.Popen:
        path = package / "share/damper_estimator/launch" / file
        if text:
            path = tmp_path / file
            path.write_text(PARENT + text)
        words = [f"{name}:={value}" for name, value in arguments.items()]
        running.append(
            subprocess.Popen(
                [sys.executable, RUNNER, path, *words], env=environment, text=True, start_new_session=True,
                stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            )
        )  # fmt: skip
        return running[-1]

    yield run
    for process in running:
        if process.poll() is None:
            _interrupt(process)
        assert not group_of(process), "the launch has left processes behind"


def _interrupt(process: subprocess.Popen) -> None:
    """Ends a launch by SIGINT. Launch itself can hang (seen once, on a busy machine); its nodes must have ended."""
    process.send_signal(signal.SIGINT)
    try:
        process.communicate(timeout=ENDED_WITHIN)
    except subprocess.TimeoutExpired:
        left = group_of(process)
        os.killpg(process.pid, signal.SIGKILL)
        said = process.communicate()[0]
        assert not left, f"SIGINT did not end the processes {left} of the launch; it said {said[-3000:]}"
        warnings.warn(f"launch did not end although its nodes had; it said {said[-3000:]}", stacklevel=1)


# First lines of launch files that include ours.
PARENT = """
from pathlib import Path
import launch.actions, launch.events
from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, EmitEvent, GroupAction, IncludeLaunchDescription, RegisterEventHandler
from launch_ros.actions import LifecycleNode, PushRosNamespace, SetParameter, SetRemap
from launch_ros.event_handlers import OnStateTransition
from launch_ros.events import matches_node_name
from launch_ros.events.lifecycle import ChangeState, StateTransition

def ours(file, **arguments):
    path = Path(get_package_share_directory("damper_estimator")) / "launch" / file
    return IncludeLaunchDescription(str(path), launch_arguments=list(arguments.items()))
"""


def group_of(process: subprocess.Popen) -> list[int]:
    """The running processes of a launch."""
    listed = subprocess.run(["ps", "-o", "pid=,stat=", "-g", str(process.pid)], capture_output=True, text=True).stdout
    rows = [line.split() for line in listed.splitlines()]
    return [int(pid) for pid, state in rows if int(pid) != process.pid and not state.startswith("Z")]


def process_of(executable: str, process: subprocess.Popen) -> int | None:
    """The node of a launch; None if it is not there."""
    for pid in group_of(process):
        try:
            if executable in Path(f"/proc/{pid}/cmdline").read_text():
                return pid
        except OSError:
            continue
    return None


def killed_and_started_again(executable: str, process: subprocess.Popen, car: Rig) -> None:
    """Kills a node of a launch and waits until it runs again."""
    car.wait(lambda: process_of(executable, process) is not None, executable)
    first = process_of(executable, process)
    os.kill(first, signal.SIGKILL)
    car.wait(lambda: process_of(executable, process) not in (None, first), f"{executable} again")
    car.forces.clear()


def refused(process: subprocess.Popen) -> str:
    """The one line with which launch refuses; nothing was started."""
    said = process.communicate(timeout=ENDED_WITHIN)[0]
    assert process.returncode == 1 and "process started" not in said, said
    (line,) = [line for line in said.splitlines() if "[ERROR]" in line]
    return line


@pytest.fixture
def car(domain) -> Iterator[Rig]:
    """Drives an estimator of the namespace ``/car_7``."""
    import rclpy

    rclpy.init()
    rig = Rig("/car_7/damper_estimator")
    yield rig
    rig.close()
    rclpy.shutdown()


def drive(car: Rig, topic: str) -> None:
    """Sends displacements until forces come."""
    publisher = car.publisher(topic)
    for i in range(100_000):
        publisher.publish(joint_state([0.01 * np.sin(0.02 * i)], ["left"], car.stamp + i * MS))
        car.listen(0.002)
        if len(car.forces) > 3:
            return
    raise AssertionError("no forces came")
