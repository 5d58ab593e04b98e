"""The topics on which the node commands currents, one per damper whose force depends on one."""

from rclpy.node import Node
from rclpy.publisher import Publisher
from std_msgs.msg import Float64

from damper_estimator.node.rclpy_private import RCLError

DEPTH = 10


class CommandOutputs:
    """Publishers of ``suspension/<damper>/current_command``; final."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._publishers: dict[str, Publisher] = {}

    def offer(self, names: list[str]) -> None:
        """Has a topic for each of these dampers; one whose name cannot be part of a topic has none."""
        for name in names:
            if name in self._publishers:
                continue
            topic = f"suspension/{name}/current_command"
            try:
                self._publishers[name] = self._node.create_publisher(Float64, topic, DEPTH)
            except (ValueError, RCLError) as error:
                reason = str(error).partition(", at ")[0]
                self._node.get_logger().warning(f"{name}: no currents can be commanded on {topic}: {reason}")

    def publish(self, name: str, data: bytes) -> str | None:
        """Publishes a serialised command; the topic, None where there is none."""
        publisher = self._publishers.get(name)
        if publisher is None:
            return None
        publisher.publish(data)
        return publisher.topic_name

    def close(self) -> None:
        """Gives the topics up."""
        for publisher in self._publishers.values():
            self._node.destroy_publisher(publisher)
        self._publishers.clear()
