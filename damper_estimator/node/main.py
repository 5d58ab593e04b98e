"""Entry points of the executables; importable without ROS, so that its absence is one line and not a traceback."""

import sys
from collections.abc import Callable, Sequence

from damper_estimator.errors import InputError
from damper_estimator.node.stopping import Stop

DONE, REFUSED = 0, 1
NEEDED = ("rclpy", "damper_msgs", "diagnostic_msgs", "geometry_msgs", "sensor_msgs", "std_msgs")


def main() -> int:
    """Runs the estimator until a signal comes.

    Returns:
        The exit status: 0 after a signal, 1 if the node refuses to start (one line on standard error).
    """

    def run(words: Sequence[str], stop: Stop) -> None:
        from damper_estimator.runtime import compile_line_ahead

        compile_line_ahead()  # while ROS is imported and the models are prepared
        from damper_estimator.node.run_nodes import run_estimator

        run_estimator(words, stop)

    return _guarded("estimator_node", run)


def controller() -> int:
    """Runs the example controller until a signal comes; exit status as `main`."""

    def run(words: Sequence[str], stop: Stop) -> None:
        from damper_estimator.node.run_nodes import run_controller

        run_controller(words, stop)

    return _guarded("controller_node", run)


def _guarded(program: str, run: Callable[[Sequence[str], Stop], None]) -> int:
    stop = Stop()
    stop.listen()  # before anything is imported, which takes a second
    try:
        run(sys.argv, stop)
    except InputError as error:
        return _refuse(program, str(error))
    except ModuleNotFoundError as error:
        if (error.name or "").split(".")[0] not in NEEDED:
            raise
        return _refuse(
            program,
            f"ROS 2 is not complete here (no module {error.name}); source /opt/ros/jazzy/setup.bash "
            f"and the workspace's "
            "install/setup.bash, or use .venv of a checkout (make env)",
        )
    finally:
        stop.ignore()
    return DONE


def _refuse(program: str, reason: str) -> int:
    print(f"{program}: {reason}", file=sys.stderr)
    return REFUSED


if __name__ == "__main__":
    sys.exit(main())
