"""The estimator's commands: a current per damper, and ``~/command`` with what is commanded and why."""

from collections.abc import Iterable, Sequence

from damper_msgs.msg import DamperCommand
from rclpy.publisher import Publisher

from damper_estimator.node.command_message import COMMAND_TYPE, CommandMessages
from damper_estimator.node.current_topics import CURRENT_TYPE, CurrentTopics, deliver
from damper_estimator.node.force_follower import Command
from damper_estimator.node.ports import Keep, PublishingNode
from damper_estimator.node.quality_of_service import OVERRIDABLE, offered
from damper_estimator.node.wire import float_message

DEPTH = 100


class CommandPublisher:
    """The publishers of commands, and their messages; final."""

    def __init__(self, node: PublishingNode, keep: Keep) -> None:
        self._node, self._keep = node, keep
        self._currents = CurrentTopics(node)
        self._messages = CommandMessages()
        self._reports: Publisher | None = None

    def open(self) -> None:
        """Creates ``~/command``."""
        self._reports = self._node.create_publisher(
            DamperCommand, "~/command", offered(DEPTH), qos_overriding_options=OVERRIDABLE
        )

    def offer(self, names: Iterable[str]) -> None:
        """See `CurrentTopics.offer`."""
        self._currents.offer(names)

    def publish(self, commands: Sequence[Command]) -> None:
        """Publishes currents, and reports them."""
        for command in commands:
            message = float_message(command.current)
            publisher = self._currents.publish(command.damper, message)
            if publisher is not None:
                self._keep(publisher, CURRENT_TYPE, message)
        self.report(commands)

    def report(self, commands: Sequence[Command]) -> None:
        """Reports commands with stamp and source, without publishing their currents."""
        for message in self._messages.of(commands):
            self._reports.publish(message)
            self._keep(self._reports, COMMAND_TYPE, message)

    def deliver(self, last: Sequence[Command] = ()) -> None:
        """Waits briefly until the published messages have arrived. The ``last`` commands could not be published,
        because the node's context was shut down (see `current_topics.deliver`).
        """
        if self._reports is None:
            return
        messages = self._currents.last((command.damper, float_message(command.current)) for command in last)
        messages += [(self._reports, message) for message in self._messages.of(last)]
        deliver(self._node, [*self._currents.publishers, self._reports], messages)

    def close(self) -> None:
        """Destroys the topics, after the published messages have arrived."""
        self.deliver()
        self._currents.close()
        if self._reports is not None:
            self._node.destroy_publisher(self._reports)
            self._reports = None
