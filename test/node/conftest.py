"""A real estimator process on real DDS; skipped, with the reason, if ROS is not installed."""

import os
import signal
import subprocess
import sysconfig
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from launched import car, launch, package  # noqa: F401  (fixtures)

ROOT = Path(__file__).resolve().parents[2]
EXECUTABLE = Path(sysconfig.get_path("scripts")) / "estimator_node"
STOPPED_WITHIN = 60.0  # s, far more than a node needs on a busy machine
NOTHING_LOST = {"qos_reliability": "reliable", "qos_depth": 2000}  # by the middleware: tests judge the node


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Tests that start an estimator come first in each module: the shared one would answer as well."""
    places = [place for place, item in enumerate(items) if item.path.parent == Path(__file__).parent]
    modules = {items[place].path: number for number, place in reversed(list(enumerate(places)))}
    ordered = sorted((items[p] for p in places), key=lambda item: (modules[item.path], "shared" in item.fixturenames))
    for place, item in zip(places, ordered, strict=True):
        items[place] = item


@pytest.fixture(scope="session", autouse=True)
def ros() -> None:
    """ROS 2, or a skip; under ``make test`` its absence is a failure."""
    try:
        import damper_msgs.msg  # noqa: F401
        import rclpy  # noqa: F401
    except ModuleNotFoundError as error:
        if os.environ.get("DAMPER_TEST_ROS") == "required":
            raise
        pytest.skip(f"ROS 2 is not complete here: {error} (make test sets it up)")


@pytest.fixture(scope="session", autouse=True)
def signals() -> None:
    """Processes that tests start receive SIGINT and SIGHUP, also if this one was started in the background."""
    for number, handler in ((signal.SIGINT, signal.default_int_handler), (signal.SIGHUP, signal.SIG_DFL)):
        if signal.getsignal(number) == signal.SIG_IGN:
            signal.signal(number, handler)


@pytest.fixture(scope="session", autouse=True)
def domain(ros, tmp_path_factory) -> Iterator[None]:
    """A free ROS domain on this machine, and a folder for ROS's logs."""
    from damper_estimator.node.playback.domain import free_ros_domain

    with pytest.MonkeyPatch.context() as patch, free_ros_domain():
        patch.setenv("ROS_LOG_DIR", str(tmp_path_factory.mktemp("ros_log")))
        yield


@pytest.fixture(scope="session")
def identified(tmp_path_factory) -> Callable[..., str]:
    """Library models as if they had been fitted to a damper, without which no estimate is GOOD: their files."""
    from damper_estimator.model import load_model, save_model

    folder = tmp_path_factory.mktemp("identified")

    def make(name: str, **region: list[float]) -> str:
        path = folder / f"{name}.yaml"
        fit = {"residual_stddev": 10.0, "region": {"velocity": [-20.0, 20.0]} | region}
        save_model(replace(load_model(name), fit=fit), path)
        return str(path)

    return make


@pytest.fixture
def start() -> Iterator[Callable[..., subprocess.Popen]]:
    """Starts estimator processes with ROS parameters (and further ROS arguments); they end with the test.

    ``before`` runs in the new process first. The quality of service is ``NOTHING_LOST`` unless the test changes it.
    """
    running = []

    def run(*ros_arguments: str, before: Callable | None = None, **parameters: object) -> subprocess.Popen:
        words = [word for name, value in (NOTHING_LOST | parameters).items() for word in ("-p", f"{name}:={value}")]
        process = subprocess.Popen(
            [EXECUTABLE, "--ros-args", *words, *ros_arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            preexec_fn=before,
        )
        running.append(process)
        return process

    yield run
    for process in running:
        stop(process)


@pytest.fixture(scope="module")
def shared(domain, identified) -> Iterator[Callable[..., None]]:
    """One estimator for all tests of a module: it is started once, and gets each test's parameters while it runs.

    Every change resets models and filters; counts of messages continue.
    """
    defaults = {
        "model": identified("coulomb"),
        "dampers": ["left"],
        "signals": "",
        "stale_after": 60.0,
        "desired_force_timeout": 0.1,
    }
    first = NOTHING_LOST | {"model": identified("coulomb"), "dampers": "[left]"}
    words = [word for name, value in first.items() for word in ("-p", f"{name}:={value}")]
    process = subprocess.Popen([EXECUTABLE, "--ros-args", *words])

    def set_parameters(rig, **parameters: object) -> None:
        taken, reason = rig.set(**defaults | parameters)
        assert taken, reason

    yield set_parameters
    process.terminate()
    assert process.wait(STOPPED_WITHIN) == 0


def stop(process: subprocess.Popen) -> None:
    """Ends a process that a test started, and reads its output."""
    process.terminate()
    try:
        process.communicate(timeout=STOPPED_WITHIN)
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()


@pytest.fixture
def player(domain) -> Iterator[object]:
    """A player for an estimator of the default name."""
    import rclpy

    from damper_estimator.node.playback.player import Player

    rclpy.init()
    player = Player()
    yield player
    player.close()
    rclpy.shutdown()


@pytest.fixture
def rig(domain) -> Iterator[object]:
    """A rig for an estimator of the default name."""
    import rclpy
    from rig import Rig

    rclpy.init()
    rig = Rig()
    yield rig
    rig.close()
    rclpy.shutdown()
