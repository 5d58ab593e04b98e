"""Entry point of ``estimator_node``; importable without ROS, so that its absence is one line and no traceback."""

import sys

from damper_estimator.errors import InputError

PROGRAM = "estimator_node"
DONE, REFUSED = 0, 1
NEEDED = ("rclpy", "damper_msgs", "diagnostic_msgs", "sensor_msgs", "std_msgs")


def main() -> int:
    """Runs the node until it is told to stop.

    Returns:
        The exit status: 0 after a signal, 1 where the node refuses to start (one line on standard error).
    """
    try:
        from damper_estimator.node.run import run

        run(sys.argv)
    except KeyboardInterrupt:
        return DONE
    except InputError as error:
        return _refuse(str(error))
    except ModuleNotFoundError as error:
        if (error.name or "").split(".")[0] not in NEEDED:
            raise
        return _refuse(
            f"ROS 2 is not complete here (no module {error.name}); source /opt/ros/jazzy/setup.bash "
            f"and the workspace's "
            "install/setup.bash, or use .venv of a checkout (make env)"
        )
    return DONE


def _refuse(reason: str) -> int:
    print(f"{PROGRAM}: {' '.join(reason.split())}", file=sys.stderr)
    return REFUSED


if __name__ == "__main__":
    sys.exit(main())
