"""An example controller: skyhook, groundhook or both mixed for every damper, by the estimates.

It subscribes to the estimates and to the acceleration of the body above every damper, and requests forces from the
estimator, which answers with currents by the inverse model. With a look-up table it commands the currents itself, as is
usual without a model. Controllers chain: a force on ``~/added_force`` is added. Without a usable estimate it requests
NaN, which the estimator answers with the safe current; with a table it commands the safe current itself.
"""

from collections.abc import Sequence
from dataclasses import replace

from damper_msgs.msg import DamperForces
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import AccelStamped
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import JointState

from damper_estimator.control import LAWS, ConstantCommand, CornerController, Law, TableCommand, load_table, mixed
from damper_estimator.node.controlled_corner import ControlledCorner, CornerTally
from damper_estimator.node.controller_health import corner_status
from damper_estimator.node.controller_settings import DECLARATIONS, ControllerSettings
from damper_estimator.node.current_topics import CurrentTopics, deliver
from damper_estimator.node.diagnostic_status import WARN, status
from damper_estimator.node.rclpy_private import RCLError
from damper_estimator.node.ros_parameters import check_words, declare
from damper_estimator.node.wire import NANOSECONDS, float_message

NAME = "damper_controller"
OUTPUT_DEPTH = 10
HEALTH_PERIOD = 1.0  # s, REP-107
LONGEST_WATCH = 0.05  # s between two checks for estimates that have stopped


class ControllerNode(Node):
    """Answers every estimate with a desired force, or with a current from a table; final."""

    def __init__(self) -> None:
        """Raises InputError if a parameter or the table is unusable."""
        super().__init__(NAME)
        declare(self, DECLARATIONS)
        check_words(self, DECLARATIONS)
        settings = ControllerSettings(**{name: self.get_parameter(name).value for name in DECLARATIONS})
        self._law: Law = (
            mixed(settings.damping, settings.share) if settings.law == "mixed" else LAWS[settings.law](settings.damping)
        )
        self._settings = settings
        self._table = TableCommand(load_table(settings.table), settings.lead) if settings.table else None
        self._corners: dict[str, ControlledCorner] = {}
        self._before: dict[str, CornerTally] = {}
        self._currents = CurrentTopics(self)
        # With a table the force is published for evaluation only.
        topic = "damper_estimator/desired_force" if self._table is None else "~/desired_force"
        self._desired = self.create_publisher(JointState, topic, OUTPUT_DEPTH)
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", OUTPUT_DEPTH)
        self.create_subscription(DamperForces, "damper_estimator/force", self._take_estimates, qos_profile_sensor_data)
        self.create_subscription(JointState, "~/added_force", self._take_added, qos_profile_sensor_data)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(HEALTH_PERIOD, self._publish_health, clock=steady)
        self.create_timer(min(0.5 * settings.timeout, LONGEST_WATCH), self._watch, clock=steady)

    def end(self) -> None:
        """With a table: leaves the dampers at the safe current, even if the context was shut down."""
        if self._table is None:
            return
        if self.context.ok():
            self._command_safe(list(self._corners))
        last = self._currents.last((name, float_message(self._settings.safe_current)) for name in self._corners)
        deliver(self, self._currents.publishers, last)

    def _now(self) -> float:
        return self.get_clock().now().nanoseconds / NANOSECONDS

    def _corner(self, name: str) -> ControlledCorner:
        """The corner of the damper; the first call creates its topics."""
        if name not in self._corners:
            command = ConstantCommand(float("nan")) if self._table is None else self._table
            settings = self._settings
            controller = CornerController(self._law, command, settings.rest_force, settings.safe_current, settings.lead)
            corner = self._corners[name] = ControlledCorner(controller, settings)

            def take_acceleration(message: AccelStamped) -> None:
                corner.add_acceleration(message.accel.linear.z, self._now())

            topic = f"suspension/{name}/body_acceleration"
            try:
                self.create_subscription(AccelStamped, topic, take_acceleration, qos_profile_sensor_data)
            except (ValueError, RCLError) as error:
                reason = str(error).partition(", at ")[0]
                self.get_logger().warning(f"{name}: passive, {topic} cannot be subscribed: {reason}")
            if self._table is not None:
                self._currents.offer([name])
        return self._corners[name]

    def _take_added(self, message: JointState) -> None:
        for name, effort in zip(message.name, message.effort, strict=False):
            self._corner(name).add_force(effort, self._now())

    def _take_estimates(self, message: DamperForces) -> None:
        stamp = message.header.stamp.sec * NANOSECONDS + message.header.stamp.nanosec
        now, desired = self._now(), {}
        for k, name in enumerate(message.name):
            motion = message.displacement[k], message.velocity[k], message.acceleration[k]
            action = self._corner(name).step(stamp, motion, message.status[k], now)
            if self._table is not None:
                current = self._settings.safe_current if action is None else action.current
                self._currents.publish(name, float_message(current))
            desired[name] = float("nan") if action is None else action.wanted
        self._desired.publish(JointState(header=message.header, name=list(desired), effort=list(desired.values())))

    def _watch(self) -> None:
        """Checks for estimates that have stopped."""
        now = self._now()
        silent = [name for name, corner in self._corners.items() if corner.is_silent(now)]
        if self._table is not None:
            self._command_safe(silent)

    def _command_safe(self, names: Sequence[str]) -> None:
        for name in names:
            self._currents.publish(name, float_message(self._settings.safe_current))

    def _publish_health(self) -> None:
        prefix = self.get_fully_qualified_name().lstrip("/")
        message = DiagnosticArray()
        message.header.stamp = self.get_clock().now().to_msg()
        for name, corner in self._corners.items():
            before = self._before.get(name, CornerTally())
            message.status.append(corner_status(prefix, name, corner.tally, before, corner.desired))
            self._before[name] = replace(corner.tally)
        if not self._corners:
            message.status.append(status(f"{prefix}: node", WARN, "no estimates yet; is the estimator running?", {}))
        self._diagnostics.publish(message)
