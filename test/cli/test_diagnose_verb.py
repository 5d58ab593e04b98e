"""diagnose: calls of the engine, text and JSON output, and refused input."""

import json
import os
import shlex

import numpy as np
import pytest
from engines import OFFSET, Engine

from damper_estimator.cli.main import main
from damper_estimator.effects.discovery import all_effects

RIGHT = "name: right\nsource: test\neffects: [{linear_viscous: {rebound: 1500.0, compression: 1500.0}}]"


@pytest.fixture
def engine(monkeypatch):
    fake = Engine()
    monkeypatch.setattr("damper_estimator.workflows.diagnosis.diagnosed", fake.diagnose)
    return fake


def run(*words):
    return main(["diagnose", *map(str, words)])


def test_the_verdict_comes_first_then_the_recordings_then_the_findings(engine, driven, model_file, capsys):
    assert run(driven()[0], "-m", model_file, "-d", "front_left") == 0
    out = capsys.readouterr().out
    found = ["front_left: Missing: friction.", "12 gaps", "Record to a faster disk", "noise floor 5 N", "93 %"]
    found += ["tied with: hysteresis", "A step at every reversal.", "Move it slowly.", "coulomb.force 61230 ± 120 N"]
    places = [out.index(words) for words in found]
    assert places == sorted(places)
    assert "damper-estimator add coulomb" in out and "damper-estimator improve" in out


def test_the_engine_receives_the_arguments(engine, driven, model_file):
    bags = [driven(f"{seed}.mcap", seed=seed)[0] for seed in (1, 2, 3)]
    words = (bags[0], bags[1], "-m", model_file, "--validate", bags[2], "--workers", "3", "-d", "front_right")
    assert run(*words, "--keep-parameters", "--from", "1", "--to", "5") == 0
    assert run(bags[0], "-m", model_file, "--refit", "-d", "front_left") == 0
    first, second = engine.calls
    assert [m.recording for m in first["fit"]] == [str(bags[0]), str(bags[1])]
    assert [m.recording for m in first["unseen"]] == [str(bags[2])]
    assert first["mode"] == "kept" and first["workers"] == 3
    for measurement in (*first["fit"], *first["unseen"]):
        assert (
            measurement.damper == "front_right"
            and measurement.kinematics.time[0] >= 1.0
            and measurement.kinematics.time[-1] <= 5.0
        )
    assert second["mode"] == "refit" and second["unseen"] == () and second["workers"] == os.cpu_count()


def test_every_damper_is_diagnosed_with_its_own_model(engine, driven, tmp_path):
    (tmp_path / "models").mkdir()
    for name in ("front_left", "front_right"):
        (tmp_path / "models" / f"{name}.yaml").write_text(RIGHT.replace("right", name, 1))
    results = tmp_path / "d.json"
    assert run(driven()[0], "-m", tmp_path / "models", "--json", results) == 0
    assert [call["model"].name for call in engine.calls] == ["front_left", "front_right"]
    assert list(json.loads(results.read_text())["dampers"]) == ["front_left", "front_right"]


def test_the_record_has_the_documented_keys(engine, driven, model_file, capsys):
    assert run(driven()[0], "-m", model_file, "-d", "front_left", "--json", "-") == 0
    found = json.loads(capsys.readouterr().out)["dampers"]["front_left"]
    assert {"verdict", "rmse_n", "noise_floor_n", "findings", "rejected"} <= set(found)
    (finding,) = found["findings"]
    keys = {"effect", "phenomenon", "tied_with", "rmse_before_n", "rmse_after_n", "share_of_explainable_error"}
    assert keys | {"confidence", "evidence", "test_to_separate", "parameters"} <= set(finding)
    parameter = {"name": "coulomb.force", "value": 61234.0, "standard_error": 120.0, "unit": "N", "at_bound": False}
    assert finding["parameters"] == [parameter]
    assert [rejected["effect"] for rejected in found["rejected"]] == ["gas_spring", "temperature_gain"]
    assert all(rejected["reason"] for rejected in found["rejected"])


def test_a_fault_of_the_chain_is_not_offered_as_an_effect(engine, driven, model_file, capsys):
    engine.finding = OFFSET
    assert run(driven()[0], "-m", model_file, "-d", "front_left") == 0
    out = capsys.readouterr().out
    assert "damper-estimator add" not in out and "--signals-out" in out


def test_the_page_is_written(engine, driven, model_file, tmp_path):
    assert run(driven()[0], "-m", model_file, "--html", tmp_path / "page.html") == 0
    text = (tmp_path / "page.html").read_text()
    assert "Missing: friction." in text and "front_right" in text and "12 gaps" in text


def test_a_damper_without_validation_is_reported(engine, driven, model_file, capsys):
    both, one = driven("both.mcap")[0], driven("one.mcap", names=("front_left",))[0]
    assert run(both, "-m", model_file, "--validate", one) == 0
    assert "front_right: not in the recordings to judge on" in capsys.readouterr().err
    assert [len(call["unseen"]) for call in engine.calls] == [1, 0]


def test_unusable_input_is_one_line_before_any_work(engine, driven, model_file, tmp_path, refused):
    bag, silent = driven()[0], driven("silent.mcap", force=False)[0]

    def line(*words):
        found = refused("diagnose", *words, "--html", tmp_path / "page.html")
        assert not (tmp_path / "page.html").exists() and not engine.calls
        return found

    assert "nowhere" in refused("diagnose", bag, "-m", model_file, "--html", tmp_path / "nowhere" / "p.html")
    assert "nowhere" in refused("diagnose", bag, "-m", model_file, "--json", tmp_path / "nowhere" / "p.json")
    assert "no_model" in line(bag, "-m", "no_model")
    assert "'rear'" in line(bag, "-m", model_file, "-d", "rear")
    assert "absent.mcap" in line(bag, "-m", model_file, "--validate", tmp_path / "absent.mcap")
    assert "is to be fitted and judged on" in line(bag, "-m", model_file, "--validate", bag)
    assert "no measured force of damper 'front_left'" in line(silent, "-m", model_file, "-d", "front_left")
    assert "no measured force" in line(bag, "-m", model_file, "--validate", silent, "-d", "front_left")


def test_the_next_command_reads_the_recordings_in_the_same_way(engine, driven, model_file, tmp_path, capsys):
    """Without the signal map the next command would interpret the recording otherwise."""
    bag, signals = driven()[0], tmp_path / "my map.yaml"
    signals.write_text("filter: {cutoff: 60.0}\n")
    assert run(bag, "-m", model_file, "-s", signals, "-d", "front_left", "--from", 0.5) == 0
    (improving,) = (text for text in capsys.readouterr().out.splitlines() if "improve" in text)
    words = shlex.split(improving.split("   (")[0])
    assert words[words.index("-s") + 1] == str(signals)
    assert words[words.index("-d") + 1] == "front_left" and float(words[words.index("--from") + 1]) == 0.5


def test_wrong_usage_is_reported(driven, model_file):
    bag = driven()[0]
    for words in ((bag,), (bag, "-m", model_file, "--keep-parameters", "--refit"), (bag, "-m", "x", "--workers", "0")):
        with pytest.raises(SystemExit) as stopped:
            run(*words)
        assert stopped.value.code == 2


def test_friction_in_a_recording_is_found(write_bag, tmp_path, capsys):
    bags = []
    for seed in (1, 2):
        time, draw = np.arange(2500) / 250.0, np.random.default_rng(seed)
        x = 0.004 * sum(np.sin(2 * np.pi * f * time + draw.uniform(0, 6)) / f for f in np.linspace(0.5, 9.0, 10))
        v = np.gradient(x, time)
        force = 1500.0 * v + 60.0 * np.tanh(v / 0.004) + 2.0 * draw.standard_normal(time.size)
        x = x + 2e-6 * draw.standard_normal(time.size)
        stamp = np.round(time * 1e9).astype(np.int64)
        bags.append(write_bag(f"{seed}.mcap", ["front"], stamp, x[:, None], force[:, None]))
    (tmp_path / "right.yaml").write_text(RIGHT)
    results = tmp_path / "d.json"
    words = (bags[0], "--validate", bags[1], "-m", tmp_path / "right.yaml", "--json", results, "--workers", 2)
    assert run(*words, "--html", tmp_path / "page.html") == 0
    found = json.loads(results.read_text())["dampers"]["front"]
    assert found["verdict"] == "missing"
    first = found["findings"][0]
    assert "friction" in (first["phenomenon"], *first["tied_with"]) and len(first["tied_with"]) <= 4
    assert first["rmse_after_n"] < 0.2 * first["rmse_before_n"]
    assert {entry["effect"] for entry in found["findings"] + found["rejected"]} <= set(all_effects())
    assert found["sentence"] in capsys.readouterr().out
    assert found["sentence"] in (tmp_path / "page.html").read_text()
