"""Installation by pip without ROS and by colcon as ament_python package; consistency of the files that describe it."""

import importlib
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from pathlib import Path
from zipfile import ZipFile

import pytest
import yaml

from damper_estimator import __version__
from damper_estimator.node.parameter_files import parameter_files

ROOT = Path(__file__).resolve().parents[1]
NOT_SOURCE = (
    ".git",
    ".venv*",
    "__pycache__",
    "build",
    "install",
    "log",
    "out",
    "test",
    "*.egg-info",
    ".hypothesis",
)
SCRIPTS = Path(sysconfig.get_path("scripts"))
INSTALLED = (
    "bags/hidden_fit.mcap",
    "config/models/linear_viscous.yaml",
    "config/rigs/crank.yaml",
    "config/node.yaml",
    "launch/estimator.launch.py",
    "package.xml",
    "msg_defs/msg/DamperForces.msg",
)


@pytest.fixture(scope="module")
def source(tmp_path_factory) -> Path:
    """A copy of the sources in the ``src`` of a workspace, so that building leaves nothing in the checkout."""
    folder = tmp_path_factory.mktemp("ws") / "src" / "damper_estimator"
    return Path(shutil.copytree(ROOT, folder, symlinks=True, ignore=shutil.ignore_patterns(*NOT_SOURCE)))


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
def colcon(source, tmp_path_factory) -> Callable[..., str]:
    """Runs colcon in the workspace as its user does, without options that say where packages are."""
    if not (SCRIPTS / "colcon").exists():
        assert os.environ.get("DAMPER_TEST_ROS") != "required"
        pytest.skip("colcon is not installed (make test sets it up)")
    workspace, home = source.parents[1], tmp_path_factory.mktemp("colcon_home")
    # ROS from wheels lies in the environment itself; cmake and ninja are there as well.
    variables = {
        "COLCON_HOME": str(home),
        "PATH": os.pathsep.join((str(SCRIPTS), os.environ["PATH"])),
        **{
            name: os.pathsep.join(filter(None, (sys.prefix, os.environ.get(name))))
            for name in ("AMENT_PREFIX_PATH", "CMAKE_PREFIX_PATH")
        },
    }
    return lambda *words: run([SCRIPTS / "colcon", *words], workspace, **variables)


@pytest.fixture(scope="module")
def by_colcon(source, colcon) -> Path:
    """Install folder of the estimator after a plain ``colcon build``."""
    colcon("build", "--cmake-args", "-Wno-dev", f"-DPython3_EXECUTABLE={sys.executable}")
    return source.parents[1] / "install" / "damper_estimator"


def run(command: list, folder: Path | None = None, **environment: str) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, env=os.environ | environment)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def packages_of(prefix: Path) -> Path:
    (folder,) = prefix.glob("lib/python3*/site-packages")
    return folder


def test_colcon_finds_both_packages_without_options(colcon):
    lines = [line.split("\t") for line in colcon("list").splitlines()]
    assert lines == [
        ["damper_estimator", "src/damper_estimator/ros_package", "(ros.ament_python)"],
        ["damper_msgs", "src/damper_estimator/msg_defs", "(ros.ament_cmake)"],
    ]


def test_the_link_to_the_messages_is_no_third_package(source, colcon):
    """The link that docs/packaging.md offers to tools which run rosdep by themselves."""
    packages = pytest.importorskip("catkin_pkg.packages")
    link = source.parent / "damper_msgs"
    link.symlink_to("damper_estimator/msg_defs")
    try:
        found = {path: package.name for path, package in packages.find_packages(str(source.parent)).items()}
        assert found == {"damper_estimator": "damper_estimator", "damper_msgs": "damper_msgs"}
        assert sorted(line.split("\t")[0] for line in colcon("list").splitlines()) == sorted(found)
    finally:
        link.unlink()


def test_rosdep_finds_both_packages_at_the_paths_of_the_readme(source):
    packages = pytest.importorskip("catkin_pkg.packages")
    (words,) = re.findall(r"rosdep install --from-paths (.+) --ignore-src", (ROOT / "README.md").read_text())
    workspace = source.parents[1]
    found = {
        package.name for word in words.split() for package in packages.find_packages(str(workspace / word)).values()
    }
    assert found == {"damper_estimator", "damper_msgs"}


def test_the_package_that_colcon_builds_is_the_top_level():
    links = {path.name: os.readlink(path) for path in (ROOT / "ros_package").iterdir() if path.is_symlink()}
    assert links == {name: f"../{name}" for name in links}
    assert {"package.xml", "setup.py", "setup.cfg", "pyproject.toml", "damper_estimator", "test"} <= set(links)


def test_colcon_builds_the_messages_before_the_estimator(by_colcon):
    messages = by_colcon.with_name("damper_msgs")
    assert (messages / "share/damper_msgs/msg/DamperForces.msg").is_file()
    assert "damper_msgs" in (by_colcon / "share/colcon-core/packages/damper_estimator").read_text().split(":")


@pytest.mark.parametrize("installed", ["by_pip", "by_colcon"])
def test_installed_code_finds_its_data(installed, request, tmp_path):
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
    for folder, pattern in (("bags", "*.mcap"), ("config", "*"), ("launch", "*"), ("msg_defs/msg", "*")):
        for path in (ROOT / folder).rglob(pattern):
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


def test_pip_installs_the_manual_pages(source, tmp_path):
    (source / "man").mkdir()
    (source / "man" / "damper-estimator.1").write_text(".TH DAMPER-ESTIMATOR 1\n")
    words = "-m pip wheel -qq --no-deps --no-build-isolation --no-cache-dir --disable-pip-version-check -w"
    run([sys.executable, *words.split(), tmp_path, source])
    shutil.rmtree(source / "man")
    (wheel,) = tmp_path.glob("*.whl")
    assert any(name.endswith("data/share/man/man1/damper-estimator.1") for name in ZipFile(wheel).namelist())


def test_a_wheel_can_be_built_from_the_source_distribution(source, tmp_path):
    run([sys.executable, "setup.py", "-q", "sdist", "--dist-dir", tmp_path], source)
    (archive,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(archive) as opened:
        names = {name.partition("/")[2] for name in opened.getnames()}
        opened.extractall(tmp_path / "unpacked", filter="data")
    needed = {*INSTALLED, "LICENSE", "README.md", "CHANGELOG.rst", "CITATION.cff", "setup.py", "pyproject.toml"}
    assert needed <= names
    (unpacked,) = (tmp_path / "unpacked").iterdir()
    words = "-m pip wheel -qq --no-deps --no-build-isolation --no-cache-dir --disable-pip-version-check -w"
    run([sys.executable, *words.split(), tmp_path, unpacked])
    (wheel,) = tmp_path.glob("*.whl")
    files = set(ZipFile(wheel).namelist())
    assert {path.relative_to(ROOT).as_posix() for path in (ROOT / "damper_estimator").rglob("*.py")} <= files
    assert {f"damper_estimator-{__version__}.data/data/share/damper_estimator/{name}" for name in INSTALLED} <= files


def test_without_ros_the_node_says_so_in_one_line():
    code = "import sys; sys.modules['rclpy'] = None; from damper_estimator.node.main import main; sys.exit(main())"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (1, "", 1)
    assert done.stderr.startswith("estimator_node: ROS 2 is not complete here (no module rclpy); source /opt/ros/jazzy")


def test_versions_and_names_agree():
    package = ElementTree.parse(ROOT / "package.xml").getroot()
    messages = ElementTree.parse(ROOT / "msg_defs" / "package.xml").getroot()
    assert package.findtext("version") == messages.findtext("version") == __version__
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert (citation["version"], citation["license"]) == (__version__, package.findtext("license"))
    assert (package.findtext("name"), messages.findtext("name")) == ("damper_estimator", "damper_msgs")
    assert package.findtext("license") == messages.findtext("license") == "Apache-2.0"
    for described in (package, messages):
        assert {url.get("type") for url in described.iter("url")} == {"website", "repository", "bugtracker"}
    assert "damper_msgs" in [entry.text for entry in package.iter("exec_depend")]


@pytest.mark.filterwarnings("ignore::DeprecationWarning:catkin_pkg")
@pytest.mark.parametrize("folder, name", [(".", "damper_estimator"), ("msg_defs", "damper_msgs")])
def test_bloom_can_read_the_changelog(folder, name):
    changelog = pytest.importorskip("catkin_pkg.changelog")
    pytest.importorskip("docutils")
    entries = changelog.get_changelog_from_path(str(ROOT / folder / "CHANGELOG.rst"), package_name=name)
    versions = [version for version, *_ in entries.foreach_version()]
    assert versions in ([], [__version__, *versions[1:]]), "the newest released version must be the package's"
    text = (ROOT / folder / "CHANGELOG.rst").read_text()
    assert f"Changelog for package {name}\n" in text and ("Forthcoming\n" in text or versions)


def test_rosdoc2_finds_its_settings_and_the_python_sources():
    package = ElementTree.parse(ROOT / "package.xml").getroot()
    about, settings = yaml.safe_load_all((ROOT / package.findtext("export/rosdoc2")).read_text())
    assert about == {"type": "rosdoc2 config", "version": 1}
    assert (ROOT / settings["settings"]["python_source"] / "__init__.py").is_file()


def ros_packages(*folders: Path) -> set[str]:
    """ROS packages that the Python files below import."""
    paths = [path for folder in folders for path in folder.rglob("*.py")]
    lines = re.findall(r"(?m)^\s*(?:from|import) (\w+)", "\n".join(path.read_text(encoding="utf-8") for path in paths))
    ros = {"rclpy", "launch", "launch_ros", "ament_index_python"}
    return {name for name in lines if name in ros or re.fullmatch(r"\w+_(msgs|interfaces)", name)}


def test_package_xml_names_every_ros_package_that_is_imported():
    package = ElementTree.parse(ROOT / "package.xml").getroot()
    run_time, in_tests = ({entry.text for entry in package.iter(f"{kind}_depend")} for kind in ("exec", "test"))
    # The node makes message types by name; those are in its source as text.
    text = "\n".join(path.read_text(encoding="utf-8") for path in (ROOT / "damper_estimator" / "node").rglob("*.py"))
    by_name = set(re.findall(r'"(\w+_msgs)/msg/\w+"', text))
    needed = ros_packages(ROOT / "damper_estimator", ROOT / "launch") | by_name
    assert {"rclpy", "launch", "sensor_msgs", "geometry_msgs"} <= needed
    assert needed <= run_time
    assert ros_packages(ROOT / "test") <= run_time | in_tests


def test_the_environment_meets_the_requirements():
    declared = set(re.findall(r'"([\w-]+)>=\d', (ROOT / "setup.py").read_text()))
    lines = [line for line in (ROOT / "requirements.txt").read_text().splitlines() if line and not line.startswith("#")]
    assert declared and declared <= {re.split(r"[\[>=<]", line)[0] for line in lines}
    assert all(re.search(r">=.*,<", line) for line in lines)


@pytest.mark.parametrize(
    "file, settings, node",
    [("node", "settings", "/**"), ("controller", "controller_settings", "/**/damper_controller")],
)
def test_the_parameter_files_explain_every_parameter(file, settings, node):
    declared = importlib.import_module(f"damper_estimator.node.{settings}").DECLARATIONS
    text = (ROOT / "config" / f"{file}.yaml").read_text()
    given = yaml.safe_load(text)[node]["ros__parameters"]
    defaults = {name: declaration.default for name, declaration in declared.items()}
    assert given == {name: list(value) if isinstance(value, tuple) else value for name, value in defaults.items()}
    for name, declaration in declared.items():
        assert len(declaration.explanation) > 20 and re.search(rf"(?m)^    # .*\n    {name}:", text), name


@pytest.mark.parametrize("file", ["node.yaml", "controller.yaml"])
def test_the_parameter_files_are_those_made_from_the_declarations(file):
    remedy = "run python -m damper_estimator.node.parameter_files config"
    assert (ROOT / "config" / file).read_text() == parameter_files()[file], remedy


def test_make_help_lists_every_target():
    targets = re.search(r"^\.PHONY: (.*)$", (ROOT / "Makefile").read_text(), re.MULTILINE).group(1).split()
    listed = run(["make", "--no-print-directory", "-C", ROOT, "help"])
    for target in targets:
        assert re.search(rf"(?m)^make {target} +\S", listed), target


@pytest.mark.parametrize(
    "path", sorted((*(ROOT / ".github").rglob("*.yml"), ROOT / ".pre-commit-config.yaml")), ids=lambda path: path.name
)
def test_the_files_for_code_hosts_are_valid_and_name_existing_commands(path):
    content = yaml.safe_load(path.read_text())
    if path.parent.name == "ISSUE_TEMPLATE" and path.stem != "config":
        assert content["name"] and content["description"]
        assert all(field["attributes"]["label"] for field in content["body"])
    for command in re.findall(r"(?m)^\s*- run: (\.\S+)$", path.read_text()):
        assert os.access(ROOT / command, os.X_OK), command
    for script in re.findall(r"pytest -q (\S+)$", path.read_text(), re.MULTILINE):
        assert (ROOT / script).is_file(), script
