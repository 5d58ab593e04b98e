"""An example driver of a damper's coil: it sets the commanded current, and a safe current when commands fail to come.

    python -m damper_estimator.node.driver_example --ros-args -p damper:=front_left -p safe_current:=0.4

After a process was killed or a network broke, no command arrives, not even the safe current. Only the driver can
notice. It requests the deadline and the liveliness that the command's publisher offers (`quality_of_service`), and
falls back when no command has come for ``deadline`` s, when the publisher's process has been gone for ``lease`` s, and
when a command is not finite. The next good command counts again. A real driver also has a watchdog in its hardware.
"""

import sys
from math import isfinite

import rclpy
from rclpy.duration import Duration
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import LivelinessPolicy, QoSProfile
from std_msgs.msg import Float64

from damper_estimator.node.quality_of_service import DEADLINE, LEASE

PERIOD = 0.01  # s between two reports of the current that flows
PARAMETERS = {
    "damper": "left",  # name of the damper
    "safe_current": 0.0,  # A, set while no command can be trusted
    "lowest": 0.0,  # A, limits of the coil
    "highest": 2.0,
    "deadline": DEADLINE,  # s without a command; not below the offered deadline, or nothing is received
    "lease": LEASE,  # s without a sign of life from the commanding process
}


class DriverExample(Node):
    """Sets ``suspension/<damper>/current_command`` and reports ``suspension/<damper>/current``; final.

    Attributes:
        current: A, set now.
    """

    def __init__(self) -> None:
        super().__init__("driver_example")
        self.declare_parameters("", list(PARAMETERS.items()))
        value = {name: self.get_parameter(name).value for name in PARAMETERS}
        self._safe, self._limits = value["safe_current"], (value["lowest"], value["highest"])
        self.current = self._safe
        requested = QoSProfile(
            depth=1,
            deadline=Duration(seconds=value["deadline"]),
            liveliness=LivelinessPolicy.AUTOMATIC,
            liveliness_lease_duration=Duration(seconds=value["lease"]),
        )
        events = SubscriptionEventCallbacks(
            deadline=lambda _: self._fall_back("no command within the deadline"),
            liveliness=lambda event: event.alive_count or self._fall_back("the commanding process is gone"),
        )
        topic = f"suspension/{value['damper']}"
        self._flowing = self.create_publisher(Float64, f"{topic}/current", 10)
        self.create_subscription(Float64, f"{topic}/current_command", self._take, requested, event_callbacks=events)
        self.create_timer(PERIOD, self._report)

    def _take(self, command: Float64) -> None:
        if not isfinite(command.data):
            self._fall_back("the command is not finite")
            return
        low, high = self._limits
        self.current = min(max(command.data, low), high)

    def _fall_back(self, reason: str) -> None:
        self.get_logger().warning(f"{reason}; {self._safe:g} A is set", throttle_duration_sec=1.0)
        self.current = self._safe

    def _report(self) -> None:
        """Reports the set current; a real driver would measure it."""
        self._flowing.publish(Float64(data=self.current))


def main() -> int:
    """Runs until a signal comes."""
    rclpy.init()
    executor = SingleThreadedExecutor()
    executor.add_node(DriverExample())
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    rclpy.try_shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
