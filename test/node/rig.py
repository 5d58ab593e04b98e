"""Shared by the tests of the running node: a publisher of JointState, a client of its services, and its answers."""

import time
from collections.abc import Callable, Sequence

import numpy as np

PATIENCE = 300.0  # s, far more than anything here takes on a busy machine, compiling included
START = 1_700_000_000_000_000_000
MS = 1_000_000
DISCOVERED_WITHIN = 0.3  # s
ANSWERED_WITHIN = 20.0  # s; a question without an answer is asked again


class Rig:
    """Publishes to the node and keeps its messages; final. rclpy must be initialised."""

    def __init__(self, name: str = "/damper_estimator", reliable: bool = True) -> None:
        import rclpy
        from damper_msgs.msg import DamperForces
        from diagnostic_msgs.msg import DiagnosticArray
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.qos import QoSProfile, ReliabilityPolicy
        from sensor_msgs.msg import JointState

        self.name = name
        self.node = rclpy.create_node("rig", start_parameter_services=False)
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self.node)
        self._quality = QoSProfile(depth=2000, reliability=ReliabilityPolicy.RELIABLE)
        self.forces, self.residuals, self.health = [], [], []
        self.node.create_subscription(DamperForces, f"{name}/force", self.forces.append, self._quality)
        residual = self.node.create_subscription(JointState, f"{name}/residual", self.residuals.append, self._quality)
        self._residual_publishers = residual.get_publisher_count
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self.health.append, self._quality)
        self._publishers, self._clients = {}, {}
        self.stamp = START

    def publisher(self, topic: str = "/suspension/displacement", kind: str = "sensor_msgs/msg/JointState"):
        """A publisher that the node has discovered."""
        publisher = self.publisher_unmatched(topic, kind)
        self.wait(lambda: publisher.get_subscription_count() > 0, f"a subscriber of {topic}")
        return publisher

    def publisher_unmatched(self, topic: str, kind: str):
        """A publisher that is possibly not yet discovered."""
        from damper_estimator.node.inputs import message_type

        if topic not in self._publishers:
            self._publishers[topic] = self.node.create_publisher(message_type(kind), topic, self._quality)
        return self._publishers[topic]

    def ready(self) -> None:
        """Waits until the node's forces and our displacement are connected."""
        self.publisher()
        self.wait(lambda: self.values("output").get("subscribers", "0") != "0", "the node's forces")

    def ready_for_residuals(self) -> None:
        """As ``ready``, and until the gauge's topic and the node's residuals are connected."""
        self.ready()
        self.publisher("/suspension/force")
        self.wait(lambda: self._residual_publishers() > 0, "the node's residuals")

    def forget(self) -> None:
        """Destroys the publishers, as when a publisher ends."""
        for publisher in self._publishers.values():
            self.node.destroy_publisher(publisher)
        self._publishers.clear()

    def wait(self, condition: Callable[[], bool], what: str, patience: float = PATIENCE) -> None:
        """Waits until a condition holds."""
        end = time.monotonic() + patience
        while not condition():
            assert time.monotonic() < end, f"waited {patience:g} s for {what}; the node said {self.health[-1:]}"
            self._executor.spin_once(timeout_sec=0.02)

    def listen(self, seconds: float) -> None:
        """Receives messages for a while."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self._executor.spin_once(timeout_sec=0.02)

    def send(
        self, values: Sequence[float], names: Sequence[str] = ("left",), stamp: int | None = None, step: int = MS
    ) -> None:
        """One displacement message; without ``stamp`` it follows the last by ``step`` ns."""
        self.send_raw(joint_state(values, names, self._next(stamp, step)))

    def _next(self, stamp: int | None, step: int) -> int:
        if stamp is None:
            self.stamp += step
            return self.stamp
        return stamp

    def send_raw(self, data: bytes, topic: str = "/suspension/displacement") -> None:
        """Publishes arbitrary serialised bytes."""
        self.publisher(topic).publish(data)

    def drive(self, count: int, names: Sequence[str] = ("left",), step: int = MS, window: int = 20) -> list:
        """Sends ``count`` good messages, waiting for answers; returns the answers."""
        before = len(self.forces)
        for i in range(count):
            self.send([0.02 * np.sin(0.02 * i)] * len(names), names, step=step)
            self.wait(lambda i=i: self.answered(before) >= i - window, "answers")
        self.wait(lambda: self.answered(before) >= count, f"{count} answers")
        return [m for m in self.forces[before:] if 4 not in m.status]

    def answered(self, before: int) -> int:
        """Number of forces after the first ``before`` that are answers, not repetitions because the input stopped."""
        return sum(4 not in m.status for m in self.forces[before:])

    def status(self, ending: str):
        """The newest status with this ending of its name; None before the first."""
        for array in reversed(self.health[-3:]):
            for status in array.status:
                if status.name.endswith(ending):
                    return status
        return None

    def message(self, ending: str) -> str:
        """Its message, "" before the first."""
        status = self.status(ending)
        return status.message if status else ""

    def values(self, ending: str) -> dict[str, str]:
        """Its values by key."""
        status = self.status(ending)
        return {pair.key: pair.value for pair in status.values} if status else {}

    def fresh_values(self, ending: str) -> dict[str, str]:
        """The values of a report from after now."""
        seen = len(self.health)
        self.wait(lambda: len(self.health) > seen + 1, "two more reports")
        return self.values(ending)

    def call(self, kind: type, service: str, request: object) -> object:
        """Calls a service of the node."""
        future = self._request(kind, service, request)
        self.wait(future.done, f"an answer of {service}")
        return future.result()

    def ask(self, kind: type, service: str, request: object) -> object:
        """Calls a service that changes nothing, again if the answer is lost."""
        end = time.monotonic() + ANSWERED_WITHIN
        asked = self._request(kind, service, request)
        self.wait(lambda: asked.done() or time.monotonic() > end, f"an answer of {service}")
        return asked.result() if asked.done() else self.call(kind, service, request)

    def _request(self, kind: type, service: str, request: object) -> object:
        client = self._client(kind, service)
        self.wait(client.service_is_ready, f"the service {service}")
        return client.call_async(request)

    def _client(self, kind: type, service: str) -> object:
        """One client per service. A new one waits until the node has discovered it as well, which being ready does not
        include: an answer to a client that the node does not yet know is lost.
        """
        if service not in self._clients:
            self._clients[service] = self.node.create_client(kind, f"{self.name}/{service}")
            self.wait(self._clients[service].service_is_ready, f"the service {service}")
            self.listen(DISCOVERED_WITHIN)
        return self._clients[service]

    def transition(self, number: int) -> bool:
        """Requests a transition of the managed node; returns whether it took place."""
        from lifecycle_msgs.srv import ChangeState

        request = ChangeState.Request()
        request.transition.id = number
        return self.call(ChangeState, "change_state", request).success

    def state(self) -> str:
        """The managed node's state."""
        from lifecycle_msgs.srv import GetState

        return self.ask(GetState, "get_state", GetState.Request()).current_state.label

    def set(self, **parameters: object) -> tuple[bool, str]:
        """Sets parameters together; returns whether they were accepted, and else the reason."""
        from rcl_interfaces.srv import SetParametersAtomically
        from rclpy.parameter import Parameter

        request = SetParametersAtomically.Request()
        request.parameters = [Parameter(name, value=value).to_parameter_msg() for name, value in parameters.items()]
        result = self.call(SetParametersAtomically, "set_parameters_atomically", request).result
        return result.successful, result.reason

    def get(self, name: str) -> object:
        """The value of a parameter."""
        return self._values([name])[name]

    def dump(self) -> dict[str, object]:
        """All parameters by name; None if one has no value."""
        from rcl_interfaces.srv import ListParameters

        return self._values(self.ask(ListParameters, "list_parameters", ListParameters.Request()).result.names)

    def _values(self, names: Sequence[str]) -> dict[str, object]:
        from rcl_interfaces.srv import GetParameters
        from rclpy.parameter import parameter_value_to_python

        values = self.ask(GetParameters, "get_parameters", GetParameters.Request(names=names)).values
        assert len(values) == len(names), f"only {len(values)} of {len(names)} parameters have a value"
        found = {name: parameter_value_to_python(value) for name, value in zip(names, values, strict=True)}
        return {name: list(value) if type(value).__name__ == "array" else value for name, value in found.items()}

    def close(self) -> None:
        """Destroys the ROS node."""
        self._executor.shutdown()
        self.node.destroy_node()


def joint_state(values: Sequence[float], names: Sequence[str], stamp: int) -> bytes:
    """A serialised displacement message."""
    from damper_estimator.recordings import joint_states

    position = np.array([values], float) if len(values) else None
    return joint_states(list(names), np.array([stamp]), position=position)[0]
