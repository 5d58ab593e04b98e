"""Figures of the code base for one or several git revisions, as a Markdown table.

    python benchmarks/code_figures.py                        # this checkout
    python benchmarks/code_figures.py REVISION HEAD          # two revisions side by side
    python benchmarks/code_figures.py --paths REVISION HEAD  # also the paths of a sample and of a recording; minutes

The paths are recorded by a profile hook. A live sample runs with ``NUMBA_DISABLE_JIT=1``, so that kernels count as
functions; a diagnosis runs compiled, so that kernels are not counted.
"""

import argparse
import ast
import io
import json
import os
import subprocess
import sys
import tarfile
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = "damper_estimator"
BLOCK = 6  # equal lines that count as a duplicate
BAG, MODEL = "bags/hidden_fit.mcap", "viscous_curve"

_PROFILE = """
import json, os, sys
# An editable installation would supply modules of the checkout that a revision lacks.
sys.meta_path[:] = [finder for finder in sys.meta_path if "editable" not in repr(finder).lower()]
passed, package = set(), os.path.join(os.getcwd(), "damper_estimator", "")
def note(frame, event, argument):
    code = frame.f_code
    if event == "call" and code.co_filename.startswith(package) and not code.co_name.startswith("<"):
        passed.add((code.co_filename[len(package):], code.co_qualname))
def traced(function, *arguments):
    sys.setprofile(note)
    try:
        return function(*arguments)
    finally:
        sys.setprofile(None)
"""
_SAMPLE = """
import numpy as np
from damper_estimator.model import load_model
try:
    from damper_estimator.runtime import DamperEstimator, Line, deployed
    estimator = DamperEstimator(deployed(load_model(MODEL), 60.0, 0.1))
except ModuleNotFoundError:
    from damper_estimator.model.estimator import DamperEstimator, deployed
    from damper_estimator.model.live_line import LiveLine as Line
    estimator = DamperEstimator(load_model(MODEL), 60.0, 0.1)
line = Line()
line.add("damper", deployed(load_model(MODEL), 60.0, 0.1))
step = lambda k: line.step(10**18 + 2_000_000 * k, np.full(1, 1e-4 * k), np.ones(1, bool))
step(0)
traced(step, 1)
live = sorted(passed)
traced(lambda: estimator.block(10**18 + 2_000_000 * np.arange(50), 1e-4 * np.arange(50.0)))
print(json.dumps({"live": live, "live or replayed": sorted(passed)}))
"""
_DIAGNOSIS = """
from damper_estimator.cli.main import main
words = ["diagnose", BAG, "-m", MODEL, "--to", "12", "--workers", "1", "--json", os.devnull]
sys.stdout, shown = open(os.devnull, "w"), sys.stdout
assert traced(main, words) == 0
print(json.dumps({"diagnosis": sorted(passed)}), file=shown)
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("revisions", metavar="REVISION", nargs="*", help="git revisions (default: this checkout)")
    parser.add_argument("--paths", action="store_true", help="also record the paths of a sample and of a recording")
    arguments = parser.parse_args()
    columns: dict[str, dict[str, object]] = {}
    for revision in arguments.revisions or [""]:
        with tempfile.TemporaryDirectory() as scratch:
            folder = _exported(revision, Path(scratch)) if revision else ROOT
            columns[revision or "checkout"] = figures(folder) | (paths(folder) if arguments.paths else {})
    print(table(columns))


def _exported(revision: str, folder: Path) -> Path:
    """The files of a revision in a folder."""
    archive = subprocess.run(["git", "archive", revision], cwd=ROOT, capture_output=True, check=True).stdout
    with tarfile.open(fileobj=io.BytesIO(archive)) as files:
        files.extractall(folder, filter="data")
    return folder


def figures(root: Path) -> dict[str, object]:
    """Sizes, names, imports and duplicates of the sources below a folder."""
    sources, tests = sorted((root / PACKAGE).rglob("*.py")), sorted((root / "test").rglob("*.py"))
    names = Counter(path.name for path in sources if path.name != "__init__.py")
    functions = [node for path in sources for node in ast.walk(_tree(path)) if isinstance(node, ast.FunctionDef)]
    return {
        "files of the package": len(sources),
        "lines of the package": sum(map(_lines, sources)),
        "longest file, lines": max(map(_lines, sources)),
        "files of the tests": len(tests),
        "lines of the tests": sum(map(_lines, tests)),
        "repeated file names": sum(count > 1 for count in names.values()),
        "longest function, lines": max(node.end_lineno - node.lineno + 1 for node in functions),
        "longest parameter list": max(map(_parameters, functions)),
        "packages": sum(path.is_dir() and path.name != "__pycache__" for path in (root / PACKAGE).iterdir()),
        "imports between packages": len({edge for path in sources for edge in _edges(path, root / PACKAGE)}),
        f"lines in repeated blocks of {BLOCK} and more": _repeated_lines(sources),
    }


def paths(root: Path) -> dict[str, object]:
    """Functions and files that a live sample, a replayed block and a diagnosis pass."""
    passed = _run(root, _SAMPLE, {"NUMBA_DISABLE_JIT": "1"}) | _run(root, _DIAGNOSIS, {})
    titles = {
        "live": "a live sample",
        "live or replayed": "a live or replayed sample",
        "diagnosis": "a recording to a finding",
    }
    found: dict[str, object] = {}
    for key, title in titles.items():
        found[f"{title}: functions"] = len(passed[key])
        found[f"{title}: files"] = len({file for file, _ in passed[key]})
    return found


def _run(root: Path, script: str, environment: dict[str, str]) -> dict[str, list]:
    """Runs a script with the package of a folder; returns the JSON that it prints."""
    constants = f"BAG, MODEL = {str(ROOT / BAG)!r}, {MODEL!r}\n"
    call = [sys.executable, "-c", constants + _PROFILE + script]
    variables = os.environ | {"PYTHONPATH": str(root)} | environment
    done = subprocess.run(call, cwd=root, env=variables, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(done.stderr)
    return json.loads(done.stdout)


def table(columns: dict[str, dict[str, object]]) -> str:
    """The figures as Markdown, a column for each revision."""
    rows = [["", *columns], ["---", *("---:" for _ in columns)]]
    rows += [[name, *(str(column[name]) for column in columns.values())] for name in next(iter(columns.values()))]
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def _lines(path: Path) -> int:
    return path.read_text(encoding="utf-8").count("\n")


def _tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def _parameters(function: ast.FunctionDef) -> int:
    arguments = function.args
    names = [argument.arg for argument in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs)]
    return len(names) - (names[:1] in (["self"], ["cls"]))


def _edges(path: Path, package: Path) -> Iterator[tuple[str, str]]:
    """Pairs of packages of which the file's imports from the other."""
    home = path.relative_to(package).parts[0]
    for node in ast.walk(_tree(path)):
        modules = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
        modules += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        for parts in (module.split(".") for module in modules):
            is_foreign = len(parts) > 1 and parts[0] == PACKAGE and parts[1] != home
            if is_foreign and (package / home).is_dir() and (package / parts[1]).is_dir():
                yield home, parts[1]


def _repeated_lines(sources: Sequence[Path]) -> int:
    """Lines inside blocks of at least ``BLOCK`` equal lines of code that occur more than once."""
    codes = [_code(path) for path in sources]
    blocks = Counter(tuple(code[i : i + BLOCK]) for code in codes for i in range(len(code) - BLOCK + 1))
    repeated = 0
    for code in codes:
        inside = set()
        for i in range(len(code) - BLOCK + 1):
            if blocks[tuple(code[i : i + BLOCK])] > 1:
                inside |= set(range(i, i + BLOCK))
        repeated += len(inside)
    return repeated


def _code(path: Path) -> list[str]:
    """Lines of code without blank lines, comments, docstrings and imports."""
    tree, left_out = _tree(path), set()
    for node in ast.walk(tree):
        is_text = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        if is_text or isinstance(node, (ast.Import, ast.ImportFrom)):
            left_out |= set(range(node.lineno, node.end_lineno + 1))
    lines = (line.strip() for n, line in enumerate(path.read_text().splitlines(), 1) if n not in left_out)
    return [line for line in lines if line and not line.startswith("#")]


if __name__ == "__main__":
    main()
