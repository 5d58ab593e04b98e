"""What is installed: by pip without ROS, by colcon as ament_python package; and that the files about it agree."""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
import yaml

from damper_estimator import __version__

ROOT = Path(__file__).resolve().parents[1]
NOT_SOURCE = (
    ".git",
    ".venv*",
    "__pycache__",
    "bags",
    "build",
    "install",
    "log",
    "out",
    "test",
    "*.egg-info",
    ".hypothesis",
)
SCRIPTS = Path(sysconfig.get_path("scripts"))
INSTALLED = ("config/models/linear_viscous.yaml", "config/node.yaml", "launch/estimator.launch.py", "package.xml",
             "msg_defs/msg/DamperForces.msg")  # fmt: skip


@pytest.fixture(scope="module")
def source(tmp_path_factory) -> Path:
    """A copy of the sources, so that building leaves nothing in the checkout."""
    return Path(
        shutil.copytree(ROOT, tmp_path_factory.mktemp("ws") / "src", ignore=shutil.ignore_patterns(*NOT_SOURCE))
    )


@pytest.fixture(scope="module")
def by_pip(source, tmp_path_factory) -> Path:
    """Prefix of a plain ``pip install .``."""
    prefix = tmp_path_factory.mktemp("pip")
    words = (
        "-m pip install -qq --no-deps --no-build-isolation --no-cache-dir "
        "--disable-pip-version-check --ignore-installed"
    )
    run([sys.executable, *words.split(), "--prefix", prefix, source])
    return prefix


@pytest.fixture(scope="module")
def by_colcon(source, tmp_path_factory) -> Path:
    """Install folder of ``colcon build``."""
    if not (SCRIPTS / "colcon").exists():
        assert os.environ.get("DAMPER_TEST_ROS") != "required"
        pytest.skip("colcon is not installed (make test sets it up)")
    base = tmp_path_factory.mktemp("colcon")
    words = ["--log-base", base / "log", "build", "--build-base", base / "build", "--install-base", base / "install"]
    run([SCRIPTS / "colcon", *words, "--base-paths", source, "--packages-select", "damper_estimator"], base)
    return base / "install" / "damper_estimator"


def run(command: list, folder: Path | None = None, **environment: str) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, env=os.environ | environment)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def packages_of(prefix: Path) -> Path:
    (folder,) = prefix.glob("lib/python3*/site-packages")
    return folder


@pytest.mark.parametrize("installed", ["by_pip", "by_colcon"])
def test_installed_code_finds_its_installed_data(installed, request, tmp_path):
    prefix = request.getfixturevalue(installed)
    code = (
        "import damper_estimator\nfrom damper_estimator.share import share_path\nprint(damper_estimator.__file__)\n"
        f"for name in {INSTALLED!r}: print(share_path(name))"
    )
    found = run([sys.executable, "-c", code], tmp_path, PYTHONPATH=str(packages_of(prefix))).splitlines()
    assert [Path(name) for name in found] == [
        packages_of(prefix) / "damper_estimator" / "__init__.py",
        *(prefix / "share" / "damper_estimator" / name for name in INSTALLED),
    ]


@pytest.mark.parametrize("installed", ["by_pip", "by_colcon"])
def test_every_data_file_and_module_is_installed(installed, request):
    prefix = request.getfixturevalue(installed)
    for folder in ("config", "launch", "msg_defs/msg"):
        for path in (ROOT / folder).rglob("*"):
            if path.is_file() and "__pycache__" not in path.parts:
                assert (prefix / "share" / "damper_estimator" / path.relative_to(ROOT)).is_file(), path
    for path in (ROOT / "damper_estimator").rglob("*"):
        if path.is_file() and path.suffix not in (".pyc", ".nbi", ".nbc"):
            assert (packages_of(prefix) / path.relative_to(ROOT)).is_file(), path


def test_colcon_installs_what_ros_looks_for(by_colcon):
    assert (by_colcon / "share/ament_index/resource_index/packages/damper_estimator").is_file()
    for name in ("estimator_node", "controller_node", "damper-estimator"):
        assert os.access(by_colcon / "lib" / "damper_estimator" / name, os.X_OK)


def test_pip_installs_the_commands(by_pip, tmp_path):
    environment = {"PYTHONPATH": str(packages_of(by_pip))}
    assert (
        run([by_pip / "bin" / "damper-estimator", "--version"], tmp_path, **environment)
        == f"damper-estimator {__version__}\n"
    )
    assert os.access(by_pip / "bin" / "estimator_node", os.X_OK)


def test_without_ros_the_node_says_so_in_one_line():
    code = "import sys; sys.modules['rclpy'] = None; from damper_estimator.node.main import main; sys.exit(main())"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (1, "", 1)
    assert done.stderr.startswith("estimator_node: ROS 2 is not complete here (no module rclpy); source /opt/ros/jazzy")


def test_versions_and_names_agree():
    package = ElementTree.parse(ROOT / "package.xml").getroot()
    messages = ElementTree.parse(ROOT / "msg_defs" / "package.xml").getroot()
    assert package.findtext("version") == messages.findtext("version") == __version__
    assert (package.findtext("name"), messages.findtext("name")) == ("damper_estimator", "damper_msgs")
    assert package.findtext("license") == messages.findtext("license") == "Apache-2.0"
    assert "damper_msgs" in [entry.text for entry in package.iter("exec_depend")]


def ros_packages(*folders: Path) -> set[str]:
    """ROS packages that the Python files below import."""
    paths = [path for folder in folders for path in folder.rglob("*.py")]
    lines = re.findall(r"(?m)^\s*(?:from|import) (\w+)", "\n".join(path.read_text(encoding="utf-8") for path in paths))
    own = {"rclpy", "launch", "launch_ros", "ament_index_python"}
    return {name for name in lines if name in own or re.fullmatch(r"\w+_(msgs|interfaces)", name)}


def test_package_xml_names_every_ros_package_that_is_imported():
    package = ElementTree.parse(ROOT / "package.xml").getroot()
    run_time, in_tests = ({entry.text for entry in package.iter(f"{kind}_depend")} for kind in ("exec", "test"))
    # The node makes message types by name; those are in its source as text.
    text = "\n".join(path.read_text(encoding="utf-8") for path in (ROOT / "damper_estimator" / "node").glob("*.py"))
    by_name = set(re.findall(r'"(\w+_msgs)/msg/\w+"', text))
    needed = ros_packages(ROOT / "damper_estimator", ROOT / "launch") | by_name
    assert {"rclpy", "launch", "sensor_msgs", "geometry_msgs"} <= needed
    assert needed <= run_time
    assert ros_packages(ROOT / "test") <= run_time | in_tests


def test_the_environment_has_what_the_project_requires():
    declared = set(re.findall(r'^        "([\w-]+)[>=<]', (ROOT / "setup.py").read_text(), re.MULTILINE))
    lines = [line for line in (ROOT / "requirements.txt").read_text().splitlines() if line and not line.startswith("#")]
    assert declared and declared <= {re.split(r"[\[>=<]", line)[0] for line in lines}
    assert all(re.search(r">=.*,<", line) for line in lines)


def test_the_parameter_file_explains_every_parameter():
    source = (ROOT / "damper_estimator" / "node" / "settings.py").read_text()
    text = (ROOT / "config" / "node.yaml").read_text()
    declared = set(re.findall(r'(?m)^    "(\w+)": Declaration\(', source))
    given = yaml.safe_load(text)["/**"]["ros__parameters"]
    assert declared and set(given) <= declared
    for name in declared:
        assert re.search(rf"(?m)^    # .*\n    (# )?{name}:", text), name


def test_make_help_lists_every_target():
    targets = re.search(r"^\.PHONY: (.*)$", (ROOT / "Makefile").read_text(), re.MULTILINE).group(1).split()
    told = run(["make", "--no-print-directory", "-C", ROOT, "help"])
    for target in targets:
        assert re.search(rf"(?m)^make {target} +\S", told), target
