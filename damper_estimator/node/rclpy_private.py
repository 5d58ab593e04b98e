"""The only file that uses names of rclpy outside its public interface; each comment says why.

Written against rclpy 7.1 (Jazzy). ``test/node/test_rclpy_private.py`` compares each with the installed release and
fails, with the name, when a release changes it.
"""

from rclpy._rclpy_pybind11 import RCLError
from rclpy.executors import Executor
from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
from rclpy.subscription import Subscription

__all__ = ["RCLError", "RcutilsLogger", "RefusingLifecycleNode", "events_executor", "take"]

# RCLError, of rclpy._rclpy_pybind11: what the C++ part raises for a topic that cannot be one, unknown arguments and
# transitions that do not exist. rclpy.exceptions has no class for it; its base, RuntimeError, would include our bugs.
#
# RcutilsLogger, of rclpy.impl: the type of what the public Node.get_logger() returns; needed for annotations only.


def events_executor() -> Executor | None:
    """An ``EventsExecutor``, or None if the release has none.

    ``rclpy.experimental`` may change without notice. Since rclpy 7.1 it delivers a message at half the processor time
    of the public executors, but ``spin`` delivers nothing in some builds (see `executors`).
    """
    try:
        from rclpy.experimental.events_executor import EventsExecutor
    except ImportError:
        return None
    return EventsExecutor()


def take(subscription: Subscription) -> tuple[object, object] | None:
    """The next waiting message and its information, outside the executor; None if none waits.

    ``Subscription.handle`` is public, its ``take_message`` is not documented; the executors of rclpy 7.1 and
    ``rclpy.wait_for_message`` call it in the same way.
    """
    with subscription.handle:
        return subscription.handle.take_message(subscription.msg_type, subscription.raw)


class RefusingLifecycleNode(LifecycleNode):
    """A managed node that refuses a transition that its present state does not have.

    ``LifecycleNodeMixin.__change_state`` of rclpy 7.1 raises then: the service ``change_state`` never answers, and the
    exception ends the process (rclpy issue 1209). Later releases refuse by themselves (rclpy pull request 1319); then
    a plain ``LifecycleNode`` suffices.
    """

    def _LifecycleNodeMixin__change_state(self, transition_id: int) -> TransitionCallbackReturn:
        try:
            return super()._LifecycleNodeMixin__change_state(transition_id)
        except RCLError as error:
            if not self.context.ok():
                raise
            self.get_logger().error(f"transition {transition_id} is not possible now ({error})".partition(", at ")[0])
            return TransitionCallbackReturn.FAILURE
