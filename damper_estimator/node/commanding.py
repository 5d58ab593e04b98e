"""What the estimator commands: a current per damper, and ``~/command``, which says what is commanded and why."""

from collections.abc import Callable, Iterable, Sequence

from damper_msgs.msg import DamperCommand
from rclpy.node import Node
from rclpy.publisher import Publisher

from damper_estimator.node.command_message import COMMAND_TYPE, CommandMessages
from damper_estimator.node.commands import Command
from damper_estimator.node.outputs import CommandOutputs, settle
from damper_estimator.node.quality import OVERRIDABLE, offered
from damper_estimator.node.wire import float_message

DEPTH = 100


class Commanding:
    """The publishers of commands, and their messages; final."""

    def __init__(self, node: Node, keep: Callable[[Publisher, str, bytes], None]) -> None:
        """``keep`` takes publisher, type and bytes of every message that is published."""
        self._node, self._keep = node, keep
        self._currents = CommandOutputs(node)
        self._messages = CommandMessages()
        self._statement: Publisher | None = None

    def open(self) -> None:
        """Has ``~/command``."""
        self._statement = self._node.create_publisher(
            DamperCommand, "~/command", offered(DEPTH), qos_overriding_options=OVERRIDABLE
        )

    def offer(self, names: Iterable[str]) -> None:
        """See `CommandOutputs.offer`."""
        self._currents.offer(names)

    def publish(self, commands: Sequence[Command]) -> None:
        """Publishes currents, and says what they answer."""
        for command in commands:
            message = float_message(command.current)
            publisher = self._currents.publish(command.damper, message)
            if publisher is not None:
                self._keep(publisher, "std_msgs/msg/Float64", message)
        self.state(commands)

    def state(self, commands: Sequence[Command]) -> None:
        """Says with stamp and source what is commanded, without commanding it."""
        for message in self._messages.of(commands):
            self._statement.publish(message)
            self._keep(self._statement, COMMAND_TYPE, message)

    def settle(self, last: Sequence[Command] = ()) -> None:
        """Waits, but not long, until what was published has arrived; ``last`` is what could not be published, because
        the node's context was shut down (see `outputs.settle`).
        """
        if self._statement is None:
            return
        messages = self._currents.last((command.damper, float_message(command.current)) for command in last)
        messages += [(self._statement, message) for message in self._messages.of(last)]
        settle(self._node, [*self._currents.publishers, self._statement], messages)

    def close(self) -> None:
        """Gives the topics up, once what was published has arrived."""
        self.settle()
        self._currents.close()
        if self._statement is not None:
            self._node.destroy_publisher(self._statement)
            self._statement = None
