"""The notebooks run from the first to the last cell, and their results agree with their text."""

import importlib.util

import pytest
from pages import ROOT

FOLDER = ROOT / "docs" / "notebooks"
NAMES = sorted(path.stem for path in FOLDER.glob("*.py"))


def run(name):
    """The names that a notebook defines."""
    path = FOLDER / f"{name}.py"
    names = {"__name__": "notebook"}
    exec(compile(path.read_text(encoding="utf-8"), str(path), "exec"), names)
    return names


def test_there_is_one_for_each_subject():
    assert NAMES == ["bench_file", "export", "fleet", "hidden_effect", "mr_damper"]


def test_the_hidden_effect_is_found():
    names = run("hidden_effect")
    assert names["found"].verdict == "missing"
    named = {name for one in names["found"].findings for name in (one.phenomenon, *one.tied_with)}
    assert "oil_compressibility" in named
    assert names["after"].rmse_n < 0.5 * names["before"].rmse_n


def test_the_friction_of_the_bench_file_is_found():
    names = run("bench_file")
    assert names["better"].steps[-1].phenomenon == "friction"
    values = [slot.value for slot in names["better"].model.slots if slot.address.endswith(".force")]
    assert any(value == pytest.approx(60.0, rel=0.1) for value in values)


def test_a_model_that_knows_the_current_is_better():
    names = run("mr_damper")
    error = {model.name: names["de"].compare(names["road"], model).rmse_n for model in (names["blind"], names["model"])}
    assert error["semi_active_yield"] < 0.5 * error["linear_viscous"]
    answer = names["answer"]
    assert 0.0 < answer.current < 2.0 and answer.force_min < 800.0 < answer.force_max


def test_the_car_that_changed_stands_out():
    names = run("fleet")
    assert names["outlier"] == "car_3"
    before, after = (
        next(slot.value for slot in model.slots if slot.address == "dahl.force")
        for model in (names["model"], names["again"].model)
    )
    assert after > 3.0 * before  # 20 N became 80 N; Dahl's form is not quite that of the simulation


def test_the_fmu_gives_the_forces_of_the_python_line():
    if importlib.util.find_spec("fmpy") is None:
        pytest.skip("fmpy is not installed")
    names = run("export")
    if not names["binary"]:
        pytest.skip("there is no C compiler")
    assert names["difference"] < 1e-6
