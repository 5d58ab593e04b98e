"""Chooses the executor: by events if that works in this installation, else rclpy's default."""

import time

import rclpy
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.executors import Executor, SingleThreadedExecutor

from damper_estimator.node.rclpy_private import RcutilsLogger, events_executor

PROBE_PERIOD = 0.001  # s
PROBE_TIME = 2.0  # s, far more than one timer needs


def make_executor(wanted: str, logger: RcutilsLogger) -> Executor:
    """The ``wanted`` executor; ``single``, with a log line, if ``events`` does not work."""
    if wanted == "events":
        executor = events_executor()
        if executor is not None and _delivers(executor):
            return executor
        logger.warning("executor 'events' does not work in this ROS installation; 'single' is used instead")
    return SingleThreadedExecutor()


def _delivers(executor: Executor) -> bool:
    """Whether a timer reaches its callback; tried out, since releases of Jazzy differ."""
    seen: list[bool] = []
    node = rclpy.create_node(
        "damper_estimator_probe", enable_rosout=False, start_parameter_services=False, use_global_arguments=False
    )
    node.create_timer(PROBE_PERIOD, lambda: seen.append(True), clock=Clock(clock_type=ClockType.STEADY_TIME))
    executor.add_node(node)
    end = time.monotonic() + PROBE_TIME
    while not seen and time.monotonic() < end and rclpy.ok():
        executor.spin_once(timeout_sec=PROBE_PERIOD)
    executor.remove_node(node)
    node.destroy_node()
    return bool(seen)
