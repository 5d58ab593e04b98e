"""A tie from the recordings to the files: what is planned separates, and a diagnosis of both recordings says so."""

import json
from dataclasses import replace

import numpy as np
import pytest
import yaml
from simple_damper import gas, measured

import damper_estimator as de
from damper_estimator.cli.main import main
from damper_estimator.planning import acceleration_of, drive_csv, load_rig, parse_rig, plan, speed_of

TIED = ("gas_spring", "spring_rate_error")


@pytest.fixture(scope="module")
def rig():
    return replace(load_rig("servo_hydraulic"), travel=(-0.02, 0.02))


@pytest.fixture(scope="module")
def found(fitted, old, rig):
    return plan(fitted, old.measurements["damper"], TIED, rig, minutes=1.0)


def test_the_drive_obeys_the_limits_and_rests_at_both_ends(found):
    x, limits = found.displacement, found.limits
    assert limits.low <= x.min() and x.max() <= limits.high
    assert np.abs(speed_of(x, limits.rate)).max() <= limits.speed
    assert np.abs(acceleration_of(x, limits.rate)).max() <= limits.acceleration
    assert np.ptp(x[: round(limits.rate)]) == 0.0 and np.ptp(x[-round(0.9 * limits.rate) :]) == 0.0
    assert found.minutes <= 1.0 + 1e-6


def test_the_prediction_is_a_probability_and_grows_with_the_test(found):
    assert all(0.0 <= wrong <= 1.0 - right <= 1.0 for _, right, wrong in found.chances.by_truth)
    assert found.curve.minutes.size and (np.diff(found.curve.minutes) > 0.0).all()
    assert found.curve.right[-1] == pytest.approx(found.chances.right)


def test_the_planned_test_decides_rightly_with_the_old_recording(fitted, old, rig):
    found = plan(fitted, old.measurements["damper"], TIED, rig)
    assert found.separates, found.sentence
    rate = found.limits.rate
    time = np.arange(found.displacement.size) / rate
    new = measured(time, found.displacement, gas, np.random.default_rng(9), "new")
    both = de.Recording(
        (*old.sources, *new.sources),
        old.signal_map,
        {"damper": (*old.measurements["damper"], *new.measurements["damper"])},
    )
    decided = de.diagnose(both, fitted)
    first = decided.findings[0]
    assert first.phenomenon == "gas_spring" and "spring_rate_error" not in first.tied_with


def test_a_test_of_parameters_lowers_their_standard_errors(fitted, old, rig):
    found = plan(fitted, old.measurements["damper"], (), rig, minutes=0.5)
    assert found.chances is None and found.parameters
    assert all(0.0 < parameter.after < parameter.before for parameter in found.parameters)


def test_one_phenomenon_is_no_tie(fitted, old, rig):
    with pytest.raises(de.InputError, match="two phenomena"):
        plan(fitted, old.measurements["damper"], ("gas_spring",), rig)


@pytest.mark.parametrize("minutes", [0.0, 1e4, float("nan")])
def test_a_length_that_cannot_be_is_refused(fitted, old, rig, minutes):
    with pytest.raises(de.InputError, match="minutes"):
        plan(fitted, old.measurements["damper"], TIED, rig, minutes=minutes)


def test_a_rig_that_may_not_push_is_refused(fitted, old):
    weak = parse_rig(
        {"name": "weak", "source": "test", "kind": "played", "rate": 500.0, "displacement": [-0.05, 0.05], "speed": 1.0,
         "acceleration": 100.0, "force": 0.001, "frequency": [0.1, 20.0]}, "weak.yaml",
    )  # fmt: skip
    with pytest.raises(de.InputError, match="no step obeys its limits"):
        plan(fitted, old.measurements["damper"], TIED, weak, minutes=1.0)


def diagnosis(path, groups):
    findings = [{"phenomenon": group[0], "tied_with": list(group[1:])} for group in groups]
    path.write_text(json.dumps({"dampers": {"damper": {"findings": findings}}}))
    return path


def test_the_files_are_written_and_agree(fitted, old, tmp_path):
    file = diagnosis(tmp_path / "d.json", [TIED])
    results = de.plan(old, fitted, diagnosis=file, minutes=0.5)
    folder = results.save(tmp_path / "drive")
    rows = np.loadtxt(folder / "drive.csv", delimiter=",", skiprows=1)
    written = yaml.safe_load((folder / "plan.yaml").read_text())
    assert rows.shape == (results.plan.displacement.size, 2)
    assert rows[:, 1] == pytest.approx(results.plan.displacement, abs=1e-9)
    assert next(hypothesis["phenomenon"] for hypothesis in written["hypotheses"]) == "gas_spring"
    assert set(written["predicted"]) >= {"right", "wrong", "stays_tied"}
    assert len(written["steps"]) == len(results.plan.steps)
    page = (folder / "plan.html").read_text()
    assert results.sentence in page and "gas spring" in page
    assert sorted(path.name for path in folder.iterdir()) == ["drive.csv", "plan.html", "plan.yaml"]


def test_a_vehicle_gets_words_and_no_drive_file(fitted, old, tmp_path):
    results = de.plan(old, fitted, diagnosis=diagnosis(tmp_path / "d.json", [TIED]), rig="track", minutes=1.0)
    folder = results.save(tmp_path / "drive")
    assert not (folder / "drive.csv").exists()
    assert "km/h" in (folder / "plan.yaml").read_text() or "car park" in (folder / "plan.yaml").read_text()


@pytest.mark.parametrize(
    ("content", "said"),
    [("[]", "is not a diagnosis"), ("{", "is not a diagnosis"), ('{"dampers": {}}', "has no damper")],
)
def test_a_diagnosis_that_cannot_be_used_is_refused(fitted, old, tmp_path, content, said):
    path = tmp_path / "d.json"
    path.write_text(content)
    with pytest.raises(de.InputError, match=said):
        de.plan(old, fitted, diagnosis=path)


def test_without_a_tie_there_is_nothing_to_plan(fitted, old, tmp_path):
    file = diagnosis(tmp_path / "d.json", [("gas_spring",)])
    with pytest.raises(de.InputError, match="no damper has tied findings"):
        de.plan(old, fitted, diagnosis=file)


def test_a_set_current_stands_in_the_drive_file(found):
    steps = tuple(replace(step, current=0.5 * k) for k, step in enumerate(found.steps))
    lines = drive_csv(replace(found, steps=steps)).splitlines()
    assert lines[0] == "time_s,displacement_m,current_a" and len(lines) == found.displacement.size + 1
    assert float(lines[1].split(",")[2]) == 0.0
    assert float(lines[-1].split(",")[2]) == pytest.approx(0.5 * (len(steps) - 1))


def test_the_verb_refuses_in_one_line(tmp_path, capsys):
    bag = tmp_path / "a.mcap"
    assert main(["plan", str(bag), "-m", "linear_viscous", "--rig", "crnk", "-o", str(tmp_path / "out")]) == 1
    assert "did you mean crank" in capsys.readouterr().err
    words = ["plan", str(bag), "-m", "linear_viscous", "--parameters", "--diagnosis", "d.json", "-o", str(tmp_path)]
    assert main(words) == 1
    assert "omit one of them" in capsys.readouterr().err
