"""Every end of the process leaves the dampers at the safe current; if it cannot, the driver falls back."""

import signal
import subprocess
import sys
import time
from collections.abc import Callable

import pytest
from conftest import EXECUTABLE, NOTHING_LOST, STOPPED_WITHIN, stop
from semi_active import DAMPERS, SAFE, Car, by_table, semi_active_parameters

SIGNALS = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
DEACTIVATE, ACTIVE_SHUTDOWN = 4, 7
SAFE_STOPPED = 5
ALL_SAFE, ALL_STOPPED = dict.fromkeys(DAMPERS, SAFE), dict.fromkeys(DAMPERS, SAFE_STOPPED)
OWN_SAFE = 0.4  # the driver's
BEFORE = "import rclpy, signal, sys, time\nfrom damper_estimator.node import main, run_nodes\n"
AFTER = "\nsys.exit(main.main())"


@pytest.fixture
def car(rig) -> Car:
    return Car(rig)


@pytest.fixture
def parameters(tmp_path) -> dict[str, object]:
    return semi_active_parameters(tmp_path)


@pytest.fixture
def running():
    """Processes that end with the test."""
    processes = []

    def run(*words: object, **parameters: object) -> subprocess.Popen:
        values = [word for name, value in parameters.items() for word in ("-p", f"{name}:={value}")]
        processes.append(
            subprocess.Popen([*words, "--ros-args", *values], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        )
        return processes[-1]

    yield run
    for process in processes:
        stop(process)


def ended(process: subprocess.Popen, rig, is_here: Callable[[], bool]) -> str:
    """The output of the ended process, after its last messages have arrived; no message must follow."""
    said = process.communicate(timeout=STOPPED_WITHIN)[1]
    rig.wait(is_here, f"the safe current after the process had ended with {process.returncode} and said {said!r}")
    rig.listen(0.3)
    return said


def left_safe(car: Car) -> Callable[[], bool]:
    return lambda: (car.last(), car.sources) == (ALL_SAFE, ALL_STOPPED)


@pytest.mark.parametrize("executor", ["events", "single"])
@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_leaves_the_dampers_at_the_safe_current(number, executor, start, rig, car, parameters):
    process = start(**parameters, executor=executor)
    car.energise()
    process.send_signal(number)
    said = ended(process, rig, left_safe(car))
    assert (car.last(), car.sources, process.returncode) == (ALL_SAFE, ALL_STOPPED, 0)
    assert "Traceback" not in said and "rror" not in said.replace("damper_estimator", ""), said


@pytest.mark.parametrize("transition", [DEACTIVATE, ACTIVE_SHUTDOWN])
def test_a_transition_out_of_active_leaves_the_dampers_at_the_safe_current(transition, start, rig, car, parameters):
    start(**parameters)
    car.energise()
    assert rig.transition(transition)
    rig.wait(left_safe(car), "the safe current")
    rig.listen(0.3)
    assert (car.last(), car.sources) == (ALL_SAFE, ALL_STOPPED)


def test_a_context_that_is_shut_down_from_outside_leaves_the_dampers_at_the_safe_current(running, rig, car, parameters):
    code = BEFORE + (
        "from damper_estimator.node import current_topics\n"
        "current_topics.DISCOVERED = 60.0\n"  # a busy machine can take long to discover the drivers again
        "signal.signal(signal.SIGUSR1, lambda *_: rclpy.shutdown())\n"
    ) + AFTER  # fmt: skip
    process = running(sys.executable, "-c", code, **NOTHING_LOST | parameters)
    car.energise()
    process.send_signal(signal.SIGUSR1)
    said = ended(process, rig, left_safe(car))
    assert (car.last(), car.sources, process.returncode) == (ALL_SAFE, ALL_STOPPED, 0), said


def test_an_executor_that_only_fails_ends_the_process_and_leaves_the_safe_current(running, rig, car, parameters):
    code = BEFORE + (
        "class Failing(rclpy.executors.SingleThreadedExecutor):\n"
        "    is_broken = False\n"
        "    def spin_once(self, **options):\n"
        "        if self.is_broken: raise RuntimeError('broken on purpose')\n"
        "        super().spin_once(**options)\n"
        "run_nodes.make_executor = lambda *_: Failing()\n"
        "signal.signal(signal.SIGUSR1, lambda *_: setattr(Failing, 'is_broken', True))\n"
    ) + AFTER  # fmt: skip
    process = running(sys.executable, "-c", code, **NOTHING_LOST | parameters)
    car.energise()
    process.send_signal(signal.SIGUSR1)
    said = ended(process, rig, left_safe(car))
    assert (car.last(), car.sources, process.returncode) == (ALL_SAFE, ALL_STOPPED, 1)
    assert "broken on purpose" in said


def test_a_second_signal_ends_a_process_that_hangs(running, car, parameters):
    code = BEFORE + "signal.signal(signal.SIGUSR1, lambda *_: time.sleep(1000))" + AFTER
    process = running(sys.executable, "-c", code, **NOTHING_LOST | parameters)
    car.energise()
    process.send_signal(signal.SIGUSR1)
    time.sleep(0.5)
    process.send_signal(signal.SIGTERM)
    process.send_signal(signal.SIGINT)  # at the same time: the same request
    time.sleep(1.0)
    assert process.poll() is None
    process.send_signal(signal.SIGTERM)
    assert process.wait(10.0) == 128 + signal.SIGTERM


@pytest.mark.parametrize("number", SIGNALS)
def test_the_controller_with_a_table_leaves_the_dampers_at_the_safe_current(number, running, rig, tmp_path):
    from damper_msgs.msg import DamperForces
    from std_msgs.msg import Float64

    law = {"law": "groundhook", "damping": 20000.0, "timeout": 5.0}
    controller = EXECUTABLE.with_name("controller_node")
    process = running(controller, table=by_table(tmp_path), safe_current=SAFE, **law)
    commands = []
    rig.node.create_subscription(Float64, "/suspension/left/current_command", lambda m: commands.append(m.data), 100)
    estimates = rig.publisher("/damper_estimator/force", "damper_msgs/msg/DamperForces")
    felt = rig.publisher_unmatched("/suspension/left/body_acceleration", "geometry_msgs/msg/AccelStamped")
    numbers = {name: [0.0] for name in ("displacement", "acceleration", "force")}
    for i in range(5_000):
        message = DamperForces(name=["left"], velocity=[0.3], status=[0], **numbers)
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(10**12 + i * 10**7, 10**9)
        estimates.publish(message)
        felt.publish(felt.msg_type())
        rig.listen(0.01)
        if commands and commands[-1] > 2.0 * SAFE:
            break
    assert commands[-1] > 2.0 * SAFE
    process.send_signal(number)
    said = ended(process, rig, lambda: commands[-1] == SAFE)
    assert (commands[-1], process.returncode) == (SAFE, 0), said


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_a_driver_with_a_deadline_falls_back_when_commands_fail_to_come(number, running, start, rig, tmp_path):
    from std_msgs.msg import Float64

    car = Car(rig, DAMPERS[:1], driver=True)
    flowing = []
    rig.node.create_subscription(Float64, car.topic("left", "current"), lambda m: flowing.append(m.data), 100)
    running(sys.executable, "-m", "damper_estimator.node.driver_example", damper="left", safe_current=OWN_SAFE)
    rig.wait(lambda: flowing and flowing[-1] == OWN_SAFE, "the driver")
    process = start(**semi_active_parameters(tmp_path, DAMPERS[:1]))
    car.energise()
    car.drive_until(lambda: flowing[-1] > 2.0 * OWN_SAFE, "the current in the coil")
    process.send_signal(number)
    rig.wait(lambda: flowing[-1] == OWN_SAFE, "the driver's safe current")
    if number == signal.SIGSTOP:
        process.send_signal(signal.SIGCONT)
        car.drive_until(lambda: flowing[-1] != OWN_SAFE, "commands that count again")


def test_the_offer_to_drivers_matches_subscriptions_without_requests(start, rig, car, parameters):
    from rclpy.qos import DurabilityPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy
    from std_msgs.msg import Float64

    heard = {}
    for number, reliability in enumerate((ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT)):
        profile = QoSProfile(depth=10, reliability=reliability, durability=DurabilityPolicy.VOLATILE)
        rig.node.create_subscription(
            Float64, car.topic("left", "current_command"), lambda m, n=number: heard.setdefault(n, m.data), profile
        )
    start(**parameters)
    car.energise()
    assert set(heard) == {0, 1}
    for topic in (car.topic("left", "current_command"), "/damper_estimator/command"):
        (offered,) = rig.node.get_publishers_info_by_topic(topic)
        assert 0 < offered.qos_profile.deadline.nanoseconds <= 0.2e9
        assert offered.qos_profile.liveliness == LivelinessPolicy.AUTOMATIC
