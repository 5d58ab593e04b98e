"""A node's process: ROS up, node made, messages delivered until a signal comes."""

import signal
import traceback
from collections.abc import Callable, Sequence

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

from damper_estimator.errors import InputError
from damper_estimator.node.controller import ControllerNode
from damper_estimator.node.estimator_node import EstimatorNode
from damper_estimator.node.executors import make_executor
from damper_estimator.node.process import set_realtime_priority
from damper_estimator.node.rclpy_private import RCLError
from damper_estimator.node.settings import check_words

WAKE_UP = 0.1  # s, longest time until a signal is seen


def run_estimator(words: Sequence[str]) -> None:
    """Runs the estimator until SIGINT or SIGTERM; raises InputError as `_run`."""
    _run(words, _serve_estimator)


def run_controller(words: Sequence[str]) -> None:
    """Runs the example controller until SIGINT or SIGTERM; raises InputError as `_run`."""
    _run(words, _serve_controller)


def _run(words: Sequence[str], serve: Callable[[], None]) -> None:
    """Runs a node.

    Raises:
        InputError: where arguments, parameters, signal map or model are unusable.
    """
    # rclpy takes the signals; Python's own KeyboardInterrupt would come in the middle of a callback.
    signal.signal(signal.SIGINT, lambda *_: None)
    try:
        rclpy.init(args=list(words))
    except RCLError as error:
        reason = str(error).partition(", at ")[0]
        raise InputError(
            f"{reason}; check the arguments and the parameter file (config/node.yaml shows one)"
        ) from error
    try:
        serve()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except Exception:
        # A signal that comes while the node is being made takes ROS away under it.
        if rclpy.ok():
            raise
    finally:
        rclpy.try_shutdown()


def _serve_estimator() -> None:
    node = EstimatorNode()
    check_words(node)
    executor = make_executor(node.get_parameter("executor").value, node.get_logger())
    executor.add_node(node)
    try:
        if node.get_parameter("autostart").value:
            node.start()
        complaint = set_realtime_priority(node.get_parameter("realtime_priority").value)
        if complaint:
            node.get_logger().warning(complaint)
        _deliver(executor, node)
    finally:
        node.end()
        executor.shutdown()
        node.destroy_node()


def _serve_controller() -> None:
    node = ControllerNode()
    executor = make_executor("events", node.get_logger())
    executor.add_node(node)
    try:
        _deliver(executor, node)
    finally:
        executor.shutdown()
        node.destroy_node()


def _deliver(executor: object, node: Node) -> None:
    # EventsExecutor.spin() delivers nothing in some builds; spin_once() does in all.
    while rclpy.ok():
        try:
            executor.spin_once(timeout_sec=WAKE_UP)
        except (KeyboardInterrupt, ExternalShutdownException):
            raise
        except Exception:
            # A request that rclpy itself stumbles over must not end the estimates.
            if rclpy.ok():
                node.get_logger().error(traceback.format_exc(), throttle_duration_sec=1.0)
