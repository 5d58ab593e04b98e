"""Architecture: allowed imports between packages, ROS in one package, length of files and functions."""

import ast
import importlib
import re
import subprocess
import sys
from collections.abc import Callable, Collection
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "damper_estimator"
SOURCES = sorted(PACKAGE.rglob("*.py"))
ROOT_MODULES = {"compiled", "errors", "files", "lazy", "numbers", "share"}

# The packages that each package may import. `signals.layout` is a single module.
ALLOWED = {
    "recordings": set(),
    "signals": {"recordings"},
    "effects": {"signals.layout"},
    "model": {"effects", "signals.layout"},
    "numerics": set(),
    "identification": {"model", "runtime", "effects", "signals", "numerics"},
    "validation": {"model", "signals", "numerics"},
    "characterization": {"model", "signals"},
    "diagnosis": {"model", "signals", "effects", "numerics", "identification", "validation"},
    "planning": {"model", "signals", "effects", "numerics", "identification", "validation", "diagnosis"},
    "runtime": {"model", "signals"},
    "control": {"model", "runtime", "signals.layout"},
    "codegen": {"model", "effects", "runtime", "signals", "control"},
    "plant": set(),
    "vehicle": {"model", "runtime", "signals.layout", "plant", "control"},
    "report": {"recordings", "validation", "diagnosis", "characterization", "vehicle", "planning"},
    "workflows": {
        "recordings", "signals", "model", "identification", "validation", "characterization", "diagnosis", "control",
        "planning", "runtime", "report", "codegen", "plant", "vehicle",
    },
    # The vehicle for the simulated ride over DDS.
    "node": {"signals", "model", "runtime", "validation", "control", "recordings", "vehicle", "numerics"},
    "studio": {
        "report", "recordings", "signals", "effects", "model", "identification", "validation", "diagnosis", "workflows",
        "codegen",
    },
    "fleet": {
        "recordings", "signals", "effects", "model", "numerics", "identification", "validation", "diagnosis", "report",
        "workflows",
    },
}  # fmt: skip
ALLOWED["cli"] = set(ALLOWED) - {"node"}
# The public API consists of the workflows and the types of their arguments and results.
PUBLIC = {"workflows", "model", "signals"}
# Packages that import others, and are imported, only through ``__init__``; the rows of the sample block are public.
THROUGH_INIT = {"workflows"}
PUBLIC_MODULES = {"signals.layout"}
# Facade methods: DamperModel.to_c and to_fmu import the export only when they are called.
FACADES = {"model/damper_model.py": {"workflows"}}

ROS = {"rclpy", "launch", "launch_ros", "ament_index_python"}
ROS_MESSAGES = re.compile(r"\w+_(msgs|interfaces)$")
LONGEST_FUNCTION = 60
LONGEST_FILE = 300
# Split, because this file is searched as well.
REGISTRIES = re.compile(
    "|".join(("pypi" + r"\.org", "python" + "hosted", "registry" + r"\.npmjs", "deb" + r"\.debian"))
)


def imported(path: Path) -> set[str]:
    """Full dotted names of what a file imports, anywhere in it; ``from a import b`` gives ``a.b``."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: line {node.lineno}: relative import; name the package"
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    return names


def package_of(path: Path) -> str | None:
    """The package of a file; None for the modules of the root."""
    parts = path.relative_to(PACKAGE).parts
    return parts[0] if len(parts) > 1 else None


def forbidden_imports(path: Path) -> list[str]:
    """Imports from packages that the package of the file may not import."""
    home = package_of(path)
    inside = {name.removeprefix("damper_estimator.") for name in imported(path) if name.startswith("damper_estimator.")}
    foreign = {name for name in inside if (PACKAGE / name.split(".")[0]).is_dir() and name.split(".")[0] != home}
    allowed = (
        ALLOWED.get(home, set()) if home else {"__main__.py": {"cli"}, "__init__.py": PUBLIC}.get(path.name, set())
    )
    allowed = allowed | FACADES.get(path.relative_to(PACKAGE).as_posix(), set())
    return sorted(name for name in foreign if not any(name == a or name.startswith(f"{a}.") for a in allowed))


def private_imports(path: Path) -> list[str]:
    """Modules of other packages that the file imports without permission to bypass ``__init__``."""
    home = package_of(path)
    modules = {
        node.module.removeprefix("damper_estimator.")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("damper_estimator.")
    }
    past = {name for name in modules if "." in name and name.split(".")[0] != home} - PUBLIC_MODULES
    return sorted(name for name in past if home in THROUGH_INIT or name.split(".")[0] in THROUGH_INIT)


def violations(find: Callable[[Path], Collection[str]]) -> dict[str, Collection[str]]:
    """Results of ``find`` by file, if any."""
    return {str(path.relative_to(ROOT)): wrong for path in SOURCES if (wrong := find(path))}


def ros_imports(path: Path) -> set[str]:
    tops = {name.split(".")[0] for name in imported(path)}
    return {top for top in tops if top in ROS or ROS_MESSAGES.fullmatch(top)}


def long_functions(path: Path) -> list[str]:
    functions = [
        node for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(node, ast.FunctionDef)
    ]
    return [node.name for node in functions if node.end_lineno - node.lineno >= LONGEST_FUNCTION]


def test_files_import_only_allowed_packages():
    assert violations(forbidden_imports) == {}


def test_workflows_import_packages_and_are_imported_only_through_init():
    assert violations(private_imports) == {}


def test_a_name_that_a_lazy_package_offers_is_not_that_of_a_module_in_it():
    for package in ("damper_estimator", "damper_estimator.workflows"):
        offered = set(importlib.import_module(package).__all__)
        modules = {path.stem for path in (PACKAGE / package.partition(".")[2]).iterdir()}
        assert offered & modules == set()


def test_a_lazy_package_offers_exactly_the_names_that_type_checkers_see():
    for package in ("damper_estimator", "damper_estimator.workflows"):
        module = importlib.import_module(package)
        shown = {name for name in dir(module) if not name.startswith("_")} - set(sys.modules[package].__dict__)
        assert shown == set(module.__all__) - set(module.__dict__)
        assert all(getattr(module, name) is not None for name in module.__all__)


def test_no_verb_imports_another_verb():
    verbs = {f"cli.{path.stem}" for path in (PACKAGE / "cli").glob("*.py") if "def add_arguments(" in path.read_text()}

    def imported_verbs(path: Path) -> list[str]:
        names = (
            {name.removeprefix("damper_estimator.") for name in imported(path)} if package_of(path) == "cli" else set()
        )
        return sorted(verb for verb in verbs if any(name.startswith(f"{verb}.") for name in names))

    assert violations(imported_verbs) == {}


def test_only_the_node_imports_ros():
    assert violations(lambda path: () if package_of(path) == "node" else ros_imports(path)) == {}


def test_functions_stay_short():
    assert violations(long_functions) == {}


def test_files_stay_short():
    assert [str(path) for path in SOURCES if path.read_text(encoding="utf-8").count("\n") > LONGEST_FILE] == []


def test_every_package_is_in_the_table():
    packages = {path.parent.name for path in PACKAGE.glob("*/__init__.py")}
    assert packages <= set(ALLOWED)
    assert {path.stem for path in PACKAGE.glob("*.py")} == ROOT_MODULES | {"__init__", "__main__"}


def test_the_table_has_no_circle():
    reachable = {name: {part.split(".")[0] for part in allowed} for name, allowed in ALLOWED.items()}
    # Signals and effects share the layout of the sample block.
    reachable["effects"] = set()
    order = []
    while len(order) < len(reachable):
        free = [name for name in reachable if name not in order and reachable[name] <= set(order)]
        assert free, f"circle among {set(reachable) - set(order)}"
        order += free


def test_facade_methods_import_what_they_offer_only_when_they_are_called():
    code = "import sys, damper_estimator.model as _; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT).stdout
    assert "damper_estimator.model" in loaded.split()
    assert not {"damper_estimator.workflows", "damper_estimator.codegen"} & set(loaded.split())


def test_a_forbidden_import_is_detected(tmp_path, monkeypatch):
    for folder in ("effects", "signals", "cli"):
        (tmp_path / folder).mkdir()
    path = tmp_path / "effects" / "probe.py"
    lines = ("signals.layout import X", "signals import measure", "cli.main import main", "errors import InputError")
    path.write_text("".join(f"from damper_estimator.{line}\n" for line in lines))
    monkeypatch.setattr(sys.modules[__name__], "PACKAGE", tmp_path)
    assert forbidden_imports(path) == ["cli.main.main", "signals.measure"]


def test_no_file_names_a_package_registry():
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True)
    if listed.returncode:
        pytest.skip("not a git checkout")
    named = []
    for name in filter(None, listed.stdout.split("\0")):
        path = ROOT / name
        if path.is_file() and REGISTRIES.search(path.read_bytes().decode("utf-8", "ignore")):
            named.append(name)
    assert not named
