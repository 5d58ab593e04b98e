"""The checks of an installation: version, location and purpose of each part."""

import os
import platform
import shutil
import sys
import sysconfig
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module, metadata
from importlib.util import find_spec
from pathlib import Path

from damper_estimator import __version__
from damper_estimator.errors import InputError
from damper_estimator.share import share_path

OK, MISSING, PROBLEM = "ok", "missing", "problem"
EVERYTHING = "everything"
NODE = "the live node"
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "firefox", "microsoft-edge")


@dataclass(frozen=True)
class Check:
    """One part of the installation.

    Attributes:
        group: its heading.
        name: of the part.
        state: OK, MISSING, or PROBLEM (installed but unusable).
        found: version and location, or the problem.
        needed: its purpose.
        remedy: how to obtain it; empty if installed.
    """

    group: str
    name: str
    state: str
    found: str
    needed: str = EVERYTHING
    remedy: str = ""


# Distribution, module, purpose, argument of pip install (empty for required packages).
PACKAGES = (
    ("numpy", "numpy", EVERYTHING, ""),
    ("scipy", "scipy", EVERYTHING, ""),
    ("pyyaml", "yaml", EVERYTHING, ""),
    ("rosbags", "rosbags", "recordings", ""),
    ("mcap", "mcap", "recordings", ""),
    ("zstandard", "zstandard", "recordings", ""),
    ("plotly", "plotly", "--html, studio", ""),
    ("jinja2", "jinja2", "--html, studio", ""),
    ("numba", "numba", "speed (a hundred times)", ""),
    ("pymoo", "pymoo", "fit --method genetic, nsga2", "damper_estimator[evolutionary]"),
    ("dash", "dash", "studio", "damper_estimator[studio]"),
    ("distributed", "distributed", "fleet", "damper_estimator[fleet]"),
    ("pyarrow", "pyarrow", "fleet", "damper_estimator[fleet]"),
    ("pandas", "pandas", "to_dataframe() in Python", "pandas"),
)
ROS = (
    ("rclpy", NODE),
    ("damper_msgs", NODE),
    ("sensor_msgs", NODE),
    ("diagnostic_msgs", NODE),
    ("launch_ros", "ros2 launch"),
)


def all_checks() -> Iterator[Check]:
    """Every part in the order of display."""
    yield from _program()
    yield from (_package(*package) for package in PACKAGES)
    yield from _kernels()
    yield from _ros()
    yield from _programs()


def _program() -> Iterator[Check]:
    group = "program"
    yield Check(group, "damper_estimator", OK, f"{__version__} at {Path(__file__).resolve().parents[1]}")
    yield Check(group, "Python", OK, f"{platform.python_version()} at {sys.executable}")
    yield Check(group, "machine", OK, f"{platform.platform()}, {os.cpu_count()} cores")
    for name, needed in (("config/models", EVERYTHING), ("msg_defs/msg", "recordings"), ("bags", "demo")):
        try:
            place = share_path(name)
        except InputError:
            yield Check(group, name, MISSING, "not installed with the package", needed, "install the package again")
        else:
            yield Check(group, name, OK, f"{len(list(place.iterdir()))} files at {place}", needed)


def _package(distribution: str, module: str, needed: str, optional: str) -> Check:
    group = "optional packages" if optional else "packages"
    if find_spec(module) is None:
        remedy = f"pip install '{optional or distribution}'"
        return Check(group, distribution, MISSING, "not installed", needed, remedy)
    try:
        version = metadata.version(distribution)
    except metadata.PackageNotFoundError:
        version = "version unknown"
    return Check(group, distribution, OK, version, needed)


def _kernels() -> Iterator[Check]:
    """Whether kernels are compiled, and the location of the machine code."""
    from damper_estimator.compiled import COMPILED, machine_code_folders

    group = "compiled kernels"
    if not COMPILED:
        found = "no numba, or NUMBA_DISABLE_JIT is set: plain Python, a hundred times slower"
        yield Check(group, "compilation", MISSING, found, "speed", "pip install numba, unset NUMBA_DISABLE_JIT")
        return
    import_module("damper_estimator.workflows.comparing")
    import_module("damper_estimator.effects.discovery").all_effects()
    folders = machine_code_folders()
    if not folders:
        found = "no folder for machine code: every start compiles again"
        yield Check(group, "cache", PROBLEM, found, "a quick start", "set NUMBA_CACHE_DIR to a writable folder")
        return
    stored = sum(1 for folder in folders if folder.is_dir() for _ in folder.glob("*.nbi"))
    place = f"at {folders[0].parent if len(folders) == 1 else os.path.commonpath(folders)}"
    if not all(os.access(_existing(folder), os.W_OK) for folder in folders):
        yield Check(group, "cache", PROBLEM, f"cannot be written {place}", "a quick start", "set NUMBA_CACHE_DIR")
    elif stored:
        yield Check(group, "cache", OK, f"{stored} kernels stored {place}", "a quick start")
    else:
        yield Check(group, "cache", OK, f"empty, the first commands compile their kernels, {place}", "a quick start")


def _existing(folder: Path) -> Path:
    return next(candidate for candidate in (folder, *folder.parents) if candidate.exists())


def _ros() -> Iterator[Check]:
    group = "ROS 2"
    installed = find_spec("rclpy") is not None
    distribution = os.environ.get("ROS_DISTRO") or ("from this Python environment" if installed else "none sourced")
    yield Check(group, "distribution", OK if installed else MISSING, distribution, NODE)
    for name, needed in ROS:
        yield _ros_module(group, name, needed)


def _ros_module(group: str, name: str, needed: str) -> Check:
    remedy = "build msg_defs with colcon and source it" if name == "damper_msgs" else "source /opt/ros/jazzy/setup.bash"
    if find_spec(name) is None:
        return Check(group, name, MISSING, "not installed, or not sourced", needed, remedy)
    try:
        module = import_module(name)
    except Exception as error:  # a broken or foreign build can raise anything
        return Check(group, name, PROBLEM, f"cannot be imported: {' '.join(str(error).split())[:100]}", needed, remedy)
    return Check(group, name, OK, str(Path(str(module.__file__)).parent), needed)


def _programs() -> Iterator[Check]:
    group = "programs"
    browser = next((found for name in BROWSERS if (found := shutil.which(name))), None)
    yield Check(
        group, "browser", OK if browser else MISSING, browser or "none of the common ones is in PATH",
        "studio, pages of --html", "" if browser else "install one, or open the pages on another machine",
    )  # fmt: skip
    from damper_estimator.codegen.build import find_compiler

    compiler = find_compiler()
    yield Check(
        group, "C compiler", OK if compiler else MISSING, compiler or "none of CC, cc, gcc, clang",
        "export --fmu", "" if compiler else "apt install gcc",
    )  # fmt: skip
    command = shutil.which("damper-estimator", path=os.pathsep.join(_scripts()))
    yield Check(
        group, "damper-estimator", OK if command else MISSING, command or "not in PATH",
        "calling it by its name", "" if command else "activate the environment, or: python -m damper_estimator",
    )  # fmt: skip


def _scripts() -> list[str]:
    return [os.environ.get("PATH", ""), sysconfig.get_path("scripts")]
