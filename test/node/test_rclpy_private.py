"""The names of rclpy outside its public interface still exist, still do the same, and are still needed."""

import ast
import inspect
import time
from importlib.metadata import version
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PRIVATE_FILE = ROOT / "damper_estimator" / "node" / "rclpy_private.py"
PRIVATE_MODULES = ("rclpy._rclpy_pybind11", "rclpy.experimental", "rclpy.impl")
LOOK = "; look at damper_estimator/node/rclpy_private.py"


@pytest.fixture
def context(domain):
    """rclpy for one test."""
    import rclpy

    rclpy.init()
    yield
    rclpy.shutdown()


def private_names(path: Path) -> list[str]:
    """Imports of private modules of rclpy, and private attributes of objects other than ``self``."""
    found = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom | ast.Import):
            named = [alias.name for alias in node.names]
            names = [f"{node.module}.{name}" for name in named] if isinstance(node, ast.ImportFrom) else named
            found += [name for name in names if name.startswith(PRIVATE_MODULES) or name.startswith("rclpy._")]
        elif isinstance(node, ast.FunctionDef) and node.name.startswith("_LifecycleNodeMixin__"):
            found.append(node.name)
        elif isinstance(node, ast.Attribute) and node.attr in ("handle", "take_message"):
            found.append(node.attr)
    return found


def test_private_names_are_in_one_file():
    everywhere = {path.name: found for path in PRIVATE_FILE.parent.glob("*.py") if (found := private_names(path))}
    assert set(everywhere) == {PRIVATE_FILE.name}
    assert {"rclpy._rclpy_pybind11.RCLError", "_LifecycleNodeMixin__change_state", "take_message"} <= set(
        everywhere[PRIVATE_FILE.name]
    )


def test_the_release_is_one_that_the_private_names_were_written_for():
    try:
        release = version("ros-jazzy-rclpy")
    except ModuleNotFoundError:
        release = version("rclpy")
    assert release.startswith("7.1."), f"rclpy {release} is new here: run these tests against it{LOOK}"


def test_rcl_errors_are_what_rclpy_raises_for_a_topic_that_cannot_be_one(context):
    import rclpy

    from damper_estimator.node.rclpy_private import RCLError

    node = rclpy.create_node("probe")
    with pytest.raises(RCLError):
        node.resolve_topic_name("{unknown}/topic")
    node.destroy_node()


def test_loggers_have_the_named_type(context):
    import rclpy

    from damper_estimator.node.rclpy_private import RcutilsLogger

    node = rclpy.create_node("probe")
    assert isinstance(node.get_logger(), RcutilsLogger)
    node.destroy_node()


def test_the_events_executor_exists_and_spins_once(context):
    from damper_estimator.node.rclpy_private import events_executor

    executor = events_executor()
    assert executor is not None, f"rclpy.experimental has no EventsExecutor any more{LOOK}"
    # It is no subclass of Executor in this release; these are the methods in use.
    assert all(callable(getattr(executor, name)) for name in ("add_node", "remove_node", "spin_once", "shutdown"))
    executor.spin_once(timeout_sec=0.0)
    executor.shutdown()


def test_a_waiting_message_is_taken_as_bytes_once(context):
    import rclpy
    from rclpy.serialization import serialize_message
    from std_msgs.msg import Float64

    from damper_estimator.node.rclpy_private import take

    node = rclpy.create_node("probe")
    subscription = node.create_subscription(Float64, "probed", lambda _: None, 10, raw=True)
    publisher = node.create_publisher(Float64, "probed", 10)
    assert take(subscription) is None
    sent, end, taken = serialize_message(Float64(data=1.5)), time.monotonic() + 60.0, None
    publisher.publish(sent)
    while taken is None and time.monotonic() < end:
        taken = take(subscription)
    data, info = taken
    assert data == sent and info["source_timestamp"] > 0 and take(subscription) is None
    node.destroy_node()


def test_an_impossible_transition_is_refused_and_plain_rclpy_still_raises(context):
    """If the second part fails, rclpy refuses by itself: remove `RefusingLifecycleNode`."""
    from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
    from rclpy.lifecycle.node import LifecycleNodeMixin

    from damper_estimator.node.rclpy_private import RCLError, RefusingLifecycleNode

    changing = getattr(LifecycleNodeMixin, "_LifecycleNodeMixin__change_state", None)
    assert changing is not None, f"rclpy changes states by another method{LOOK}"
    assert list(inspect.signature(changing).parameters) == ["self", "transition_id"], LOOK
    ours, plain = RefusingLifecycleNode("refusing"), LifecycleNode("plain")
    assert ours.trigger_deactivate() == TransitionCallbackReturn.FAILURE
    with pytest.raises(RCLError):
        plain.trigger_deactivate()
    ours.destroy_node()
    plain.destroy_node()
