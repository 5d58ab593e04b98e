"""Writes ``config/node.yaml`` and ``config/controller.yaml`` from the declarations of the parameters. Independent of
ROS.

python -m damper_estimator.node.parameter_files config
"""

import sys
from collections.abc import Mapping
from pathlib import Path
from textwrap import fill

import yaml

from damper_estimator.node.controller_settings import DECLARATIONS as CONTROLLER
from damper_estimator.node.parameter import Declaration
from damper_estimator.node.settings import DECLARATIONS as ESTIMATOR

WIDTH = 120
ESTIMATOR_HEADER = """\
# Parameters of estimator_node. Copy this file, change the values that differ, and start with
#   ros2 launch damper_estimator estimator.launch.py params_file:=/path/to/your.yaml
# Arguments of the launch file, such as model:=..., take precedence over the file.
# Topics are relative names and can be remapped; the signal map sets other topics and units. docs/integration.md
# describes how a controller should use the estimates. A change that cannot be used is refused with the reason, and the
# node continues unchanged; set parameters that belong together in one request (set_parameters_atomically).
"""
CONTROLLER_HEADER = """\
# Parameters of controller_node, the example controller of semi-active dampers. Copy this section into your parameter
# file, change the values that differ, and start with
#   ros2 launch damper_estimator semi_active.launch.py params_file:=/path/to/your.yaml
# or give single parameters on the command line (damping:=2000.0).
"""


def parameter_file(header: str, node: str, declarations: Mapping[str, Declaration]) -> str:
    """A parameter file with every default, and its explanation above it; ``node`` is a pattern of node names."""
    parts = [_explained(name, declaration) for name, declaration in declarations.items()]
    return f"{header}{node}:\n  ros__parameters:\n" + "\n".join(parts)


def _explained(name: str, declaration: Declaration) -> str:
    comment = _comment(declaration.explanation) + _comment(f"Changes take effect: {declaration.changes}.")
    if declaration.introduction:
        comment = f"{_comment(declaration.introduction)}    #\n{comment}"
    return f"{comment}    {name}: {_scalar(declaration.default)}\n"


def _comment(text: str) -> str:
    prefix = "    # "
    return fill(text, WIDTH, initial_indent=prefix, subsequent_indent=prefix, break_on_hyphens=False) + "\n"


def _scalar(value: object) -> str:
    content = list(value) if isinstance(value, tuple) else value
    return yaml.safe_dump(content, default_flow_style=True).removesuffix("\n").removesuffix("\n...")


def parameter_files() -> dict[str, str]:
    """The content of each shipped parameter file by name."""
    return {
        "node.yaml": parameter_file(ESTIMATOR_HEADER, "/**", ESTIMATOR),
        "controller.yaml": parameter_file(CONTROLLER_HEADER, "/**/damper_controller", CONTROLLER),
    }


def main() -> int:
    """Writes the files to the folder that is given."""
    (folder,) = sys.argv[1:]
    for name, content in parameter_files().items():
        (Path(folder) / name).write_text(content, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
