"""The launch files under the real ``launch``, a process of its own per launch, with real nodes behind them."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import yaml
from conftest import EXECUTABLE
from rig import Rig
from semi_active import DAMPERS, SAFE, Car, by_table, semi_active_parameters

from damper_estimator.recordings import accelerations

ROOT = Path(__file__).resolve().parents[2]
RUNNER = Path(__file__).with_name("launch_runner.py")
ENDED_WITHIN = 120.0  # s
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
        (prefix / "lib/damper_estimator" / name).symlink_to(EXECUTABLE.with_name(name))
    return prefix


@pytest.fixture
def launch(package, tmp_path) -> Iterator[Callable[..., subprocess.Popen]]:
    """Launches a file of the project, or one with the given text; what is left ends with the test by SIGINT."""
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
            process.send_signal(signal.SIGINT)
            process.communicate(timeout=ENDED_WITHIN)
        assert not group_of(process), "the launch has left processes behind"


# The beginning of launch files that include ours.
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
    """The processes that a launch has started and that are still there."""
    listed = subprocess.run(["ps", "-o", "pid=,stat=", "-g", str(process.pid)], capture_output=True, text=True).stdout
    rows = [line.split() for line in listed.splitlines()]
    return [int(pid) for pid, state in rows if int(pid) != process.pid and not state.startswith("Z")]


def process_of(executable: str, process: subprocess.Popen) -> int | None:
    """The node of a launch; None where it is not there."""
    for pid in group_of(process):
        try:
            if executable in Path(f"/proc/{pid}/cmdline").read_text():
                return pid
        except OSError:
            continue
    return None


def killed_and_started_again(executable: str, process: subprocess.Popen, car: Rig) -> None:
    """Kills a node of a launch and waits until it is there again."""
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
    from rig import MS, joint_state

    publisher = car.publisher(topic)
    for i in range(100_000):
        publisher.publish(joint_state([0.01 * np.sin(0.02 * i)], ["left"], car.stamp + i * MS))
        car.listen(0.002)
        if len(car.forces) > 3:
            return
    raise AssertionError("no forces came")


def test_the_estimator_is_launched_with_its_arguments(launch, car):
    launch("estimator.launch.py", model="linear_viscous", namespace="car_7", displacement="stroke", log_level="warn",
           safe_current="1")  # fmt: skip
    drive(car, "/car_7/stroke")
    assert (car.get("model"), car.get("max_gap"), car.get("safe_current")) == ("linear_viscous", 0.1, 1.0)


def test_what_is_not_given_is_as_in_the_users_file_and_what_is_given_counts_more(launch, car, tmp_path):
    values = {"model": "coulomb", "autostart": False, "use_sim_time": True, "max_gap": 0.25, "stale_after": 0.5}
    (tmp_path / "mine.yaml").write_text(yaml.safe_dump({"/**": {"ros__parameters": values}}))
    launch("estimator.launch.py", params_file=tmp_path / "mine.yaml", namespace="car_7", use_sim_time="No")
    assert car.state() == "unconfigured"
    assert {name: car.get(name) for name in values} == values | {"use_sim_time": False}


@pytest.mark.parametrize("word, state", [("TRUE", "active"), ("yes", "active"), ("off", "unconfigured")])
def test_autostart_is_read_as_ros_reads_truth(word, state, launch, car):
    launch("estimator.launch.py", model="coulomb", namespace="car_7", autostart=word)
    car.wait(lambda: car.health and car.state() == state, f"the state {state}")


@pytest.mark.parametrize(
    "file, arguments, reason",
    [
        ("estimator.launch.py", {"modle": "coulomb"}, "there is no argument modle; model is meant?"),
        ("estimator.launch.py", {"model": "coulomb", "modell": "dahl"}, "there is no argument modell"),
        ("estimator.launch.py", {"model": "coulomb", "Use-Sim-Time": "true"}, "use_sim_time is meant?"),
        ("estimator.launch.py", {"model": "coulomb", "colour": "red"}, "there is no argument colour"),
        ("estimator.launch.py", {}, "no model is given"),
        ("estimator.launch.py", {"model": "coulomb", "autostart": "1"}, "autostart must be true or false"),
        ("estimator.launch.py", {"model": "coulomb", "params_file": "/missing.yaml"}, "there is no such file"),
        ("estimator.launch.py", {"model": "coulomb", "log_level": "loud"}, "log_level must be one of debug"),
        ("semi_active.launch.py", {"model": "coulomb", "damping": "soft"}, "damping must be between 0 and 100000"),
        ("semi_active.launch.py", {"model": "coulomb", "timeout": "nan"}, "timeout must be between"),
        ("semi_active.launch.py", {"model": "coulomb", "law": "sky"}, "law must be one of skyhook"),
        ("semi_active.launch.py", {"model": "coulomb", "autostart": "1"}, "autostart must be true or false"),
        ("semi_active.launch.py", {"model": "coulomb", "tabel": "x.csv"}, "table is meant?"),
        ("semi_active.launch.py", {"law": "skyhook"}, "no model is given"),
    ],
)
def test_what_cannot_be_used_is_refused_in_one_line_before_anything_starts(file, arguments, reason, launch):
    assert reason in refused(launch(file, **arguments))


def test_the_shipped_parameter_files_give_no_model(launch):
    for name in ("node.yaml", "controller.yaml"):
        assert "no model is given" in refused(launch("estimator.launch.py", params_file=ROOT / "config" / name))


def test_no_argument_is_a_slip_of_another():
    pytest.importorskip("launch_ros.actions")
    from damper_estimator.node.launch_arguments import CONTROLLER, ESTIMATOR, is_slip

    names = ESTIMATOR | CONTROLLER
    assert not [(a, b) for a in names for b in names if is_slip(a, b)]
    assert not is_slip("ros_namespace", "namespace") and not is_slip("car", "law")


def test_a_launch_file_that_includes_ours_may_have_arguments_of_its_own(launch, car):
    text = """
def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument("models"), DeclareLaunchArgument("colour", default_value="blue"),
        PushRosNamespace("car_7"), SetRemap("suspension/displacement", "stroke"),
        SetParameter("max_gap", 0.25), SetParameter("model", "dahl"),
        ours("estimator.launch.py", model=launch.substitutions.LaunchConfiguration("models")),
    ])
"""
    launch("car.launch.py", text, models="linear_viscous", colour="red")
    drive(car, "/car_7/stroke")
    assert (car.get("model"), car.get("max_gap")) == ("linear_viscous", 0.25)


def test_a_slip_in_a_launch_file_that_includes_ours_is_refused(launch):
    text = """
def generate_launch_description():
    return LaunchDescription([ours("estimator.launch.py", modle="coulomb")])
"""
    assert "model is meant?" in refused(launch("car.launch.py", text))


def test_lifecycle_events_of_a_launch_file_configure_and_activate(launch, car):
    text = """
def changed(transition):
    matcher = matches_node_name("/car_7/damper_estimator")
    return EmitEvent(event=ChangeState(lifecycle_node_matcher=matcher, transition_id=transition))

def generate_launch_description():
    configured = OnStateTransition(
        matcher=lambda event: isinstance(event, StateTransition)
        and (event.start_state, event.goal_state) == ("configuring", "inactive"),
        entities=[changed(3)])
    return LaunchDescription([
        RegisterEventHandler(configured),
        ours("estimator.launch.py", model="coulomb", namespace="car_7", autostart="false"), changed(1),
    ])
"""
    launch("car.launch.py", text)
    car.wait(lambda: car.health and car.state() == "active", "the active state")


def test_a_dead_estimator_does_not_end_the_launch_file_that_includes_it_and_is_started_again_where_asked(launch, car):
    text = """
def generate_launch_description():
    return LaunchDescription([
        launch.actions.ExecuteProcess(cmd=["sleep", "1000"]),
        ours("estimator.launch.py", model="coulomb", namespace="car_7", respawn="true"),
    ])
"""
    process = launch("car.launch.py", text)
    drive(car, "/car_7/suspension/displacement")
    killed_and_started_again("estimator_node", process, car)
    drive(car, "/car_7/suspension/displacement")
    assert process.poll() is None


@pytest.mark.parametrize("with_table", [False, True])
def test_estimator_and_controller_are_launched_together_and_command_currents(with_table, launch, car, tmp_path):
    own = semi_active_parameters(tmp_path)
    if with_table:
        own["table"] = by_table(tmp_path)
    content = {"/**": {"ros__parameters": {name: own.pop(name) for name in ("stale_after", "safe_current")}},
               "/**/damper_controller": {"ros__parameters": {"timeout": 5.0}}}  # fmt: skip
    (tmp_path / "mine.yaml").write_text(yaml.safe_dump(content))
    own = {name: own[name] for name in ("model", "signals", "table") if name in own} | {
        "law": "skyhook",
        "damping": 2000,
    }
    process = launch("semi_active.launch.py", params_file=tmp_path / "mine.yaml", namespace="car_7", **own)
    both = Car(car, DAMPERS, "/car_7")
    felt = [car.publisher_unmatched(both.topic(name, "body_acceleration"), "geometry_msgs/msg/AccelStamped")
            for name in DAMPERS]  # fmt: skip

    def is_controlled() -> bool:
        upwards = np.array([10.0 * np.sin(0.01 * len(car.forces))])
        for publisher in felt:
            publisher.publish(accelerations(np.array([car.stamp]), upwards)[0])
        return all(len(set(commands)) > 5 and commands[-1] != SAFE for commands in both.commands.values())

    both.drive_until(is_controlled, "currents", desired=None)
    assert all(0.0 <= command <= 2.0 for commands in both.commands.values() for command in commands)
    controller = Rig("/car_7/damper_controller")
    assert [controller.get(name) for name in ("timeout", "safe_current", "damping")] == [5.0, SAFE, 2000.0]
    controller.close()
    process.send_signal(signal.SIGINT)
    said = process.communicate(timeout=ENDED_WITHIN)[0]
    car.listen(0.3)
    assert both.last() == dict.fromkeys(DAMPERS, SAFE)
    assert process.returncode == 0 and said.count("finished cleanly") == 2 and "Caught exception" not in said, said


@pytest.mark.parametrize("executable", ["estimator_node", "controller_node"])
def test_the_end_of_either_node_ends_the_launch_of_both(executable, launch, car):
    process = launch("semi_active.launch.py", model="coulomb", namespace="car_7")
    drive(car, "/car_7/suspension/displacement")
    car.wait(lambda: process_of("controller_node", process) is not None, "the controller")
    os.kill(process_of(executable, process), signal.SIGKILL)
    said = process.communicate(timeout=ENDED_WITHIN)[0]
    assert "shutting down launched system" in said and "Caught exception" not in said
    assert group_of(process) == []


def test_both_nodes_are_started_again_where_asked(launch, car):
    process = launch("semi_active.launch.py", model="coulomb", namespace="car_7", respawn="true")
    for executable in ("estimator_node", "controller_node"):
        drive(car, "/car_7/suspension/displacement")
        killed_and_started_again(executable, process, car)
    assert process.poll() is None


def test_a_signal_while_both_nodes_start_leaves_nothing_behind(launch):
    process = launch("semi_active.launch.py", model="coulomb")
    time.sleep(2.0)  # the nodes are starting
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=ENDED_WITHIN)
    assert process.returncode == 0 and group_of(process) == []
