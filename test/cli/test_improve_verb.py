"""improve: the files it writes, what never goes into a model, and how it refuses."""

import json

import numpy as np
import pytest
from engines import OFFSET, Engine

from damper_estimator.cli.main import main
from damper_estimator.model import load_model
from damper_estimator.recordings import open_bag
from damper_estimator.signals import load_signal_map, measure


@pytest.fixture
def engine(monkeypatch):
    fake = Engine()
    monkeypatch.setattr("damper_estimator.workflows.improvement.improved", fake.improve)
    return fake


def run(*words):
    return main(["improve", *map(str, words)])


def test_the_model_and_that_of_every_step_are_kept(engine, driven, model_file, tmp_path, capsys):
    target, steps = tmp_path / "deep" / "better.yaml", tmp_path / "steps"
    results = tmp_path / "i.json"
    words = (driven()[0], "-m", model_file, "-d", "front_left", "-o", target, "--steps-dir", steps, "--json", results)
    assert run(*words) == 0
    assert "coulomb" in load_model(target).uses()
    assert sorted(path.name for path in steps.iterdir()) == ["00_start.yaml", "01_add_coulomb.yaml"]
    assert "coulomb" not in load_model(steps / "00_start.yaml").uses()
    found = json.loads(results.read_text())["dampers"]["front_left"]
    assert [step["effect"] for step in found["steps"]] == [None, "coulomb"]
    assert [step["phenomenon"] for step in found["steps"]] == [None, "friction"]
    assert [step["rmse_unseen_n"] for step in found["steps"]] == [100.0, 20.0]
    assert found["verdict"] == "nothing_missing" and found["noise_floor_n"] == 5.0
    out = capsys.readouterr().out
    assert (
        out.index("12 gaps") < out.index("add friction (coulomb)") < out.index("noise floor") < out.index(str(target))
    )


def test_several_dampers_go_into_a_folder(engine, driven, model_file, tmp_path):
    bag = driven()[0]
    assert run(bag, "-m", model_file, "-o", tmp_path / "models", "--steps-dir", tmp_path / "steps") == 0
    assert {path.name for path in (tmp_path / "models").iterdir()} == {"front_left.yaml", "front_right.yaml"}
    assert (tmp_path / "steps" / "front_right" / "01_add_coulomb.yaml").exists()
    assert run(bag, "-m", tmp_path / "models", "-o", tmp_path / "models") == 0  # over its own input


def test_one_file_for_several_dampers_is_refused_before_any_work(engine, driven, model_file, tmp_path, refused):
    assert "name a folder" in refused("improve", driven()[0], "-m", model_file, "-o", tmp_path / "one.yaml")
    assert not engine.calls


def test_corrections_go_to_the_signal_map_and_not_into_the_model(engine, driven, model_file, tmp_path, capsys):
    engine.finding = OFFSET
    bag = driven()[0]
    target, corrected = tmp_path / "m.yaml", tmp_path / "map.yaml"
    words = (bag, "-m", model_file, "-d", "front_left", "-o", target)
    assert run(*words) == 0
    assert "use --signals-out MAP.yaml" in capsys.readouterr().out
    assert run(*words, "--signals-out", corrected) == 0
    out = capsys.readouterr().out
    assert "force.offset: 0 -> -35 N" in out and "--signals-out" not in out and str(corrected) in out
    assert not load_model(target).channel_effects and load_model(target).uses() == load_model(model_file).uses()
    with open_bag(bag) as open_one:
        before = measure(open_one, load_signal_map(None), "front_left")
        after = measure(open_one, load_signal_map(corrected), "front_left")
        other = measure(open_one, load_signal_map(corrected), "front_right")
    assert after.force == pytest.approx(before.force - 35.0)
    assert other.signals.force.offset == 0.0


def test_the_map_that_was_used_is_kept_but_for_the_corrections(engine, driven, model_file, tmp_path):
    engine.finding = OFFSET
    (tmp_path / "mine.yaml").write_text(
        "filter: {cutoff: 50.0, band: 25.0}\n"
        "dampers:\n"
        "  front_left: {force: {topic: /suspension/force, field: 'effort[front_left]', spring_rate: 900.0}}\n"
        "  front_right: {}\n"
        "use: [{from: 1.0, to: 6.0}]\n"
    )
    words = (driven()[0], "-s", tmp_path / "mine.yaml", "-d", "front_left", "-m", model_file, "-o", tmp_path / "m.yaml")
    assert run(*words, "--signals-out", tmp_path / "map.yaml") == 0
    used, written = load_signal_map(tmp_path / "mine.yaml"), load_signal_map(tmp_path / "map.yaml")
    assert (written.cutoff, written.band, written.windows) == (used.cutoff, used.band, used.windows)
    assert written.dampers["front_left"].spring_rate == 900.0 and written.dampers["front_left"].force.offset == -35.0
    assert written.dampers["front_right"] == used.dampers["front_right"]


def test_a_map_without_corrections_reads_the_same(engine, driven, model_file, tmp_path):
    bag = driven()[0]
    words = (bag, "-m", model_file, "-o", tmp_path / "models", "--signals-out", tmp_path / "map.yaml")
    assert run(*words) == 0
    with open_bag(bag) as open_one:
        forces = [measure(open_one, load_signal_map(m), "front_right").force for m in (None, tmp_path / "map.yaml")]
    assert np.array_equal(*forces)


def test_json_on_standard_output_is_nothing_but_json(engine, driven, model_file, tmp_path, capsys):
    words = (driven()[0], "-m", model_file, "-d", "front_left", "-o", tmp_path / "m.yaml", "--json", "-")
    assert run(*words) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["dampers"]["front_left"]["file"] == str(tmp_path / "m.yaml")


def test_the_page_is_written(engine, driven, model_file, tmp_path):
    words = (driven()[0], "-m", model_file, "-o", tmp_path / "models", "--html", tmp_path / "page.html")
    assert run(*words) == 0
    text = (tmp_path / "page.html").read_text()
    assert "What each step took away" in text and "front_right" in text and "add friction" in text


def test_a_failure_leaves_nothing(engine, driven, model_file, tmp_path, monkeypatch, refused):
    from damper_estimator.errors import InputError

    bag, kept = driven()[0], {path.name for path in tmp_path.iterdir()}
    files = ("-o", tmp_path / "models", "--steps-dir", tmp_path / "s", "--signals-out", tmp_path / "map.yaml")
    pages = ("--html", tmp_path / "p.html", "--json", tmp_path / "i.json")
    assert "nowhere" in refused(
        "improve", bag, "-m", model_file, "-o", "m", "--signals-out", tmp_path / "nowhere" / "m"
    )
    assert not engine.calls

    def fails_for_the_second(*words, **more):
        if engine.calls:
            raise InputError("a.mcap: has no force")
        return engine.improve(*words, **more)

    monkeypatch.setattr("damper_estimator.workflows.improvement.improved", fails_for_the_second)
    assert main([str(word) for word in ("improve", bag, "-m", model_file, *files, *pages)]) == 1
    assert {path.name for path in tmp_path.iterdir()} == kept


def test_without_a_target_the_usage_is_wrong(driven, model_file):
    with pytest.raises(SystemExit) as stopped:
        run(driven()[0], "-m", model_file)
    assert stopped.value.code == 2
