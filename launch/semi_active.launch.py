"""Starts the estimator and the example controller of semi-active dampers.

ros2 launch damper_estimator semi_active.launch.py model:=/path/to/models signals:=/path/to/map.yaml law:=skyhook
ros2 launch damper_estimator semi_active.launch.py model:=/path/to/models table:=/path/to/force_velocity.csv

Without a table the controller wishes forces and the estimator commands currents by the inverse of its model; with one
the controller commands currents by the table, from the same estimates and the same law.
"""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, OpaqueFunction
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from launch import LaunchDescription

ESTIMATOR = Path(get_package_share_directory("damper_estimator")) / "launch" / "estimator.launch.py"

NUMBERS = {
    "damping": ("2500.0", "N s/m, of the law"),
    "share": ("0.7", "of the skyhook in the mixed law, 0.0 to 1.0"),
    "rest_force": ("0.0", "N, of the dampers at rest, added to every wish"),
}
ARGUMENTS = {
    "law": ("mixed", "skyhook, groundhook, mixed or passive"),
    "table": ("", "force_velocity.csv of damper-estimator export; empty: the estimator's inverse model"),
    "namespace": ("", "namespace of both nodes and their relative topics, one per vehicle"),
    "use_sim_time": ("false", "take the time from /clock"),
} | NUMBERS


def controller(context) -> list[Node]:
    """The controller, with the arguments as its parameters."""
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    parameters = {name: ParameterValue(given[name], value_type=str) for name in ("law", "table")}
    parameters |= {name: float(given[name]) for name in NUMBERS}
    parameters["use_sim_time"] = given["use_sim_time"].lower() == "true"
    return [
        Node(
            package="damper_estimator",
            executable="controller_node",
            name="damper_controller",
            namespace=given["namespace"],
            parameters=[parameters],
            output="screen",
        )
    ]


def generate_launch_description() -> LaunchDescription:
    """What ``ros2 launch`` calls; the estimator's arguments are those of estimator.launch.py."""
    arguments = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (default, text) in ARGUMENTS.items()
    ]
    estimator = IncludeLaunchDescription(PythonLaunchDescriptionSource(str(ESTIMATOR)))
    return LaunchDescription([*arguments, estimator, OpaqueFunction(function=controller)])
