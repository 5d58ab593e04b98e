"""Launches a file as ``ros2 launch`` does, with its arguments: python launch_runner.py FILE [name:=value ...]

The same calls as in ``ros2launch.api``, which has no wheel; without a terminal, so that SIGINT is passed on.
"""

import sys

from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import AnyLaunchDescriptionSource

from launch import LaunchDescription, LaunchService


def main() -> int:
    """Runs until everything has ended, or SIGINT; the exit status is that of ``ros2 launch``."""
    path, *words = sys.argv[1:]
    arguments = [tuple(word.split(":=", maxsplit=1)) for word in words]
    service = LaunchService(argv=words, noninteractive=True)
    included = IncludeLaunchDescription(AnyLaunchDescriptionSource(path), launch_arguments=arguments)
    service.include_launch_description(LaunchDescription([included]))
    return service.run()


if __name__ == "__main__":
    sys.exit(main())
