"""doctor: every part is checked, missing parts are reported with their purpose, the exit status is 0."""

import json
import os
import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from damper_estimator.cli import doctor_checks
from damper_estimator.cli.doctor import table
from damper_estimator.cli.main import main

ROOT = Path(__file__).resolve().parents[2]


def record(capsys) -> dict:
    assert main(["doctor", "--json", "-"]) == 0
    return json.loads(capsys.readouterr().out)


def piece(found: dict, name: str) -> dict:
    (only,) = (check for check in found["checks"] if check["name"] == name and check["group"] != "programs")
    return only


def test_every_package_that_the_project_requires_is_checked():
    text = (ROOT / "setup.py").read_text()
    required = set(re.findall(r'"([\w-]+)>=', text.partition('"test": [')[0]))
    assert required <= {distribution for distribution, *_ in doctor_checks.PACKAGES}


def test_the_table_names_every_piece_and_the_record_holds_the_same(capsys):
    found = record(capsys)
    assert main(["doctor"]) == 0
    shown = capsys.readouterr().out
    assert all(check["name"] in shown for check in found["checks"])
    assert piece(found, "numpy")["state"] == "ok" and piece(found, "Python")["state"] == "ok"


def test_a_missing_package_is_named_with_the_verb_that_needs_it(monkeypatch, capsys):
    monkeypatch.setattr(doctor_checks, "find_spec", lambda name: None if name == "dash" else find_spec(name))
    found = record(capsys)
    assert piece(found, "dash")["state"] == "missing"
    assert piece(found, "dash")["remedy"] == "pip install 'damper_estimator[studio]'"
    assert "dash" in found["unavailable"]["studio"]


def test_a_ros_module_that_cannot_be_loaded_is_a_problem_and_no_traceback(monkeypatch, tmp_path, capsys):
    (tmp_path / "rclpy").mkdir()
    (tmp_path / "rclpy" / "__init__.py").write_text("raise ImportError('built for another Python')\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "rclpy", raising=False)
    check = piece(record(capsys), "rclpy")
    assert check["state"] == "problem" and "built for another Python" in check["found"]


def test_missing_programs_are_reported_with_their_purpose(monkeypatch, tmp_path, capsys):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    found = record(capsys)
    assert "C compiler" in found["unavailable"]["export --fmu"]
    assert any("browser" in names for names in found["unavailable"].values())


def test_missing_numba_is_reported(monkeypatch, capsys):
    monkeypatch.setattr("damper_estimator.compiled.COMPILED", False)
    assert piece(record(capsys), "compilation")["state"] == "missing"


def test_kernels_that_cannot_be_stored_are_a_problem(monkeypatch, capsys):
    pytest.importorskip("numba")
    monkeypatch.setattr("damper_estimator.compiled.COMPILED", True)
    monkeypatch.setattr("damper_estimator.compiled.machine_code_folders", list)
    assert piece(record(capsys), "cache")["state"] == "problem"


def test_a_complete_installation_is_reported_as_such():
    whole = [doctor_checks.Check("packages", "numpy", doctor_checks.OK, "2.0")]
    assert table(whole).endswith("everything is available")


def test_after_warm_no_verb_compiles_anything(tmp_path):
    pytest.importorskip("numba")
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "kernels")}

    def call(*words: str) -> set[Path]:
        """Runs a verb; returns the stored machine code."""
        command = [sys.executable, "-m", "damper_estimator", *words]
        subprocess.run(command, check=True, capture_output=True, env=environment, cwd=tmp_path)
        return set((tmp_path / "kernels").rglob("*.nbc"))

    bag, model = str(ROOT / "bags" / "hidden_unseen.mcap"), "renault_modified_bouc_wen"
    stored = call("doctor", "--warm")
    assert stored
    assert call("compare", bag, "-m", model) == stored
    assert call("compare", bag, "-m", "mr_damper_on_mount") == stored
    assert call("replay", bag, "-m", model, "-o", "replayed.mcap") == stored
