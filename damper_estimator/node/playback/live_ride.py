"""A simulated quarter car in the loop over DDS, in simulated time: the live ride equals the one offline.

    python -m damper_estimator.node.playback.live_ride -m semi_active_on_mount --surface bump

Plant, road and sensors run here; estimator and controller are separate processes. Every sample of the sensors is
published with its time on ``/clock``, and the plant waits for the current that answers it, so a ride does not depend on
the speed of the machine.
"""

import argparse
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import rclpy
import yaml
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from damper_estimator.control import (
    LEAD,
    Action,
    CornerController,
    InverseCommand,
    InverseModel,
    TableCommand,
    load_table,
    mixed,
)
from damper_estimator.errors import InputError
from damper_estimator.model import load_model
from damper_estimator.node.inputs import message_type
from damper_estimator.node.playback.domain import free_ros_domain
from damper_estimator.node.playback.rehearsal import EXECUTABLE
from damper_estimator.node.wire import NANOSECONDS, float_message
from damper_estimator.recordings import accelerations, joint_states
from damper_estimator.runtime import DamperEstimator, deployed
from damper_estimator.signals import DEFAULT_MAX_GAP, load_signal_map
from damper_estimator.vehicle import (
    CORNER_CASES,
    LIMITS,
    REST,
    SURFACES,
    Corner,
    Ride,
    RunningRide,
    attainable,
    desired_force,
    ride,
    ride_measures,
    surface_height,
)

DAMPER = "corner"
START = 1_000 * NANOSECONDS  # of the simulated time
STEP = 2_000_000  # ns between the samples before the ride, at rest
PAUSE = NANOSECONDS  # ns before the ride, longer than a gap
STARTING = 300.0  # s of real time until the first current; the model may have to be compiled first
FIRST_PAUSE, QUIET = 0.1, 1.0  # s between the first samples, and after them
PATIENCE = 60.0  # s until each of the others
DEPTH = 100
TOPICS = {
    "displacement": ("suspension/displacement", "sensor_msgs/msg/JointState"),
    "current": (f"suspension/{DAMPER}/current", "std_msgs/msg/Float64"),
    "acceleration": (f"suspension/{DAMPER}/body_acceleration", "geometry_msgs/msg/AccelStamped"),
    "clock": ("/clock", "rosgraph_msgs/msg/Clock"),
}


@dataclass(frozen=True)
class Scenario:
    """Car, road and control: by the inverse of ``model``, or by ``table`` if that is given."""

    corner: Corner
    road: np.ndarray
    model: str
    table: Path | None = None

    @property
    def law(self) -> dict[str, object]:
        """The corner's law as parameters of the controller node."""
        law = self.corner.law
        total = law.body + law.wheel
        rest = RunningRide(self.corner.car, self.corner.damper, np.zeros(2)).rest_force
        return {"law": "mixed", "damping": total, "share": law.body / total, "rest_force": rest, "lead": LEAD}


class PlantLoop:
    """The plant's side of the loop; final. rclpy must be initialised."""

    def __init__(self) -> None:
        self._node = Node("live_ride", start_parameter_services=False)
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self._node)
        quality = QoSProfile(depth=DEPTH)
        self._publishers = {
            role: self._node.create_publisher(message_type(kind), topic, quality)
            for role, (topic, kind) in TOPICS.items()
        }
        self._currents = self._answers = 0
        self._current = 0.0
        self._desired, self._desired_at = float("nan"), 0
        self._node.create_subscription(Float64, f"suspension/{DAMPER}/current_command", self._take_current, quality)
        for topic in ("damper_estimator/desired_force", "damper_controller/desired_force"):
            self._node.create_subscription(JointState, topic, self._take_desired, quality)

    def _take_current(self, message: Float64) -> None:
        self._current = message.data
        self._answers += 1

    def _take_desired(self, message: JointState) -> None:
        self._desired = message.effort[0]
        self._desired_at = message.header.stamp.sec * NANOSECONDS + message.header.stamp.nanosec

    def drive(self, scenario: Scenario, processes: Sequence[subprocess.Popen]) -> Ride:
        """Drives once estimator and controller answer.

        Raises:
            InputError: if no current comes, or a process has ended.
        """
        running = RunningRide(scenario.corner.car, scenario.corner.damper, scenario.road)
        stamp = self._stand(processes)
        while (sensed := running.sense()) is not None:
            self._send(stamp + sensed.stamp, sensed.travel, sensed.felt, sensed.current)
            running.act(self._answer(processes))
        return running.ride()

    def _stand(self, processes: Sequence[subprocess.Popen]) -> int:
        """Stands at rest until samples are answered; returns the stamp of the ride's first one."""
        stamp, end = START, time.monotonic() + STARTING
        while not self._answers or self._desired_at < stamp - STEP:
            self._check(processes, end)
            self._send(stamp, 0.0, 0.0, 0.0)
            self._spin(FIRST_PAUSE)
            stamp += STEP
        self._spin(QUIET)  # for the remaining answers
        return stamp + PAUSE  # resets filter, model and law, as offline

    def _spin(self, seconds: float) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self._executor.spin_once(timeout_sec=0.02)

    def _send(self, stamp: int, travel: float, felt: float, current: float) -> None:
        """Publishes one sample of all sensors; the displacement, which is answered, last."""
        at = np.array([stamp])
        clock = Clock()
        clock.clock.sec, clock.clock.nanosec = divmod(stamp, NANOSECONDS)
        self._awaited = self._answers + 1, stamp
        self._publishers["clock"].publish(clock)
        self._publishers["acceleration"].publish(accelerations(at, np.array([felt]))[0])
        self._publishers["current"].publish(float_message(current))
        self._publishers["displacement"].publish(joint_states([DAMPER], at, position=np.array([[travel]]))[0])

    def _answer(self, processes: Sequence[subprocess.Popen]) -> Action:
        end = time.monotonic() + PATIENCE
        count, stamp = self._awaited
        while self._answers < count or self._desired_at < stamp:
            self._check(processes, end)
            self._executor.spin_once(timeout_sec=0.05)
        return Action(self._desired, self._current)

    def _check(self, processes: Sequence[subprocess.Popen], end: float) -> None:
        ended = [process.args[0] for process in processes if process.poll() is not None]
        if ended:
            raise InputError(f"{ended[0]} has ended; see its message")
        if time.monotonic() > end:
            raise InputError("no current came in time; are estimator and controller in the same ROS domain?")

    def close(self) -> None:
        """Destroys the ROS node."""
        self._executor.shutdown()
        self._node.destroy_node()


def live(scenario: Scenario) -> Ride:
    """The ride with a new estimator and controller, in this process's ROS domain.

    Raises:
        InputError: as `PlantLoop.drive`.
    """
    rclpy.init()
    plant = PlantLoop()
    try:
        with tempfile.TemporaryDirectory() as folder, _processes(scenario, Path(folder)) as processes:
            return plant.drive(scenario, processes)
    finally:
        plant.close()
        rclpy.shutdown()


@contextmanager
def _processes(scenario: Scenario, folder: Path) -> Iterator[list[subprocess.Popen]]:
    signals = folder / "signals.yaml"
    signals.write_text(yaml.safe_dump(_signal_map()))
    estimator = {"model": scenario.model, "signals": signals, "stale_after": 10.0, "use_sim_time": "true"}
    estimator["qos_reliability"] = "reliable"  # the plant would wait for a lost sample
    controller = scenario.law | {"use_sim_time": "true", "extrapolating_limit": 1e5}  # offline nothing limits it
    controller |= {"table": scenario.table} if scenario.table else {}
    words = {EXECUTABLE: estimator, EXECUTABLE.with_name("controller_node"): controller}
    running = [
        subprocess.Popen([str(program), "--ros-args", *(w for n, v in parameters.items() for w in ("-p", f"{n}:={v}"))])
        for program, parameters in words.items()
    ]
    try:
        yield running
    finally:
        for process in running:
            process.terminate()
        for process in running:
            process.wait()


def _signal_map() -> dict[str, object]:
    return {"dampers": {DAMPER: {"command": {"topic": TOPICS["current"][0], "limits": list(LIMITS)}}}}


def offline(scenario: Scenario) -> Ride:
    """The same ride without ROS.

    Raises:
        InputError: if the model has no inverse, or the table is invalid.
    """
    model = load_model(scenario.model)
    command = (
        TableCommand(load_table(scenario.table), LEAD)
        if scenario.table
        else InverseCommand(InverseModel(model, LIMITS, lead=LEAD))
    )
    law = scenario.law
    controller = CornerController(mixed(law["damping"], law["share"]), command, law["rest_force"], lead=LEAD)
    estimator = DamperEstimator(deployed(model, load_signal_map(None).cutoff, DEFAULT_MAX_GAP))
    return ride(scenario.corner.car, scenario.corner.damper, scenario.road, controller, estimator)


def main() -> int:
    """Drives live and offline, and prints how well both tracked the desired force."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("-m", "--model", required=True, help="model with a command")
    parser.add_argument("--table", type=Path, help="force_velocity.csv: currents by table instead of by the inverse")
    parser.add_argument("--corner", choices=CORNER_CASES, default="semi_active")
    parser.add_argument("--surface", choices=[surface.kind for surface in SURFACES], default="bump")
    parser.add_argument("--seconds", type=float, default=6.0)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    (surface,) = [surface for surface in SURFACES if surface.kind == arguments.surface]
    road = surface_height(surface, arguments.seconds, arguments.seed)
    corner = CORNER_CASES[arguments.corner]
    scenario = Scenario(corner, road, arguments.model, arguments.table)
    try:
        with free_ros_domain():
            rides = {"live": live(scenario), "offline": offline(scenario)}
    except InputError as error:
        print(f"live_ride: {error}", file=sys.stderr)
        return 1
    for name, driven in rides.items():
        limits = attainable(corner.damper, driven.travel, LIMITS, driven.step)
        desired = desired_force(driven, corner.law, scenario.law["rest_force"])
        measures = ride_measures(driven, desired, limits, REST)
        print(
            f"{arguments.corner}, {surface.name}, {name}: force error {measures.tracking_n:.1f} N rms of "
            f"{measures.wanted_n:.0f} N desired; body {measures.weighted_acceleration:.3f} m/s^2 (Wk), tyre load "
            f"{100 * measures.tyre_load:.1f} %, stroke {1e3 * measures.stroke:.1f} mm rms"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
