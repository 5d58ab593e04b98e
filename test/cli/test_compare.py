"""compare: summary, JSON and page through the command line."""

import json
import re

import numpy as np
import pytest

from damper_estimator.cli.main import main
from damper_estimator.model import load_model
from damper_estimator.recordings import open_bag
from damper_estimator.signals import SignalMap, measure
from damper_estimator.validation import compare


def results(tmp_path, *words):
    path = tmp_path / "results.json"
    assert main(["compare", *map(str, words), "--json", str(path)]) == 0
    return json.loads(path.read_text())["dampers"]


def test_the_numbers_are_those_of_the_library(driven, model_file, tmp_path):
    bag, *_ = driven()
    found = results(tmp_path, bag, "-m", model_file)
    assert list(found) == ["front_left", "front_right"]
    with open_bag(bag) as opened:
        m = measure(opened, SignalMap(), "front_right")
    expected = compare(load_model(model_file), m).measures.record()
    assert {name: found["front_right"][name] for name in expected} == expected


def test_several_bags_are_pooled_and_reported_one_by_one(driven, model_file, tmp_path):
    one, other = driven("one.mcap", seed=1)[0], driven("other.mcap", seconds=4.0, seed=2)[0]
    found = results(tmp_path, one, other, "-m", model_file)["front_left"]
    alone = [results(tmp_path, bag, "-m", model_file)["front_left"] for bag in (one, other)]
    assert [entry["rmse_n"] for entry in found["bags"]] == [entry["rmse_n"] for entry in alone]
    assert found["samples"] == sum(entry["samples"] for entry in alone)
    assert [entry["bag"] for entry in found["bags"]] == [str(one), str(other)]


def test_several_models_are_compared_with_each_other(driven, model_file, tmp_path, capsys):
    bag, *_ = driven()
    found = results(tmp_path, bag, "-m", "linear_viscous", "-m", model_file)["front_left"]
    assert [entry["model"] for entry in found["models"]] == [load_model("linear_viscous").name, "viscous_and_friction"]
    assert found["rmse_n"] == found["models"][0]["rmse_n"]
    assert "viscous_and_friction" in capsys.readouterr().out


def test_models_of_one_name_are_numbered(driven, model_file, tmp_path, capsys):
    bag, *_ = driven()
    twice = results(tmp_path, bag, "-m", model_file, "-m", model_file)["front_left"]
    names = [entry["model"] for entry in twice["models"]]
    printed = capsys.readouterr().out
    assert len(set(names)) == 2 and all(name in printed for name in names)


def test_a_measure_without_meaning_is_a_dash(driven, tmp_path, capsys):
    bag, *_ = driven()
    still = tmp_path / "still.yaml"
    still.write_text("name: still\nsource: test\neffects: [static_force: {force: 10.0}]\n")
    assert results(tmp_path, bag, "-m", still)["front_left"]["correlation"] is None
    printed = capsys.readouterr().out
    assert "nan" not in printed and "–" in printed


def test_standard_output_has_only_json(driven, model_file, capsys):
    bag, *_ = driven()
    assert main(["compare", str(bag), "-m", str(model_file), "--json", "-"]) == 0
    assert set(json.loads(capsys.readouterr().out)["dampers"]) == {"front_left", "front_right"}


def test_the_summary_names_the_planted_error(driven, tmp_path, capsys):
    bag, *_ = driven(seconds=20.0)
    right = tmp_path / "right.yaml"
    right.write_text("name: right\nsource: test\neffects: [{linear_viscous: {rebound: 1500.0, compression: 1500.0}}]")
    assert main(["compare", str(bag), "-m", str(right), "-d", "front_left"]) == 0
    out = capsys.readouterr().out
    assert re.search(
        r"rebound above 0\.05 m/s: \d+ % of the squared error in \d+ % of the time, model \d+ N too soft", out
    )


def test_a_window_cuts(driven, model_file, tmp_path):
    bag, *_ = driven()
    assert results(tmp_path, bag, "-m", model_file, "--from", 2, "--to", 5)["front_left"]["samples"] == 1400


def test_the_page_is_self_contained(driven, model_file, tmp_path):
    bag, *_ = driven()
    page = tmp_path / "page.html"
    assert main(["compare", str(bag), "-m", str(model_file), "--html", str(page)]) == 0
    text = page.read_text()
    assert "front_right" in text and not re.search(r"<(?:script|link|img)[^>]+(?:src|href)=[\"'](?!data:)", text)


def test_a_damper_without_measured_force_is_left_out_unless_it_is_requested(
    driven, model_file, tmp_path, refused, capsys
):
    bag, *_ = driven()
    (tmp_path / "map.yaml").write_text(
        "dampers:\n  front_left: {}\n  other: {displacement: {topic: /suspension/displacement, field: 'position[1]'}}\n"
    )
    assert list(results(tmp_path, bag, "-m", model_file, "-s", tmp_path / "map.yaml")) == ["front_left"]
    assert "other was not measured" in capsys.readouterr().err
    assert "no measured force of damper 'other'" in refused(
        "compare", bag, "-m", model_file, "-s", tmp_path / "map.yaml", "-d", "other"
    )


def test_a_damper_may_be_in_some_of_the_bags(driven, model_file, tmp_path):
    both, one = driven("both.mcap")[0], driven("one.mcap", names=("front_left",))[0]
    found = results(tmp_path, both, one, "-m", model_file)
    assert len(found["front_left"]["bags"]) == 2 and "bags" not in found["front_right"]


def test_unusable_input_is_one_line_and_leaves_no_files(driven, write_bag, model_file, tmp_path, refused):
    bag, *_ = driven()
    silent, *_ = driven("silent.mcap", force=False)
    page = tmp_path / "page.html"

    def line(*words):
        found = refused("compare", *words, "--html", page, "--json", tmp_path / "r.json")
        assert not page.exists() and not (tmp_path / "r.json").exists()
        return found

    assert "no damper has a measured force" in line(silent, "-m", model_file)
    assert "'rear'" in line(bag, "-m", model_file, "-d", "rear") and "front_left" in line(
        bag, "-m", model_file, "-d", "rear"
    )
    assert "no_model" in line(bag, "-m", "no_model")
    (tmp_path / "wrong.yaml").write_text("name: x\nsource: y\neffects: [{nonsense: {}}]")
    assert "nonsense" in line(bag, "-m", tmp_path / "wrong.yaml")
    (tmp_path / "map.yaml").write_text(
        "dampers: {front_left: {force: {topic: /suspension/force, field: 'efforts[front_left]'}}}"
    )
    assert "efforts" in line(bag, "-m", model_file, "-s", tmp_path / "map.yaml")
    (tmp_path / "topic.yaml").write_text("dampers: {front_left: {force: {topic: /nowhere}}}")
    assert "/nowhere" in line(bag, "-m", model_file, "-s", tmp_path / "topic.yaml")
    short = write_bag("short.mcap", ["a"], np.arange(50) * 2_000_000, np.zeros((50, 1)), np.zeros((50, 1)))
    assert "0.2 s" in line(short, "-m", model_file)
    (tmp_path / "empty.mcap").write_bytes(b"")
    assert "empty.mcap" in line(tmp_path / "empty.mcap", "-m", model_file)
    assert "absent" in refused("compare", bag, "-m", model_file, "--html", tmp_path / "absent" / "p.html")


def test_without_a_model_the_usage_is_wrong(driven):
    with pytest.raises(SystemExit) as stopped:
        main(["compare", str(driven()[0])])
    assert stopped.value.code == 2


def test_steps_are_judged_one_by_one(tmp_path, capsys):
    assert main(["synth", "-o", str(tmp_path), "--excitation", "step", "--seconds", "8"]) == 0
    capsys.readouterr()
    words = [
        "compare",
        str(tmp_path / "step.mcap"),
        "-m",
        "carrera_akutain",
        "--steps",
        "--json",
        str(tmp_path / "c.json"),
    ]
    assert main(words) == 0
    steps = json.loads((tmp_path / "c.json").read_text())["dampers"]["passenger_front"]["steps"]["carrera_akutain"]
    assert len(steps) >= 4 and {round(abs(s["height_m"]), 2) for s in steps} >= {0.05}
    assert "mm in" in capsys.readouterr().out


def test_a_recording_without_steps_is_no_step_test(driven, model_file, refused):
    assert "no step" in refused("compare", driven()[0], "-m", model_file, "--steps")
