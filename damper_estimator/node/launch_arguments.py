"""The arguments of the project's launch files, checked before anything starts.

``ros2 launch`` accepts any argument with any value. Here a value must fit its parameter, and an undeclared argument is
refused: always if it looks like a typing mistake, and in every case if the launch file was started directly. A launch
file that includes ours can have further arguments.
"""

import sys
from collections.abc import Mapping
from math import isfinite
from pathlib import Path

import yaml
from launch.actions import DeclareLaunchArgument, Shutdown
from launch.events.process import ProcessExited
from launch_ros.parameter_descriptions import ParameterValue

from damper_estimator.errors import InputError
from damper_estimator.node.controller_settings import DECLARATIONS as CONTROLLER_PARAMETERS
from damper_estimator.node.parameter import Declaration
from damper_estimator.node.settings import DECLARATIONS
from launch import LaunchContext

PACKAGE = "damper_estimator"
RESPAWN_DELAY = 1.0  # s
Value = str | float | int | bool

TIME = {"use_sim_time": Declaration(False, "take the time from /clock")}
ESTIMATOR_PARAMETERS = {
    name: DECLARATIONS[name] for name in ("model", "signals", "safe_current", "lead", "autostart")
} | TIME
COMMON = {
    "params_file": Declaration("", "YAML file with parameters; see config/node.yaml and controller.yaml"),
    "namespace": Declaration("", "namespace of the nodes and their relative topics, one per vehicle"),
    "log_level": Declaration("", "of the log", allowed=("debug", "info", "warn", "error", "fatal")),
    "respawn": Declaration(False, "restart a node when it ends"),
}
ESTIMATOR = ESTIMATOR_PARAMETERS | COMMON | {
    "displacement": Declaration("", "topic to which the default displacement topic is remapped"),
}  # fmt: skip
CONTROLLER = CONTROLLER_PARAMETERS | TIME | COMMON


class LaunchArguments:
    """The arguments of one launch file; final. A missing one leaves its parameter as set elsewhere."""

    def __init__(self, file: str, declarations: Mapping[str, Declaration]) -> None:
        """``file`` is the launch file's ``__file__``."""
        self._file = Path(file)
        self._declarations = dict(declarations)

    def declare(self) -> list[DeclareLaunchArgument]:
        """The declarations that ``ros2 launch --show-args`` lists."""
        return [
            DeclareLaunchArgument(name, default_value="", description=_described(declaration))
            for name, declaration in self._declarations.items()
        ]

    def given(self, context: LaunchContext) -> dict[str, Value]:
        """The given arguments, with the type of their parameter.

        Raises:
            InputError: one line with every unknown argument and every value that does not fit.
        """
        texts = {name: context.launch_configurations.get(name, "") for name in self._declarations}
        values, faults = {}, self._unknown(context, {name for name, text in texts.items() if text})
        for name, text in texts.items():
            value = parsed(text, self._declarations[name]) if text else None
            if value is not None:
                values[name] = value
            elif text:
                faults.append(f"{name}:={text}: {name} must be {self._declarations[name].requirement}")
        if faults:
            raise InputError(f"{self._file.name}: {'; '.join(faults)}")
        return values

    def _unknown(self, context: LaunchContext, given: set[str]) -> list[str]:
        free = self._declarations.keys() - given
        others = context.launch_configurations.keys() - self._declarations.keys()
        found = {name: f"; did you mean {meant}?" for name in others for meant in free if is_misspelt(name, meant)}
        if self._is_started_directly():
            words = [word.partition(":=")[0] for word in context.argv if ":=" in word]
            found = {name: "" for name in words if name not in self._declarations} | found
        return [f"there is no argument {name}{hint}" for name, hint in found.items()]

    def _is_started_directly(self) -> bool:
        """Whether ``ros2 launch`` was given this file, by package and name or by path."""
        words = sys.argv[1:]
        by_name = (PACKAGE, self._file.name) in zip(words, words[1:], strict=False)
        return by_name or any(Path(word).resolve() == self._file.resolve() for word in words)


def parsed(text: str, declaration: Declaration) -> Value | None:
    """The value of a text; None if it does not fit. True and false are spelled as in YAML: true, Yes, off ..."""
    kind = type(declaration.default)
    if kind is str:
        return text if not declaration.allowed or text in declaration.allowed else None
    if kind is bool:
        value = _loaded(text)
        return value if isinstance(value, bool) else None
    try:
        value = kind(text)
    except ValueError:
        return None
    is_inside = declaration.low is None or declaration.low <= value <= declaration.high
    return value if isfinite(value) and is_inside else None


def _described(declaration: Declaration) -> str:
    by_default = "" if declaration.default == "" else f"; by default {declaration.default}"
    return declaration.description + by_default


def is_misspelt(written: str, meant: str) -> bool:
    """Whether two different names differ by one letter (another, missing or surplus), by two exchanged letters, or only
    in case and hyphens.
    """
    a, b = (name.lower().replace("-", "_") for name in (written, meant))
    while a and b and a[0] == b[0]:
        a, b = a[1:], b[1:]
    while a and b and a[-1] == b[-1]:
        a, b = a[:-1], b[:-1]
    return written != meant and (max(len(a), len(b)) <= 1 or (len(a) == 2 and a == b[::-1]))


def parameter_files(given: Mapping[str, Value]) -> list[str]:
    """The ``params_file``, if it was given.

    Raises:
        InputError: if it is no file; launch itself would continue without it.
    """
    path = given.get("params_file", "")
    if path and not Path(path).is_file():
        raise InputError(f"params_file:={path}: no such file")
    return [path] if path else []


def parameters(given: Mapping[str, Value], names: Mapping[str, object]) -> list[dict[str, object]]:
    """The given arguments among the parameters ``names``, for a node; a text stays a text, also if it reads ``1``."""
    chosen = {
        name: ParameterValue(value, value_type=str) if isinstance(value, str) else value
        for name, value in given.items()
        if name in names
    }
    return [chosen] if chosen else []


def end_launch(event: ProcessExited, context: LaunchContext) -> list[Shutdown]:
    """For ``on_exit`` of a node without which the others are useless."""
    return [] if context.is_shutdown else [Shutdown(reason=f"{event.process_name} has ended")]


def is_set_elsewhere(name: str, files: list[str], context: LaunchContext) -> bool:
    """Whether a parameter file, or ``SetParameter`` of an including launch file, gives the parameter a value.

    For any node: the node itself checks whether the value is for it.
    """
    shared = context.launch_configurations.get("global_params", ())
    paths = [*files, *(entry for entry in shared if not isinstance(entry, tuple))]
    return any(entry[0] == name and entry[1] for entry in shared if isinstance(entry, tuple)) or any(
        _is_in(_loaded(Path(path).read_text(encoding="utf-8")), name) for path in paths
    )


def _loaded(text: str) -> object:
    """The content of a YAML text; None if it is invalid, which the node reports."""
    try:
        return yaml.safe_load(text)
    except yaml.YAMLError:
        return None


def _is_in(content: object, name: str) -> bool:
    if not isinstance(content, dict):
        return False
    parameters_of_node = content.get("ros__parameters")
    is_set = isinstance(parameters_of_node, dict) and bool(parameters_of_node.get(name))
    return is_set or any(_is_in(value, name) for value in content.values())
