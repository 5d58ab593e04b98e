"""Starts the damper force estimator, a managed node that by itself configures and activates.

ros2 launch damper_estimator estimator.launch.py model:=/path/to/front_left.yaml namespace:=car_7
"""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from launch import LaunchDescription

PARAMETERS = Path(get_package_share_directory("damper_estimator")) / "config" / "node.yaml"

ARGUMENTS = {
    "params_file": (str(PARAMETERS), "YAML file with the node's parameters; each is explained in config/node.yaml"),
    "model": ("", "model file, folder with one DAMPER.yaml each, or a model's name; empty: as in params_file"),
    "signals": ("", "signal map (YAML); empty: as in params_file"),
    "namespace": ("", "namespace of the node and its relative topics, one per vehicle"),
    "displacement": ("suspension/displacement", "topic that is remapped to the default displacement topic"),
    "use_sim_time": ("false", "take the time of /diagnostics from /clock (estimates carry the input's stamp anyway)"),
    "autostart": ("true", "configure and activate at once; false leaves both to a lifecycle manager"),
    "log_level": ("info", "debug, info, warn or error"),
}


def estimator(context) -> list[Node]:
    """The node, with those arguments on top of the parameter file that were given."""
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    overrides = {name: ParameterValue(given[name], value_type=str) for name in ("model", "signals") if given[name]}
    for name in ("use_sim_time", "autostart"):
        overrides[name] = given[name].lower() == "true"
    return [
        Node(
            package="damper_estimator",
            executable="estimator_node",
            name="damper_estimator",
            namespace=given["namespace"],
            parameters=[given["params_file"], overrides],
            remappings=[("suspension/displacement", given["displacement"])],
            arguments=["--ros-args", "--log-level", given["log_level"]],
            output="screen",
        )
    ]


def generate_launch_description() -> LaunchDescription:
    """What ``ros2 launch`` calls."""
    arguments = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (default, text) in ARGUMENTS.items()
    ]
    return LaunchDescription([*arguments, OpaqueFunction(function=estimator)])
