"""The examples of docs/export.md work as printed."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from c_runner import python_line

from damper_estimator.cli.main import main
from damper_estimator.codegen import Choices, damper_of
from damper_estimator.codegen.build import find_compiler
from damper_estimator.codegen.compiled_damper import inputs
from damper_estimator.model import load_model

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler is installed")
TEXT = (Path(__file__).parents[2] / "docs" / "export.md").read_text(encoding="utf-8")


def shown(language: str, part: str) -> str:
    return next(block for block in re.findall(rf"```{language}\n(.*?)```", TEXT, re.DOTALL) if part in block)


def test_the_program_in_c_prints_the_forces_of_the_line(tmp_path):
    program = shown("c", "int main")
    assert program.count("\n") <= 40
    (tmp_path / "forces.c").write_text(program)
    assert main(["export", "carrera_akutain", "--c", str(tmp_path), "--name", "front_left"]) == 0
    (command,) = re.findall(r"^    (cc .*) &&", TEXT, re.MULTILINE)
    subprocess.run(command.replace("cc", find_compiler(), 1), shell=True, cwd=tmp_path, check=True)
    time = np.arange(500) * 1e-3
    x = 0.02 * np.sin(20.0 * time)
    rows = "\n".join(f"{t:.6f},{d:.17g}" for t, d in zip(time, x, strict=True))
    (tmp_path / "road.csv").write_text(f"time,displacement\n{rows}\n")
    output = subprocess.run(["./forces", "road.csv"], cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    found = np.array([[float(cell) for cell in line.split(",")] for line in output.split()])
    answered = python_line(damper_of(load_model("carrera_akutain"), Choices())[0], inputs(np.arange(500) * 10**6, x))
    assert np.array_equal(found[:, 1], answered.numbers[:, 3, 0])
    assert np.array_equal(found[:, 2], answered.status[:, 0])


def test_the_quarter_car_settles_on_the_step(tmp_path):
    pytest.importorskip("fmpy", reason="FMPy is not installed")
    assert main(["export", "dahl", "--fmu", str(tmp_path / "front_left.fmu"), "--name", "front_left"]) == 0
    (tmp_path / "quarter_car.py").write_text(shown("python", "FMU2Slave"))
    output = subprocess.run(
        [sys.executable, "quarter_car.py"], cwd=tmp_path, capture_output=True, text=True, check=True
    ).stdout
    height, highest = map(float, re.findall(r"(-?[\d.]+) m", output))
    assert 0.0 < height < 0.06 and 0.02 < highest < 0.09
