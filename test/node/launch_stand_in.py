"""Enough of ``launch`` and ``launch_ros`` to run the project's launch files where ROS's own cannot be had by pip.

The descriptions are made by the launch files themselves; what is imitated is how arguments are resolved, files included
and nodes turned into command lines.
"""

import runpy
import sys
import sysconfig
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType, SimpleNamespace

import yaml


class Declared(SimpleNamespace):
    """``DeclareLaunchArgument``."""

    def __init__(self, name: str, default_value: str, description: str) -> None:
        super().__init__(name=name, default=default_value, description=description)


class Configuration(SimpleNamespace):
    """``LaunchConfiguration``; the context is the mapping of arguments."""

    def __init__(self, name: str) -> None:
        super().__init__(name=name)

    def perform(self, context: Mapping[str, str]) -> str:
        return context[self.name]


class Function(SimpleNamespace):
    """``OpaqueFunction``."""

    def __init__(self, function) -> None:
        super().__init__(function=function)


class Included(SimpleNamespace):
    """``IncludeLaunchDescription``."""

    def __init__(self, source: str) -> None:
        super().__init__(source=source)


class Value(SimpleNamespace):
    """``ParameterValue``."""

    def __init__(self, value: str, value_type: type) -> None:
        super().__init__(value=value_type(value))


class Node(SimpleNamespace):
    """``launch_ros.actions.Node``."""

    def command(self) -> list[str]:
        """The command line that it stands for."""
        words = [str(Path(sysconfig.get_path("scripts")) / self.executable), *getattr(self, "arguments", ())]
        words += [] if "--ros-args" in words else ["--ros-args"]
        words += ["-r", f"__node:={self.name}", "-r", f"__ns:=/{self.namespace.lstrip('/')}"]
        for own in self.parameters:
            if not isinstance(own, dict):
                words += ["--params-file", str(own)]
                continue
            for name, value in own.items():
                plain = value.value if isinstance(value, Value) else value
                words += ["-p", f"{name}:={yaml.safe_dump(plain, default_style=quoted(plain)).splitlines()[0]}"]
        return words + [word for a, b in getattr(self, "remappings", ()) for word in ("-r", f"{a}:={b}")]


def quoted(value: object) -> str | None:
    """Texts are quoted, as launch does, so that a name of digits stays a text."""
    return '"' if isinstance(value, str) else None


def module(name: str, **content: object) -> ModuleType:
    made = ModuleType(name)
    vars(made).update(content)
    return made


MODULES = [
    module("launch", LaunchDescription=list),
    module(
        "launch.actions",
        DeclareLaunchArgument=Declared, IncludeLaunchDescription=Included, OpaqueFunction=Function,
    ),
    module("launch.substitutions", LaunchConfiguration=Configuration),
    module("launch.launch_description_sources", PythonLaunchDescriptionSource=str),
    module("launch_ros", __path__=[]),
    module("launch_ros.actions", Node=Node),
    module("launch_ros.parameter_descriptions", ParameterValue=Value),
]  # fmt: skip


def commands(path: Path, share: Path, given: Mapping[str, str], monkeypatch) -> list[list[str]]:
    """The command lines that a launch file starts with these arguments; ``share`` is the package's share folder.

    Raises KeyError for an argument that no file declares.
    """
    for own in MODULES:
        monkeypatch.setitem(sys.modules, own.__name__, own)
    monkeypatch.setattr("ament_index_python.packages.get_package_share_directory", lambda name: str(share))
    declared: set[str] = set()
    nodes = _nodes(path, dict(given), declared)
    if set(given) - declared:
        raise KeyError(f"{path.name} does not declare {sorted(set(given) - declared)}")
    return [node.command() for node in nodes]


def _nodes(path: Path, context: dict[str, str], declared: set[str]) -> list[Node]:
    found: list[Node] = []
    for action in runpy.run_path(str(path))["generate_launch_description"]():
        if isinstance(action, Declared):
            declared.add(action.name)
            context.setdefault(action.name, action.default)
        elif isinstance(action, Included):
            found += _nodes(Path(action.source), context, declared)
        else:
            found += action.function(context)
    return found
