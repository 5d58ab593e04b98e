"""Starts the damper force estimator, a managed node that configures and activates by itself.

ros2 launch damper_estimator estimator.launch.py model:=/path/to/front_left.yaml namespace:=car_7

Missing arguments are as in params_file, or else the defaults of the node (config/node.yaml).
"""

from launch.actions import OpaqueFunction
from launch_ros.actions import LifecycleNode

from damper_estimator.errors import InputError
from damper_estimator.node.launch_arguments import (
    ESTIMATOR,
    ESTIMATOR_PARAMETERS,
    RESPAWN_DELAY,
    LaunchArguments,
    end_launch,
    is_set_elsewhere,
    parameter_files,
    parameters,
)
from damper_estimator.node.parameter import Declaration
from launch import LaunchDescription

REQUIRED = {"required": Declaration(False, "end the launch when the node ends, unless it is started again")}
ARGUMENTS = LaunchArguments(__file__, ESTIMATOR | REQUIRED)


def estimator(context) -> list[LifecycleNode]:
    """The node; arguments that cannot be used are refused before it starts."""
    given = ARGUMENTS.given(context)
    files = parameter_files(given)
    if "model" not in given and not is_set_elsewhere("model", files, context):
        raise InputError("estimator.launch.py: no model is given; give model:=/path/to/model.yaml, or a params_file")
    respawn = given.get("respawn", False)
    is_required = given.get("required", False) and not respawn
    return [
        LifecycleNode(
            package="damper_estimator",
            executable="estimator_node",
            name="damper_estimator",
            namespace=given.get("namespace", ""),
            parameters=[*files, *parameters(given, ESTIMATOR_PARAMETERS)],
            remappings=[("suspension/displacement", given["displacement"])] if "displacement" in given else [],
            ros_arguments=["--log-level", given["log_level"]] if "log_level" in given else [],
            respawn=respawn,
            respawn_delay=RESPAWN_DELAY,
            on_exit=end_launch if is_required else None,
            output="screen",
        )
    ]


def generate_launch_description() -> LaunchDescription:
    """For ``ros2 launch``."""
    return LaunchDescription([*ARGUMENTS.declare(), OpaqueFunction(function=estimator)])
