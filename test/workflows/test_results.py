"""Results: a mapping by damper, short in a notebook, and equal to the JSON of the command line."""

import json
from xml.etree import ElementTree

import pytest
from drives import samples

from damper_estimator.cli.main import main
from damper_estimator.errors import InputError
from damper_estimator.files import plain
from damper_estimator.model import load_model
from damper_estimator.workflows import Recording, characterize, compare, fit, fit_with, read, replay
from damper_estimator.workflows.fitting import FitOptions

SHORT = 6000  # characters of a table in a notebook
TIMES = {"seconds"}


def without_times(value):
    if isinstance(value, dict):
        return {key: without_times(result) for key, result in value.items() if key not in TIMES}
    return [without_times(result) for result in value] if isinstance(value, list) else value


def json_of(tmp_path, *words):
    """The content that the command line writes with ``--json``."""
    target = tmp_path / "record.json"
    assert main([*map(str, words), "--json", str(target)]) == 0
    return without_times(json.loads(target.read_text()))


@pytest.fixture
def two(drive):
    return drive(dampers=("front_left", "front_right"))


def test_the_record_of_a_comparison_is_that_of_the_command_line(two, drive, tmp_path):
    other = drive("other.mcap", dampers=("front_left", "front_right"), seed=5)
    expected = json_of(tmp_path, "compare", two, other, "-m", "linear_viscous", "-m", "coulomb")
    results = compare(read([two, other]), ["linear_viscous", "coulomb"])
    assert without_times(plain(results.to_dict())) == expected


def test_the_record_of_a_fit_is_that_of_the_command_line_except_for_the_file(two, tmp_path):
    expected = json_of(tmp_path, "fit", two, "-m", "linear_viscous", "-o", tmp_path / "models")
    results = fit(read(two), "linear_viscous")
    record = without_times(plain(results.to_dict()))
    for damper, result in expected["dampers"].items():
        assert result.pop("file") == str(tmp_path / "models" / f"{damper}.yaml")
        assert record["dampers"][damper].pop("file") is None
    assert record == expected
    results.save(tmp_path / "saved")
    for damper in results:
        written, saved = (load_model(tmp_path / name, damper) for name in ("models", "saved"))
        assert written.slots == saved.slots == results[damper].model.slots


def test_the_record_and_the_estimates_of_a_replay_are_those_of_the_command_line(two, tmp_path):
    expected = json_of(
        tmp_path, "replay", two, "-m", "linear_viscous", "-o", tmp_path / "out.mcap", "--from", 1, "--to", 4
    )
    results = replay(read(two, start=1.0, stop=4.0), "linear_viscous")
    assert plain(results.to_dict()) == expected | {"output": None}
    results.save(tmp_path / "saved.mcap")
    assert (tmp_path / "saved.mcap").read_bytes() == (tmp_path / "out.mcap").read_bytes()


@pytest.mark.parametrize("use", [compare, fit, replay])
def test_results_are_a_mapping_by_damper_whose_values_are_results_alone(use, two):
    results = use(read(two), "linear_viscous")
    assert list(results) == ["front_left", "front_right"] and len(results) == 2
    for damper, result in results.items():
        assert list(result) == [damper] and isinstance(result, type(results))
        assert result.to_dict()["dampers"][damper].keys() == results.to_dict()["dampers"][damper].keys()
        assert result.only is results.by_damper[damper]
    with pytest.raises(InputError, match=r"dampers front_left, front_right; select one: result\['front_left'\]"):
        results.only  # noqa: B018
    with pytest.raises(KeyError):
        results["rear"]


@pytest.mark.parametrize("use", [compare, fit, replay])
def test_a_notebook_shows_a_short_table_and_a_figure(use, two):
    results = use(read(two), "linear_viscous")
    table = ElementTree.fromstring(results._repr_html_())
    assert len(results._repr_html_()) < SHORT and "\n" not in repr(results) and len(repr(results)) < 300
    assert {cell.text for cell in table.iter("td")} >= {"front_left", "front_right"}
    figure = results.figure("front_left")
    assert figure.data and figure.layout.xaxis.title.text == "time in s"
    assert "@" not in figure.to_json().replace("@en", "")
    with pytest.raises(InputError, match="select one"):
        results.figure()
    with pytest.raises(InputError, match="no result of damper 'rear'; the results are of front_left, front_right"):
        results.figure("rear")


def test_names_from_files_are_escaped_in_a_notebook():
    time, x, force, _ = samples()
    recording = Recording.from_arrays(time, x, force=force, damper="<left & right>", name="<b>&")
    for shown in (recording, compare(recording, "linear_viscous")):
        assert "<left & right>" in [cell.text for cell in ElementTree.fromstring(shown._repr_html_()).iter("td")]


def test_models_by_damper_are_compared_each_with_its_own(two):
    recording = read(two)
    fitted = fit(recording, "linear_viscous")
    results = compare(recording, fitted.models)
    for damper, result in results.items():
        assert result.comparison.model.slots == fitted.models[damper].slots
        assert result.rmse_n == pytest.approx(fitted[damper].rmse_n, rel=1e-9)
    with pytest.raises(InputError, match="models: none for damper front_right; the mapping has front_left"):
        compare(recording, {"front_left": "linear_viscous"})


def test_results_are_saved_by_the_ending_of_the_name(two, tmp_path):
    recording = read(two)
    results = compare(recording, "linear_viscous")
    assert json.loads(results.save(tmp_path / "c.json").read_text()) == plain(results.to_dict())
    assert results.save(tmp_path / "c.html").read_text().startswith("<!doctype html>")
    with pytest.raises(InputError, match=r"c\.txt: .*\.json or \.html"):
        results.save(tmp_path / "c.txt")
    with pytest.raises(InputError, match=r"one\.yaml: is one file, but there are several dampers"):
        fit(recording, "linear_viscous").save(tmp_path / "one.yaml")
    estimates = replay(recording.of("front_left"), "linear_viscous")
    rows = estimates.save(tmp_path / "e.csv").read_text().splitlines()
    assert rows[0].startswith("stamp_ns,displacement,velocity") and len(rows) == 1 + estimates.force.size
    assert sorted(path.name for path in tmp_path.iterdir()) == ["c.html", "c.json", "drive.mcap", "e.csv"]


def test_a_fit_accepts_options_of_the_command_line(two):
    recording = read(two, dampers="front_left")
    free = fit(recording, "linear_viscous", fix=["*"], free=["linear_viscous.rebound"])
    assert [p.name for p in free.parameters] == ["linear_viscous.rebound"]
    lines = []
    bounded = fit_with(
        recording, "linear_viscous", FitOptions(limits={"linear_viscous.rebound": (0.0, 1000.0)}), lines.append
    )
    assert bounded.fit.parameters[0].at_bound and lines[0].startswith("front_left: fitting linear_viscous to 1 rec")


def test_only_a_single_recording_is_replayed(drive):
    with pytest.raises(InputError, match="replay accepts one recording, but got"):
        replay(read([drive("a.mcap"), drive("b.mcap")]), "linear_viscous")


def test_characteristics_are_displayed_like_other_results(tmp_path):
    import numpy as np

    time = np.arange(0.0, 20.0, 0.002)
    x = 0.01 * np.sin(2 * np.pi * 2.0 * time)
    recording = Recording.from_arrays(time, x, force=1500.0 * np.gradient(x, time))
    results = characterize(recording)
    assert len(results.diagrams) == 1 and "1 operating points" in repr(results)
    ElementTree.fromstring(results._repr_html_())
    assert results.figure().layout.xaxis.title.text == "velocity in m/s"
    assert json.loads(results.save(tmp_path / "c.json").read_text())["dampers"]["damper"]["operating_points"]
