"""An example controller: skyhook, groundhook or both mixed for every damper, behind the estimator.

It hears the estimates and the acceleration of the body above every damper, and wishes forces of the estimator, which
answers with currents by the inverse model. Given a look-up table it commands currents by that, as is usual without a
model. Controllers chain: what another one wishes on ``~/added_force`` is added.
"""

import numpy as np
from damper_msgs.msg import DamperForces
from geometry_msgs.msg import AccelStamped
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import JointState

from damper_estimator.control import LAWS, ConstantCommand, CornerController, Law, TableCommand, load_table, mixed
from damper_estimator.node.outputs import CommandOutputs
from damper_estimator.node.settings import STARTING, Declaration, check_words, declare
from damper_estimator.node.wire import NANOSECONDS, float_message
from damper_estimator.signals.layout import DT, ROWS, A, V, X

NAME = "damper_controller"
OUTPUT_DEPTH = 10
MAX_GAP = 0.1  # s between two estimates, after which the law starts anew

DECLARATIONS: dict[str, Declaration] = {
    "law": Declaration("mixed", "which force is wished", STARTING, allowed=(*LAWS, "mixed")),
    "damping": Declaration(2500.0, "N s/m, of the law", STARTING, 0.0, 1e5),
    "share": Declaration(0.7, "of the skyhook in the mixed law", STARTING, 0.0, 1.0),
    "rest_force": Declaration(0.0, "N, of the dampers at rest, added to every wish", STARTING, -1e5, 1e5),
    "table": Declaration("", "force_velocity.csv of damper-estimator export; '' wishes forces", STARTING),
    "safe_current": Declaration(0.0, "A, by table: without estimate or acceleration", STARTING, -1e3, 1e3),
    "timeout": Declaration(0.1, "s after which acceleration and added force are too old", STARTING, 0.002, 10.0),
}


class Corner:
    """One damper and the body above it; final.

    Attributes:
        felt, added: acceleration of the body in m/s^2, and force in N that another controller wishes; ``_at``: when.
    """

    def __init__(self, controller: CornerController) -> None:
        self._controller = controller
        self._sample = np.zeros(ROWS)
        self._stamp = 0
        self.felt = self.added = 0.0
        self.felt_at = self.added_at = float("-inf")

    def step(
        self, stamp: int, motion: tuple[float, float, float], now: float, timeout: float
    ) -> tuple[float, float] | None:
        """Wished force in N and current in A for an estimate; None without a recent acceleration of the body.

        Args:
            stamp: ns.
            motion: displacement, velocity and acceleration of the damper, SI.
            now, timeout: s.
        """
        if now - self.felt_at > timeout:
            self._stamp = 0
            return None
        step = (stamp - self._stamp) / NANOSECONDS
        self._stamp = stamp
        self._sample[DT] = step if 0.0 < step <= MAX_GAP else 0.0
        self._sample[X], self._sample[V], self._sample[A] = motion
        added = self.added if now - self.added_at <= timeout else 0.0
        action = self._controller.step(self._sample, self.felt, added)
        return action.wanted, action.current


class ControllerNode(Node):
    """Answers every estimate with wishes, or by table with currents; final."""

    def __init__(self) -> None:
        """Raises InputError where a parameter or the table is unusable."""
        super().__init__(NAME)
        declare(self, DECLARATIONS)
        check_words(self, DECLARATIONS)
        value = {name: self.get_parameter(name).value for name in DECLARATIONS}
        self._law: Law = (
            mixed(value["damping"], value["share"]) if value["law"] == "mixed" else LAWS[value["law"]](value["damping"])
        )
        self._rest_force, self._safe, self._timeout = value["rest_force"], value["safe_current"], value["timeout"]
        self._table = TableCommand(load_table(value["table"])) if value["table"] else None
        self._corners: dict[str, Corner] = {}
        self._currents = CommandOutputs(self)
        # By table the wish is only told, for those who judge it.
        wishes = "damper_estimator/desired_force" if self._table is None else "~/wished_force"
        self._wishes = self.create_publisher(JointState, wishes, OUTPUT_DEPTH)
        self.create_subscription(DamperForces, "damper_estimator/force", self._estimated, qos_profile_sensor_data)
        self.create_subscription(JointState, "~/added_force", self._added, qos_profile_sensor_data)

    def _now(self) -> float:
        return self.get_clock().now().nanoseconds / NANOSECONDS

    def _corner(self, name: str) -> Corner:
        """Of the damper; the first time its topics are made."""
        if name not in self._corners:
            command = ConstantCommand(float("nan")) if self._table is None else self._table
            corner = Corner(CornerController(self._law, command, self._rest_force, self._safe))
            self._corners[name] = corner

            def feel(message: AccelStamped) -> None:
                corner.felt, corner.felt_at = message.accel.linear.z, self._now()

            topic = f"suspension/{name}/body_acceleration"
            self.create_subscription(AccelStamped, topic, feel, qos_profile_sensor_data)
            if self._table is not None:
                self._currents.offer([name])
        return self._corners[name]

    def _added(self, message: JointState) -> None:
        for name, effort in zip(message.name, message.effort, strict=False):
            corner = self._corner(name)
            corner.added, corner.added_at = effort, self._now()

    def _estimated(self, message: DamperForces) -> None:
        stamp = message.header.stamp.sec * NANOSECONDS + message.header.stamp.nanosec
        now, wished = self._now(), {}
        for k, name in enumerate(message.name):
            motion = message.displacement[k], message.velocity[k], message.acceleration[k]
            is_stale = message.status[k] == DamperForces.STALE
            decided = None if is_stale else self._corner(name).step(stamp, motion, now, self._timeout)
            if self._table is not None:
                self._currents.publish(name, float_message(self._safe if decided is None else decided[1]))
            if decided is not None:
                wished[name] = decided[0]
        if wished:
            self._wishes.publish(JointState(header=message.header, name=list(wished), effort=list(wished.values())))
