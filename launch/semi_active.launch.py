"""Starts the estimator and the example controller of semi-active dampers; when either ends, the launch ends.

ros2 launch damper_estimator semi_active.launch.py model:=/path/to/models signals:=/path/to/map.yaml law:=skyhook
ros2 launch damper_estimator semi_active.launch.py model:=/path/to/models table:=/path/to/force_velocity.csv

Without a table the controller requests forces and the estimator commands currents by the inverse of its model; with a
table the controller commands the currents, from the same estimates and the same law. Missing arguments are as in
params_file, or else the defaults of the nodes (config/node.yaml, config/controller.yaml). params_file, safe_current,
lead and the arguments that estimator.launch.py shares are for both nodes.
"""

from pathlib import Path

from launch.actions import GroupAction, IncludeLaunchDescription, OpaqueFunction
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch_ros.actions import Node

from damper_estimator.node.launch_arguments import (
    CONTROLLER,
    CONTROLLER_PARAMETERS,
    ESTIMATOR,
    RESPAWN_DELAY,
    TIME,
    LaunchArguments,
    end_launch,
    parameter_files,
    parameters,
)
from launch import LaunchDescription

ARGUMENTS = LaunchArguments(__file__, ESTIMATOR | CONTROLLER)


def both(context) -> list:
    """Both nodes; arguments that cannot be used are refused before either starts."""
    given = ARGUMENTS.given(context)
    source = PythonLaunchDescriptionSource(str(Path(__file__).with_name("estimator.launch.py")))
    estimator = IncludeLaunchDescription(source, launch_arguments=[("required", "true")])
    respawn = given.get("respawn", False)
    controller = Node(
        package="damper_estimator",
        executable="controller_node",
        name="damper_controller",
        namespace=given.get("namespace", ""),
        parameters=[*parameter_files(given), *parameters(given, CONTROLLER_PARAMETERS | TIME)],
        ros_arguments=["--log-level", given["log_level"]] if "log_level" in given else [],
        respawn=respawn,
        respawn_delay=RESPAWN_DELAY,
        on_exit=None if respawn else end_launch,
        output="screen",
    )
    return [GroupAction([estimator]), controller]


def generate_launch_description() -> LaunchDescription:
    """For ``ros2 launch``."""
    return LaunchDescription([*ARGUMENTS.declare(), OpaqueFunction(function=both)])
