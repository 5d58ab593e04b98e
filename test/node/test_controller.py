"""The example controller: its desired forces, forces that others add, and when it is passive."""

import subprocess
import sys
import time

import numpy as np
import pytest
from conftest import EXECUTABLE, stop
from semi_active import by_table

CONTROLLER = EXECUTABLE.with_name("controller_node")
FORCE, FELT, ADDED = "/damper_estimator/force", "/suspension/left/body_acceleration", "/damper_controller/added_force"
GOOD, WARMING_UP, EXTRAPOLATING, DEGRADED, STALE = range(5)
OK, WARN = b"\x00", b"\x01"
NEITHER = float("nan"), float("inf")
REST = -300.0
SAFE = 0.25


@pytest.fixture
def start_controller(domain):
    """Starts controllers with parameters; they end with the test."""
    running = []

    def run(**parameters: object) -> subprocess.Popen:
        words = [word for name, value in parameters.items() for word in ("-p", f"{name}:={value}")]
        running.append(
            subprocess.Popen(
                [CONTROLLER, "--ros-args", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
            )
        )
        return running[-1]

    yield run
    for process in running:
        stop(process)


class Estimates:
    """A fake estimator; final."""

    def __init__(self, rig, topic: str = "/damper_estimator/desired_force") -> None:
        """``topic`` of the desired forces."""
        from damper_msgs.msg import DamperForces
        from geometry_msgs.msg import AccelStamped
        from sensor_msgs.msg import JointState
        from std_msgs.msg import Float64

        self.rig, self.method_options, self.commands, self.count = rig, [], [], 0
        self._types = DamperForces, AccelStamped, JointState
        rig.node.create_subscription(JointState, topic, self.method_options.append, 100)
        rig.node.create_subscription(
            Float64, "/suspension/left/current_command", lambda m: self.commands.append(m.data), 100
        )
        self._force = rig.publisher(FORCE, "damper_msgs/msg/DamperForces")
        rig.wait(lambda: rig.node.count_publishers(topic) > 0, "the controller")
        self._felt = rig.publisher_unmatched(FELT, "geometry_msgs/msg/AccelStamped")
        while not self._felt.get_subscription_count():  # it creates its topics with the first estimate
            self.publish_estimate(0.0)
            rig.listen(0.1)
        self._added = rig.publisher(ADDED, "sensor_msgs/msg/JointState")
        rig.listen(0.3)

    def publish_estimate(self, velocity: float, status: int = GOOD) -> None:
        """One estimate, 10 ms after the last one."""
        self.count += 1
        numbers = {name: [0.0] for name in ("displacement", "acceleration", "force")}
        message = self._types[0](name=["left"], velocity=[velocity], status=[status], **numbers)
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(10**12 + self.count * 10**7, 10**9)
        self._force.publish(message)

    def feel(self, vertical: float) -> None:
        message = self._types[1]()
        message.accel.linear.z = vertical
        self._felt.publish(message)

    def add(self, force: float) -> None:
        self._added.publish(self._types[2](name=["left"], effort=[force]))

    def answer(self, velocity: float, status: int = GOOD) -> float:
        """The desired force that answers an estimate."""
        before = len(self.method_options)
        self.publish_estimate(velocity, status)
        self.rig.wait(lambda: len(self.method_options) > before, "a desired force")
        return self.method_options[-1].effort[0]


def test_the_desired_force_is_that_of_the_law_plus_added_forces_and_none_without_acceleration(start_controller, rig):
    start_controller(law="groundhook", damping=1000.0, rest_force=REST, timeout=5.0)
    estimator = Estimates(rig)
    assert np.isnan(estimator.answer(0.2))  # no acceleration yet
    estimator.feel(0.0)
    rig.listen(0.2)
    assert estimator.answer(0.2) == pytest.approx(REST + 200.0)  # the wheel goes down at 0.2 m/s
    assert estimator.method_options[-1].name == ["left"]
    estimator.add(50.0)
    rig.listen(0.2)
    assert estimator.answer(0.1) == pytest.approx(REST + 50.0 + 100.0)
    assert np.isnan(estimator.answer(0.1, STALE))
    rig.listen(5.5)
    assert np.isnan(estimator.answer(0.1))  # the acceleration is old


def test_only_good_estimates_are_answered_and_extrapolating_ones_with_a_limit(start_controller, rig):
    start_controller(law="groundhook", damping=1000.0, rest_force=REST, timeout=10.0, extrapolating_limit=150.0)
    estimator = Estimates(rig)
    estimator.feel(0.0)
    rig.listen(0.2)
    assert estimator.answer(0.4) == pytest.approx(REST + 400.0)
    assert estimator.answer(0.4, EXTRAPOLATING) == pytest.approx(REST + 150.0)
    assert estimator.answer(-0.4, EXTRAPOLATING) == pytest.approx(REST - 150.0)
    assert estimator.answer(0.1, EXTRAPOLATING) == pytest.approx(REST + 100.0)
    for status in (WARMING_UP, DEGRADED, STALE, 77):
        assert np.isnan(estimator.answer(0.4, status)), status
    assert np.isnan(estimator.answer(float("nan")))
    assert estimator.answer(0.4) == pytest.approx(REST + 400.0)


def test_values_that_are_not_numbers_are_rejected_and_counted_without_further_effect(start_controller, rig):
    start_controller(law="skyhook", damping=1000.0, timeout=10.0)
    estimator = Estimates(rig)
    estimator.feel(2.0)
    rig.listen(0.2)
    estimator.answer(0.0)
    for value in (*NEITHER, 1e300):
        estimator.feel(value)
    for value in NEITHER:
        estimator.add(value)
    rig.listen(0.3)
    answers = [estimator.answer(0.0) for _ in range(10)]
    assert np.diff(answers) == pytest.approx(np.full(9, 1000.0 * 2.0 * 0.01), rel=0.2)  # the last good one is held
    values = rig.fresh_values("damper_controller: left")
    assert (values["accelerations rejected"], values["added forces ignored"]) == ("3", "2")


def test_an_acceleration_that_is_never_a_number_counts_as_too_old(start_controller, rig):
    start_controller(law="skyhook", timeout=0.5)
    estimator = Estimates(rig)
    estimator.feel(1.0)
    rig.listen(0.1)
    assert np.isfinite(estimator.answer(0.0))
    end = time.monotonic() + 1.0
    while time.monotonic() < end:
        estimator.feel(float("nan"))
        rig.listen(0.02)
    assert np.isnan(estimator.answer(0.0))


def test_with_a_table_the_safe_current_is_commanded_without_a_usable_estimate(start_controller, rig, tmp_path):
    start_controller(law="groundhook", damping=20000.0, table=by_table(tmp_path), safe_current=SAFE, timeout=1.0)
    estimator = Estimates(rig, "/damper_controller/desired_force")
    commands = estimator.commands
    estimator.publish_estimate(0.3)
    rig.wait(lambda: commands and commands[-1] == SAFE, "the safe current before the body is felt")

    def act() -> None:
        estimator.feel(0.0)
        rig.listen(0.1)
        estimator.answer(0.3)
        rig.wait(lambda: commands[-1] > 2.0 * SAFE, "a current by table")

    for velocity, status in ((0.3, STALE), (0.3, DEGRADED), (0.3, 77), (float("nan"), GOOD), (float("inf"), GOOD)):
        act()
        estimator.publish_estimate(velocity, status)
        rig.wait(lambda: commands[-1] == SAFE, f"the safe current at {velocity}, {status}")
    act()
    rig.wait(lambda: commands[-1] == SAFE, "the safe current when the estimates stop")


def test_its_health_reports_whether_it_controls_and_why_not(start_controller, rig):
    start_controller(law="groundhook", timeout=5.0)
    rig.wait(lambda: rig.message("damper_controller: node").startswith("no estimates"), "a report before any estimate")
    estimator = Estimates(rig)

    def tell_until(condition, what: str, status: int = GOOD) -> None:
        for _ in range(500):
            estimator.publish_estimate(0.1, status)
            rig.listen(0.05)
            if condition(rig.status("damper_controller: left")):
                return
        raise AssertionError(f"no report of {what}: {rig.status('damper_controller: left')}")

    tell_until(
        lambda status: status and status.level == WARN and "acceleration" in status.message, "the missing acceleration"
    )
    estimator.feel(0.0)
    rig.listen(0.1)
    tell_until(lambda status: status.level == OK and status.message == "controlling", "control")
    tell_until(lambda status: status.level == WARN and "not usable" in status.message, "unusable estimates", DEGRADED)
    rig.wait(lambda: "is the estimator running" in rig.message("damper_controller: left"), "the silence")


def test_the_motion_of_the_body_is_damped(start_controller, rig):
    start_controller(law="skyhook", damping=1000.0, timeout=10.0)
    estimator = Estimates(rig)
    estimator.feel(2.0)
    rig.listen(0.2)
    method_options = [estimator.answer(0.0) for _ in range(11)]
    assert np.diff(method_options) == pytest.approx(np.full(10, 1000.0 * 2.0 * 0.01), rel=0.2)  # the body gains speed


@pytest.mark.parametrize(
    "parameters, reason",
    [
        ({"law": "sky"}, "law is 'sky'; allowed are"),
        ({"share": 2.0}, "share: must be between 0 and 1"),
        ({"table": "missing.csv"}, "missing.csv: cannot be read as a table"),
    ],
)
def test_unusable_parameters_are_refused_in_one_line(parameters, reason, start_controller):
    process = start_controller(**parameters)
    said = process.communicate(timeout=120.0)[1]
    (line,) = [line for line in said.splitlines() if not line.startswith("[")]
    assert process.returncode == 1 and line.startswith("controller_node: ") and reason in line


def test_without_ros_it_reports_that_in_one_line():
    code = (
        "import sys; sys.modules['rclpy'] = None; from damper_estimator.node.main import controller as c; sys.exit(c())"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 1 and done.stderr.startswith("controller_node: ROS 2 is not complete here")
