"""The node's process: ROS up, node made, messages delivered until a signal comes."""

from collections.abc import Sequence

import rclpy
from rclpy._rclpy_pybind11 import RCLError
from rclpy.executors import ExternalShutdownException

from damper_estimator.errors import InputError
from damper_estimator.node.estimator_node import EstimatorNode
from damper_estimator.node.executors import make_executor

WAKE_UP = 0.1  # s, longest time until a signal is seen


def run(words: Sequence[str]) -> None:
    """Runs the node until SIGINT or SIGTERM.

    Raises:
        InputError: where arguments, parameters, signal map or model are unusable.
    """
    try:
        rclpy.init(args=list(words))
    except RCLError as error:
        reason = str(error).partition(", at ")[0]
        raise InputError(
            f"{reason}; check the arguments and the parameter file (config/node.yaml shows one)"
        ) from error
    try:
        _serve()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except RCLError:
        # A signal that comes while the node is being made takes ROS away under it.
        if rclpy.ok():
            raise
    finally:
        rclpy.try_shutdown()


def _serve() -> None:
    node = EstimatorNode()
    executor = make_executor(node.settings.executor, node.get_logger())
    executor.add_node(node)
    try:
        # EventsExecutor.spin() delivers nothing in some builds; spin_once() does in all.
        while rclpy.ok():
            executor.spin_once(timeout_sec=WAKE_UP)
    finally:
        executor.shutdown()
        node.destroy_node()
