"""The example controller: what it wishes, what other controllers add, and when it is silent."""

import subprocess
import sys
import time

import numpy as np
import pytest
from conftest import EXECUTABLE, stop

CONTROLLER = EXECUTABLE.with_name("controller_node")
FORCE, FELT, ADDED = "/damper_estimator/force", "/suspension/left/body_acceleration", "/damper_controller/added_force"
GOOD, STALE = 0, 4
REST = -300.0


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
    """Stands in for the estimator; final."""

    def __init__(self, rig) -> None:
        from damper_msgs.msg import DamperForces
        from geometry_msgs.msg import AccelStamped
        from sensor_msgs.msg import JointState

        self.rig, self.wishes, self.count = rig, [], 0
        self._types = DamperForces, AccelStamped, JointState
        rig.node.create_subscription(JointState, "/damper_estimator/desired_force", self.wishes.append, 100)
        self._force = rig.publisher(FORCE, "damper_msgs/msg/DamperForces")
        rig.wait(lambda: rig.node.count_publishers("/damper_estimator/desired_force") > 0, "the controller")
        self._felt = rig.publisher_unmatched(FELT, "geometry_msgs/msg/AccelStamped")
        while not self._felt.get_subscription_count():  # its topics are made with the first estimate that it hears
            self.tell(0.0)
            rig.listen(0.1)
        self._added = rig.publisher(ADDED, "sensor_msgs/msg/JointState")
        rig.listen(0.3)

    def tell(self, velocity: float, status: int = GOOD) -> None:
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

    def answer(self, velocity: float, status: int = GOOD) -> float | None:
        """The wish that answers an estimate; None where none comes."""
        before = len(self.wishes)
        self.tell(velocity, status)
        end = time.monotonic() + 2.0
        while len(self.wishes) == before and time.monotonic() < end:
            self.rig.listen(0.02)
        return self.wishes[-1].effort[0] if len(self.wishes) > before else None


def test_the_wish_is_the_laws_with_what_others_add_and_silence_without_the_body(start_controller, rig):
    start_controller(law="groundhook", damping=1000.0, rest_force=REST, timeout=5.0)
    estimator = Estimates(rig)
    assert estimator.answer(0.2) is None  # the body was not felt yet
    estimator.feel(0.0)
    rig.listen(0.2)
    assert estimator.answer(0.2) == pytest.approx(REST + 200.0)  # the wheel goes down at 0.2 m/s
    assert estimator.wishes[-1].name == ["left"]
    estimator.add(50.0)
    rig.listen(0.2)
    assert estimator.answer(0.1) == pytest.approx(REST + 50.0 + 100.0)
    assert estimator.answer(0.1, STALE) is None
    rig.listen(5.5)
    assert estimator.answer(0.1) is None  # what was felt is old


def test_the_body_is_damped_against_the_sky(start_controller, rig):
    start_controller(law="skyhook", damping=1000.0, timeout=10.0)
    estimator = Estimates(rig)
    estimator.feel(2.0)
    rig.listen(0.2)
    wishes = [estimator.answer(0.0) for _ in range(11)]
    assert np.diff(wishes) == pytest.approx(np.full(10, 1000.0 * 2.0 * 0.01), rel=0.2)  # the body gains speed


@pytest.mark.parametrize(
    "parameters, reason",
    [
        ({"law": "sky"}, "law is 'sky'; allowed are"),
        ({"share": 2.0}, "share: must be between 0 and 1"),
        ({"table": "missing.csv"}, "missing.csv: cannot be read as a table"),
    ],
)
def test_what_it_cannot_run_with_is_refused_in_one_line(parameters, reason, start_controller):
    process = start_controller(**parameters)
    said = process.communicate(timeout=120.0)[1]
    (line,) = [line for line in said.splitlines() if not line.startswith("[")]
    assert process.returncode == 1 and line.startswith("controller_node: ") and reason in line


def test_without_ros_it_says_so_in_one_line():
    code = (
        "import sys; sys.modules['rclpy'] = None; from damper_estimator.node.main import controller as c; sys.exit(c())"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 1 and done.stderr.startswith("controller_node: ROS 2 is not complete here")
