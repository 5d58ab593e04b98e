"""The node under test: its process, services, inputs and outputs; polled."""

import ctypes
import os
import resource
import signal
import subprocess
import sysconfig
import time
from collections import deque
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

import rclpy
from rclpy.qos import QoSProfile, ReliabilityPolicy
from soak_plant import NAMES

EXECUTABLE = Path(sysconfig.get_path("scripts")) / "estimator_node"
NODE = "/damper_estimator"
DISPLACEMENT, FORCE, DESIRED_FORCE = "/suspension/displacement", "/suspension/force", f"{NODE}/desired_force"
STATES = "sensor_msgs/msg/JointState"
TYPES = {
    "current": "std_msgs/msg/Float64", "temperature": "sensor_msgs/msg/Temperature",
    "pressure": "sensor_msgs/msg/FluidPressure", "acceleration": "geometry_msgs/msg/AccelStamped",
}  # fmt: skip
TOPICS = {f"/suspension/{name}/{role}": kind for role, kind in TYPES.items() for name in NAMES} | {
    FORCE: STATES, DESIRED_FORCE: STATES, DISPLACEMENT: STATES,
}  # fmt: skip
PR_SET_PDEATHSIG = 1  # of prctl(2)
PATIENCE = 120.0  # s, for a busy machine
DEPTH = 4000


def _alone() -> None:
    """In the node's process: it receives SIGHUP, also under nohup, and ends with the soak in any case."""
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


def message_type(name: str) -> type:
    """The Python class of ``package/msg/Name``."""
    package, folder, last = name.split("/")
    return getattr(import_module(f"{package}.{folder}"), last)


class SoakedNode:
    """Its process and all topics; final. rclpy must be initialised, in a separate domain.

    Attributes:
        forces, commands, stamped_commands, health: received but not yet processed: bytes; (name, bytes); bytes;
            messages.
    """

    def __init__(self, parameters: dict[str, object]) -> None:
        self.parameters = parameters
        self.forces: deque[bytes] = deque()
        self.commands: deque[tuple[str, bytes]] = deque()
        self.stamped_commands: deque[bytes] = deque()
        self.health: deque[object] = deque(maxlen=10)
        self._node = rclpy.create_node("soak", start_parameter_services=False)
        self._asking = rclpy.create_node("soak_client", start_parameter_services=False)
        self._executor = rclpy.executors.SingleThreadedExecutor()
        self._executor.add_node(self._asking)
        self._quality = QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.RELIABLE)
        self._publishers = {topic: self._publisher(topic) for topic in TOPICS}
        self._readers: dict[str, set[bytes]] = {topic: set() for topic in TOPICS}  # of all configurations so far
        self._clients: dict[str, object] = {}
        self._polled = []
        self._hear("damper_msgs/msg/DamperForces", f"{NODE}/force", self.forces.append)
        for name in NAMES:
            topic = f"/suspension/{name}/current_command"
            self._hear("std_msgs/msg/Float64", topic, lambda data, name=name: self.commands.append((name, data)))
        self._hear("damper_msgs/msg/DamperCommand", f"{NODE}/command", self.stamped_commands.append)
        self._hear("diagnostic_msgs/msg/DiagnosticArray", "/diagnostics", self.health.append, raw=False)
        self.process: subprocess.Popen | None = None

    def _publisher(self, topic: str):
        return self._node.create_publisher(message_type(TOPICS[topic]), topic, self._quality)

    def _hear(self, kind: str, topic: str, take: Callable, raw: bool = True) -> None:
        heard = self._node.create_subscription(message_type(kind), topic, lambda _: None, self._quality, raw=raw)
        self._polled.append((heard, raw, take))

    def start(self) -> None:
        """Starts the process and waits until both sides have discovered each other.

        Raises:
            RuntimeError: if a node of an earlier, killed run still answers in this domain.
        """
        if self.process is None and self._publishers[DISPLACEMENT].get_subscription_count():
            raise RuntimeError("another estimator answers in this domain; end it")
        words = [word for name, value in self.parameters.items() for word in ("-p", f"{name}:={value}")]
        self.process = subprocess.Popen(
            [EXECUTABLE, "--ros-args", "--log-level", "fatal", "--disable-rosout-logs", *words], start_new_session=True,
            preexec_fn=_alone,
        )  # fmt: skip
        self.find()

    def find(self) -> None:
        """Waits until the node is connected to all topics and reports it.

        The middleware may hear of each subscription seconds after the others, and lists those of a killed process as
        well: what counts is a subscription that no earlier configuration had.
        """
        self.wait(lambda: all(self._found(t) - self._readers[t] for t in self._needed()), "subscriptions")
        for topic, readers in self._readers.items():
            readers |= self._found(topic)
        self.health.clear()
        self.wait(lambda: len(self.health) > 1 and self._is_connected(), "the connection to the node")

    def _found(self, topic: str) -> set[bytes]:
        return {bytes(reader.endpoint_gid) for reader in self._node.get_subscriptions_info_by_topic(topic)}

    def _needed(self) -> list[str]:
        fused = "fused" in str(self.parameters["signals"])
        return [topic for topic in TOPICS if fused or "acceleration" not in topic]

    def _is_connected(self) -> bool:
        """By the node's report: a publisher here also counts the subscriptions of a process that was killed."""
        values = self.values()
        slow = [v for name in NAMES for k, v in values.get(name, {}).items() if k.endswith(": publishers")]
        if not slow or "0" in slow:
            return False
        publishers = values.get(f"input {DISPLACEMENT}", {}).get("publishers", "0")
        return publishers != "0" and values.get("output", {}).get("subscribers", "0") != "0"

    def values(self) -> dict[str, dict[str, str]]:
        """The newest report, by the last part of the status' names."""
        found = {}
        for status in self.health[-1].status if self.health else ():
            found[status.name.split(": ", 1)[-1]] = {pair.key: pair.value for pair in status.values}
        return found

    def publish(self, topic: str, data: bytes) -> None:
        """One serialised message."""
        self._publishers[topic].publish(data)

    def second_publisher(self, topic: str) -> Callable[[bytes], None]:
        """Adds a second publisher of a topic; ``end_second_publisher`` removes it."""
        publisher = self._publishers[f"{topic} (second)"] = self._publisher(topic)
        self.wait(publisher.get_subscription_count, f"a subscriber of {topic}")
        return publisher.publish

    def end_second_publisher(self, topic: str) -> None:
        """Removes the second publisher of a topic."""
        self._node.destroy_publisher(self._publishers.pop(f"{topic} (second)"))

    def restart_publisher(self, topic: str) -> None:
        """Restarts a publisher; returns when it is matched."""
        self._node.destroy_publisher(self._publishers[topic])
        publisher = self._publishers[topic] = self._publisher(topic)
        self.wait(publisher.get_subscription_count, f"a subscriber of {topic}")

    def poll(self) -> bool:
        """Receives messages; returns whether any arrived."""
        found = False
        for heard, raw, take in self._polled:
            while True:
                with heard.handle:
                    taken = heard.handle.take_message(heard.msg_type, raw)
                if taken is None:
                    break
                take(taken[0])
                found = True
        return found

    def wait(self, condition: Callable[[], object], what: str) -> None:
        """Polls until a condition holds.

        Raises:
            RuntimeError: on a timeout, or if the node has ended.
        """
        end = time.monotonic() + PATIENCE
        while not condition():
            if self.process is not None and self.process.poll() is not None:
                raise RuntimeError(f"the node ended with status {self.process.returncode} while {what} was waited for")
            if time.monotonic() > end:
                raise RuntimeError(f"waited {PATIENCE:g} s for {what}")
            if not self.poll():
                time.sleep(0.002)

    def ask(self, kind: type, service: str, request: object):
        """Calls a service; returns its future, for `is_answered`."""
        if service not in self._clients:
            self._clients[service] = self._asking.create_client(kind, f"{NODE}/{service}")
        client = self._clients[service]
        self.wait(client.service_is_ready, f"the service {service}")
        return client.call_async(request)

    def is_answered(self, future) -> bool:
        """Whether the answer has arrived."""
        if not future.done():
            self._executor.spin_once(timeout_sec=0.0)
        return future.done()

    def set(self, **values: object):
        """Sets parameters together; the future of the answer."""
        from rcl_interfaces.srv import SetParametersAtomically
        from rclpy.parameter import Parameter

        request = SetParametersAtomically.Request()
        request.parameters = [Parameter(name, value=value).to_parameter_msg() for name, value in values.items()]
        return self.ask(SetParametersAtomically, "set_parameters_atomically", request)

    def change(self, transition: int):
        """Asks for a transition of the managed node; the future of the answer."""
        from lifecycle_msgs.srv import ChangeState

        request = ChangeState.Request()
        request.transition.id = transition
        return self.ask(ChangeState, "change_state", request)

    def limit_files(self, size: int) -> None:
        """Limits the size of the node's files in bytes, as if the disk were full."""
        resource.prlimit(self.process.pid, resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))

    @property
    def memory(self) -> int:
        """Resident bytes."""
        statm = Path(f"/proc/{self.process.pid}/statm").read_text()
        return int(statm.split()[1]) * os.sysconf("SC_PAGE_SIZE")

    def signal(self, number: int) -> None:
        """Sends the process a signal."""
        os.kill(self.process.pid, number)

    def ended(self) -> int:
        """Waits for the end of the process; returns its status."""
        end = time.monotonic() + 30.0
        while self.process.poll() is None and time.monotonic() < end:
            if not self.poll():
                time.sleep(0.002)
        if self.process.poll() is None:
            self.process.kill()
        status = self.process.wait()
        for _ in range(50):  # the last messages can still be in transit
            self.poll()
            time.sleep(0.002)
        return status

    def close(self) -> None:
        """Ends the process and leaves the ROS graph."""
        if self.process is not None and self.process.poll() is None:
            self.signal(signal.SIGCONT)
            self.signal(signal.SIGTERM)
            self.ended()
        self._executor.shutdown()
        self._asking.destroy_node()
        self._node.destroy_node()
