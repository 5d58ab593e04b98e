"""The node runs with the few packages that package.xml and the README name, without those of the offline tools."""

import ast
import os
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def not_needed() -> set[str]:
    """The packages in setup.py besides those of the node and of the tests; all are imported by their names."""
    lists = {
        node.targets[0].id: ast.literal_eval(node.value)
        for node in ast.parse((ROOT / "setup.py").read_text(encoding="utf-8")).body
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.List | ast.Dict)
    }
    others = [
        *lists["OFFLINE"],
        *(line for extra in lists["EXTRAS"] if extra != "test" for line in lists["EXTRAS"][extra]),
    ]
    return {re.split("[>=<]", line)[0] for line in others}


@pytest.fixture
def slim(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Child processes do not find packages that the node does not need."""
    folder = tmp_path / "missing"
    folder.mkdir()
    for name in not_needed():
        text = f"raise ModuleNotFoundError(\"No module named '{name}'\", name={name!r})\n"
        (folder / f"{name}.py").write_text(text)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, (str(folder), os.environ.get("PYTHONPATH")))))


def test_it_estimates_without_the_packages_of_the_offline_tools(slim, start, rig):
    process = start(model="carrera_akutain", dampers="[left]")
    rig.ready()
    assert len(rig.drive(20)) == 20
    assert process.poll() is None


def test_recording_without_its_package_is_refused_in_one_line(slim, start, tmp_path):
    process = start(model="coulomb", record=tmp_path / "bags")
    _, said = process.communicate(timeout=120.0)
    assert process.returncode == 1
    (line,) = (line for line in said.splitlines() if line.startswith("estimator_node:"))
    assert "parameter record: the Python package mcap is not installed; install it (pip install mcap)" in line
