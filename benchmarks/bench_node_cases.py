"""Cases of `bench_node`: the work of the node while it is measured, and the messages for it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml

from damper_estimator.recordings import floats, joint_states

NODE = "/damper_estimator"
CHANGE_EVERY = 2.0  # s between two changes of the model
REGION = {"velocity": [-9.0, 9.0], "displacement": [-1.0, 1.0], "acceleration": [-1e4, 1e4], "command": [0.0, 2.0]}
FIT = {"cutoff": 60.0, "residual_stddev": 20.0, "region": REGION}
SEMI_ACTIVE = [{"command_lag": {}}, {"viscous": {"rate": 800.0}}, {"semi_active_squash": {"gain": 600.0}}]


def _nothing(node: object, is_node: bool) -> Callable[[int], None]:
    return lambda i: None


@dataclass(frozen=True)
class Case:
    """One measured case.

    Attributes:
        rate: Hz of the displacement.
        make: returns the node's parameters, for a folder.
        sends: returns the action before message i, for the driver's rclpy node and whether the estimator answers.
        has_bars: whether the ratios have limits.
    """

    title: str
    dampers: int
    rate: float
    make: Callable[[Path], Mapping[str, object]] = lambda folder: {"model": "carrera_akutain"}
    sends: Callable[[object, bool], Callable[[int], None]] = _nothing
    has_bars: bool = False

    @property
    def names(self) -> tuple[str, ...]:
        """Of the dampers."""
        return tuple(f"damper_{i}" for i in range(self.dampers))

    def parameters(self, folder: Path) -> dict[str, object]:
        """Parameters of the node in addition to the common ones."""
        return dict(self.make(folder))

    def before_message(self, node: object, is_node: bool) -> Callable[[int], None]:
        """The action before message i."""
        return self.sends(node, is_node)


def _semi_active(folder: Path) -> dict[str, object]:
    content = {"name": "semi", "source": "the benchmark", "effects": SEMI_ACTIVE, "fit": FIT}
    (folder / "semi.yaml").write_text(yaml.safe_dump(content))
    return {"model": str(folder / "semi.yaml"), "command_lag": 0.0, "desired_force_timeout": 1.0}


def _desires(node: object, is_node: bool) -> Callable[[int], None]:
    """A current with every second message, and a desired force with every fifth."""
    from sensor_msgs.msg import JointState
    from std_msgs.msg import Float64

    names = [f"damper_{i}" for i in range(4)]
    flows = [node.create_publisher(Float64, f"/suspension/{name}/current", 100) for name in names]
    desired, current = node.create_publisher(JointState, f"{NODE}/desired_force", 100), floats(np.array([0.5]))[0]

    def send(i: int) -> None:
        for publisher in flows if i % 2 == 0 else ():
            publisher.publish(current)
        if i % 5 == 0:
            effort = np.full((1, 4), 300.0 * np.sin(0.02 * i))
            desired.publish(joint_states(names, np.array([1]), effort=effort)[0])

    return send


def _changes(node: object, is_node: bool) -> Callable[[int], None]:
    """Loads the model again every ``CHANGE_EVERY`` s."""
    from rcl_interfaces.srv import SetParameters
    from rclpy.parameter import Parameter

    client = node.create_client(SetParameters, f"{NODE}/set_parameters")
    request = SetParameters.Request(parameters=[Parameter("model", value="carrera_akutain").to_parameter_msg()])

    def send(i: int) -> None:
        if is_node and i % int(CHANGE_EVERY * 1000.0) == 500 and client.service_is_ready():
            client.call_async(request)

    return send


def _gauge(node: object, is_node: bool) -> Callable[[int], None]:
    """A gauge that deviates more and more from the estimate, so that the alarm is raised."""
    from sensor_msgs.msg import JointState

    names = [f"damper_{i}" for i in range(4)]
    publisher = node.create_publisher(JointState, "/suspension/force", 100)

    def send(i: int) -> None:
        from time import time_ns

        effort = np.full((1, 4), 1000.0 * np.sin(0.009 * i) * (1.0 + i / 4000.0))
        publisher.publish(joint_states(names, np.array([time_ns()]), effort=effort)[0])

    return send


CASES = (
    Case("estimation", 4, 1000.0, has_bars=True),
    Case("estimation", 4, 2000.0),
    Case("estimation", 8, 500.0),
    Case("inverse", 4, 1000.0, _semi_active, _desires),
    Case("model change", 4, 1000.0, sends=_changes),
    Case("alarm", 4, 1000.0, lambda folder: {"model": "carrera_akutain", "drift_window": 1.0}, _gauge),
)
