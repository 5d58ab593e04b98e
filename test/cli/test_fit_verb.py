"""`fit` from a bag to a model file."""

import json

import numpy as np
import pytest
import yaml

from damper_estimator.cli.main import main
from damper_estimator.model import load_model
from damper_estimator.recordings import BagWriter
from damper_estimator.signals.kinematics import differentiate_recording

RATE = 200.0


@pytest.fixture
def bag(tmp_path):
    """Writes a recording of dampers that are models; the force of a damper without a model is not recorded."""

    def write(name, seconds=8.0, seed=0, **models):
        random = np.random.default_rng(seed)
        stamp = np.round(np.arange(int(seconds * RATE)) / RATE * 1e9).astype(np.int64) + 1_700_000_000_000_000_000
        position, effort, measured = [], [], []
        for damper, model in models.items():
            t = np.arange(stamp.size) / RATE
            x = sum(0.02 / f * np.sin(2 * np.pi * f * t + random.uniform(0.0, 6.0)) for f in (0.7, 1.3, 2.9, 5.3))
            position.append(x)
            if model is not None:
                # The gauge sees the force before the filter: without one, velocity is the difference.
                kinematics, _ = differentiate_recording(stamp, x, 200.0, 0.1)
                effort.append(model.force(kinematics.block) + random.standard_normal(x.size))
                measured.append(damper)
        path = tmp_path / f"{name}.mcap"
        with BagWriter(path) as writer:
            kind = "sensor_msgs/msg/JointState"
            fields = {"header.stamp": stamp, "name": list(models), "position": np.array(position).T}
            writer.write_columns("/suspension/displacement", kind, stamp, fields)
            if measured:
                fields = {"header.stamp": stamp, "name": measured, "effort": np.array(effort).T}
                writer.write_columns("/suspension/force", kind, stamp, fields)
        return str(path)

    return write


@pytest.fixture
def damper():
    return load_model("linear_viscous").with_values(
        {"linear_viscous.rebound": 3100.0, "linear_viscous.compression": 1300.0, "static_force.force": -150.0}
    )


def identified(path):
    return {slot.address: slot.value for slot in load_model(path).slots}


def test_a_bag_becomes_a_fitted_model_file(bag, damper, tmp_path, capsys):
    out = tmp_path / "fitted.yaml"
    assert (
        main(["fit", bag("one", left=damper), bag("two", left=damper, seed=1), "-m", "linear_viscous", "-o", str(out)])
        == 0
    )
    assert identified(out)["linear_viscous.rebound"] == pytest.approx(3100.0, rel=0.02)
    assert identified(out)["static_force.force"] == pytest.approx(-150.0, abs=5.0)
    record = yaml.safe_load(out.read_text())["fit"]
    assert (
        len(record["bags"]) == 2
        and record["residual_stddev"] > 0.0
        and set(record["standard_errors"]) == set(identified(out))
    )
    text = capsys.readouterr().out
    assert "linear_viscous.rebound" in text and "±" in text and "ESR" in text and "N s/m" in text


def test_json_has_the_documented_keys(bag, damper, tmp_path, capsys):
    out = tmp_path / "fitted.yaml"
    assert main(["fit", bag("one", left=damper), "-m", "linear_viscous", "-o", str(out), "--json", "-"]) == 0
    record = json.loads(capsys.readouterr().out)["dampers"]["left"]
    assert {"rmse_n", "esr", "parameters", "seconds", "evaluations"} <= set(record)
    assert set(record["parameters"][0]) == {"name", "value", "standard_error", "unit", "at_bound"}
    assert {p["name"]: p["value"] for p in record["parameters"]} == pytest.approx(identified(out))
    assert record["rmse_n"] < record["rmse_before_n"]


def test_several_dampers_go_into_a_folder(bag, damper, tmp_path):
    softer = damper.with_values({"linear_viscous.rebound": 900.0})
    assert (
        main(["fit", bag("both", left=damper, right=softer), "-m", "linear_viscous", "-o", str(tmp_path / "models")])
        == 0
    )
    assert identified(tmp_path / "models" / "left.yaml")["linear_viscous.rebound"] == pytest.approx(3100.0, rel=0.02)
    assert identified(tmp_path / "models" / "right.yaml")["linear_viscous.rebound"] == pytest.approx(900.0, rel=0.02)


def test_a_damper_without_force_is_left_out_unless_it_is_requested(bag, damper, tmp_path, capsys):
    path = bag("half", left=damper, right=None)
    assert main(["fit", path, "-m", "linear_viscous", "-o", str(tmp_path / "left.yaml")]) == 0
    assert "right was not measured" in capsys.readouterr().err
    assert main(["fit", path, "-m", "linear_viscous", "-o", str(tmp_path / "right.yaml"), "-d", "right"]) == 1
    assert not (tmp_path / "right.yaml").exists()


def test_parameters_are_fixed_and_freed_by_name(bag, damper, tmp_path):
    out = tmp_path / "fitted.yaml"
    words = [
        "fit",
        bag("one", left=damper),
        "-m",
        "linear_viscous",
        "-o",
        str(out),
        "--fix",
        "*",
        "--free",
        "static_force",
    ]
    assert main(words) == 0
    assert identified(out)["linear_viscous.rebound"] == 2000.0 and identified(out)["static_force.force"] != 0.0


def test_a_window_is_taken_from_the_recording(bag, damper, tmp_path, capsys):
    words = [
        "fit",
        bag("one", left=damper),
        "-m",
        "linear_viscous",
        "-o",
        str(tmp_path / "a.yaml"),
        "--from",
        "2",
        "--to",
        "5",
        "--json",
        "-",
    ]
    assert main(words) == 0
    assert json.loads(capsys.readouterr().out)["dampers"]["left"]["samples"] == pytest.approx(2.8 * RATE, abs=3)


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["-m", "nonsense"], "nonsense"),
        (["-m", "linear_viscous", "--method", "guessing"], "least_squares"),
        (["-m", "linear_viscous", "--fix", "*"], "all its parameters are fixed"),
        (["-m", "linear_viscous", "--free", "mass"], "mass"),
        (["-m", "linear_viscous", "-d", "rear"], "rear"),
        (["-m", "linear_viscous", "--from", "7.9"], "judged"),
    ],
)
def test_what_is_refused_leaves_the_old_file_as_it_was(words, reason, bag, damper, tmp_path, capsys):
    out = tmp_path / "fitted.yaml"
    out.write_text("old")
    assert main(["fit", bag("one", left=damper), "-o", str(out), *words]) == 1
    error = capsys.readouterr().err.strip().splitlines()[-1]
    assert reason in error and out.read_text() == "old"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["fitted.yaml", "one.mcap"]


def test_a_recording_without_any_force_is_refused(bag, tmp_path, capsys):
    assert main(["fit", bag("none", left=None), "-m", "linear_viscous", "-o", str(tmp_path / "x.yaml")]) == 1
    assert "no damper has a measured force" in capsys.readouterr().err


def test_several_dampers_do_not_fit_into_one_file(bag, damper, tmp_path, capsys):
    assert (
        main(["fit", bag("both", left=damper, right=damper), "-m", "linear_viscous", "-o", str(tmp_path / "x.yaml")])
        == 1
    )
    assert "folder" in capsys.readouterr().err and not (tmp_path / "x.yaml").exists()


def test_a_model_in_a_folder_that_is_missing_is_not_written(bag, damper, tmp_path, capsys):
    target = tmp_path / "file"
    target.write_text("no folder")
    assert main(["fit", bag("one", left=damper), "-m", "linear_viscous", "-o", str(target / "x.yaml")]) == 1
    assert len(capsys.readouterr().err.strip().splitlines()) <= 2


def test_a_real_damper_is_identified_and_agrees_on_another_file(shared_data, tmp_path, capsys):
    """Magneto-rheological damper at 0.5 A: fitted to 5 mm at 3 Hz, judged on 10 mm at 2 Hz."""
    files = [str(shared_data / "utfsm_mr_damper" / f"ME{name}.txt.gz") for name in ("5mm3Hz", "10mm2Hz")]
    assert main(["import", *files, "--columns", "utfsm_mr_damper", "-o", str(tmp_path)]) == 0
    out, unseen = str(tmp_path / "fitted.yaml"), str(tmp_path / "ME10mm2Hz_0.5A.mcap")
    assert main(["fit", str(tmp_path / "ME5mm3Hz_0.5A.mcap"), "-m", "memoryless_baseline", "-o", out]) == 0
    assert 400.0 < identified(out)["tanh_hysteresis.force"] < 1000.0
    capsys.readouterr()
    assert main(["compare", unseen, "-m", out, "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["dampers"]["mr_damper"]["esr"] < 0.05


def test_a_recording_that_means_nothing_is_reported(bag, damper, tmp_path, capsys):
    """Fitted to kilonewtons, a damper is a thousand times too soft."""
    soft = {"linear_viscous.rebound": 3.1, "linear_viscous.compression": 1.3, "static_force.force": 0.0}
    path = bag("kilonewtons", front=damper.with_values(soft))
    assert main(["fit", path, "-m", "linear_viscous", "-o", str(tmp_path / "f.yaml")]) == 0
    warning = capsys.readouterr().err
    assert "kilonewtons.mcap: front:" in warning and "probably it is in kN" in warning and "scale: 1000" in warning
