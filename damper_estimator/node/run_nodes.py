"""Runs a node until a signal comes, then leaves the dampers at the safe current."""

import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Protocol

import rclpy
from rclpy.executors import Executor, ExternalShutdownException
from rclpy.signals import SignalHandlerOptions

from damper_estimator.errors import InputError
from damper_estimator.node.controller import ControllerNode
from damper_estimator.node.estimator_node import EstimatorNode
from damper_estimator.node.executors import make_executor
from damper_estimator.node.process import set_realtime_priority
from damper_estimator.node.rclpy_private import RCLError
from damper_estimator.node.ros_parameters import check_words
from damper_estimator.node.stopping import Stop

WAKE_UP = 0.1  # s, longest time until a signal is noticed
BROKEN = 1.0  # s for which an executor that only fails keeps running


class EndingNode(Protocol):
    """A node with an orderly end."""

    def end(self) -> None:
        """Leaves the dampers at the safe current, even if its context was shut down."""


def run_estimator(words: Sequence[str], stop: Stop) -> None:
    """Runs the estimator until a signal comes; raises InputError as `_run`."""
    _run(words, stop, _serve_estimator)


def run_controller(words: Sequence[str], stop: Stop) -> None:
    """Runs the example controller until a signal comes; raises InputError as `_run`."""
    _run(words, stop, _serve_controller)


def _run(words: Sequence[str], stop: Stop, serve: Callable[[Stop], None]) -> None:
    """Runs a node, with our signal handlers: rclpy's would shut the context down before the last commands are sent.

    Raises:
        InputError: if arguments, parameters, signal map or model are unusable.
    """
    try:
        rclpy.init(args=list(words), signal_handler_options=SignalHandlerOptions.NO)
    except RCLError as error:
        reason = str(error).partition(", at ")[0]
        raise InputError(
            f"{reason}; check the arguments and the parameter file (config/node.yaml shows one)"
        ) from error
    try:
        serve(stop)
    except ExternalShutdownException:
        pass
    except Exception:
        # The context was shut down while the node was being created.
        if rclpy.ok():
            raise
    finally:
        rclpy.try_shutdown()


def _serve_estimator(stop: Stop) -> None:
    node = EstimatorNode()
    check_words(node)
    executor = make_executor(node.get_parameter("executor").value, node.get_logger())
    with _ended(executor, node):
        if node.get_parameter("autostart").value:
            node.start()
        complaint = set_realtime_priority(node.get_parameter("realtime_priority").value)
        if complaint:
            node.get_logger().warning(complaint)
        _spin(executor, node, stop)


def _serve_controller(stop: Stop) -> None:
    node = ControllerNode()
    executor = make_executor("events", node.get_logger())
    with _ended(executor, node):
        _spin(executor, node, stop)


@contextmanager
def _ended(executor: Executor, node: EndingNode) -> Iterator[None]:
    """Adds the node to the executor, and ends both in order, even after an exception."""
    executor.add_node(node)
    try:
        yield
    finally:
        node.end()
        executor.shutdown()
        node.destroy_node()


def _spin(executor: Executor, node: EndingNode, stop: Stop) -> None:
    """Delivers messages until a signal comes, the context is shut down, or the executor only fails."""
    stop.is_orderly = True
    # EventsExecutor.spin() delivers nothing in some builds; spin_once() does in all.
    worked = time.monotonic()
    context = node.context
    while context.ok() and not stop.is_requested:
        try:
            executor.spin_once(timeout_sec=WAKE_UP)
            worked = time.monotonic()
        except ExternalShutdownException:
            return
        except Exception:
            # A request that makes rclpy itself fail must not end the estimates.
            if time.monotonic() - worked > BROKEN:
                raise
            if context.ok():
                node.get_logger().error(traceback.format_exc(), throttle_duration_sec=1.0)
