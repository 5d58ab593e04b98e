"""Column maps: every complaint at once, differences by file name, shipped maps that load."""

import copy
from pathlib import Path

import pytest
import yaml

from damper_estimator.errors import InputError
from damper_estimator.recordings.column_map import Channel, Clock, load_column_maps
from damper_estimator.share import share_path

GOOD = {
    "dampers": {"fl": {"displacement": {"column": 1, "unit": "mm"}, "command": {"column": "I", "unit": "A"}}},
    "time": {"rate": 100},
}


@pytest.fixture
def load(tmp_path):
    def from_content(content, file="x.csv"):
        path = tmp_path / "map.yaml"
        path.write_text(content if isinstance(content, str) else yaml.safe_dump(content))
        return load_column_maps(path).for_file(file)

    return from_content


@pytest.mark.parametrize("name", sorted(path.stem for path in share_path("config/columns").glob("*.yaml")))
def test_shipped_maps_load_by_name(name):
    load_column_maps(name).for_file("ME2mm5Hz.txt.gz" if name.startswith("utfsm") else "ensaio.B.1.mat")


def test_the_example_explains_every_key():
    content = yaml.safe_load((share_path("config/columns") / "example.yaml").read_text())
    assert set(content) == {"dampers", "time", "text", "split", "trim_rest", "center", "name", "files"}
    assert set(content["text"]) == {"separator", "decimal", "skip", "titles"}


def places(content, path=()):
    """Paths to every value in a map, including those of mappings and lists."""
    for key, value in content.items():
        yield (*path, key)
        if isinstance(value, dict):
            yield from places(value, (*path, key))


EXAMPLE = yaml.safe_load((share_path("config/columns") / "example.yaml").read_text())


@pytest.mark.parametrize("odd", [{}, {"a": {}}, [], [{}], None, True, 3, -1.5, float("nan"), "", "odd"], ids=repr)
def test_any_value_at_any_place_is_accepted_or_refused(load, odd):
    refused = 0
    for *way, last in places(EXAMPLE):
        content = copy.deepcopy(EXAMPLE)
        inner = content
        for key in way:
            inner = inner[key]
        inner[last] = odd
        try:
            load(content)
        except InputError as error:
            assert "\n" not in str(error)
            refused += 1
    assert refused


def test_an_unknown_name_is_refused():
    with pytest.raises(InputError, match="no_such_map.yaml: cannot be read"):
        load_column_maps("no_such_map")


def test_all_complaints_come_at_once(load):
    content = {
        "damper": 1,
        "dampers": {
            "front left": {"displacement": {"colunm": 1, "unit": "V"}, "velocity": {}},
            "b": {"force": {"value": 3, "unit": "N"}, "command": {"values": [1, "x"], "column": 2}},
        },
        "time": {"rate": -1, "column": "t", "unit": "days"},
        "text": {"separator": ", ", "decimal": "'", "skip": -1, "lines": 3},
        "split": {"column": "e"},
        "trim_rest": {"margins": 1},
        "center": "left",
        "name": 3,
        "files": {"*.csv": {"files": {}, "time": {"format": "no percent", "column": "t"}}, "b": 3},
    }
    with pytest.raises(InputError) as caught:
        load(content)
    text = str(caught.value)
    assert "\n" not in text
    for complaint in (
        "the map has unknown keys damper (allowed: dampers,",
        "damper 'front left' cannot be part of a topic",
        "dampers.front left.displacement has unknown keys colunm",
        "dampers.front left.displacement.unit is 'V'; it can be m, cm, mm, um, in (scale converts volts",
        "dampers.front left has unknown keys velocity (allowed: displacement, force, command,",
        "dampers.b.force cannot be constant",
        "dampers.b.command needs one of column, value and values, not column and values",
        "dampers.b.command.values must be a list of numbers",
        "time needs one of column, rate and interval, not column and rate",
        "time.unit is 'days'; it can be s, ms",
        "time.rate must be a positive number",
        "text.separator is ', '; it can be one character",
        'text.decimal is "\'"',
        "text.skip cannot be -1",
        "text has unknown keys lines",
        "split needs one of column and equals, pause, or restart",
        "trim_rest can be true, or {margin:",
        "center is 'left'; it can be rest or middle",
        "name must be text",
        'files "*.csv": the map has unknown keys files',
        "files \"*.csv\": time.format cannot be 'no percent'",
        'files "b" must be a mapping',
    ):
        assert complaint in text


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"dampers": {"fl": {"displacement": {"column": 1}}}}, "dampers.fl.displacement.unit is missing"),
        ({"dampers": {"fl": {"displacement": {"unit": "mm"}}}}, "dampers.fl.displacement needs one of column"),
        ({"dampers": {"fl": {"force": {"column": 1, "unit": "N"}}}}, "dampers.fl has no displacement"),
        ({"time": None}, "time is missing: give a column, a rate or an interval"),
    ],
)
def test_missing_entries_for_a_file_are_reported_with_its_name(load, change, complaint):
    with pytest.raises(InputError, match=f"map.yaml: for x.csv: .*{complaint}"):
        load({**GOOD, **change})


@pytest.mark.parametrize("text", ["", "- 1", "a: [", "dampers: &a {x: *a}", "\0"])
def test_text_that_is_no_map_is_refused(load, text):
    with pytest.raises(InputError, match="map.yaml: "):
        load(text)


def test_differences_by_file_name_apply_in_order_and_replace_the_source(load):
    command = {"dampers": {"fl": {"command": {"value": 2}}}}
    content = {
        **GOOD,
        "files": {
            "*2A*": command,
            "x*": {"time": {"interval": 0.5}, "dampers": {"fl": {"displacement": {"scale": 2}}}},
        },
    }
    both, first = load(content, "x_2A.csv"), load(content, "y_2A.csv")
    assert both.clock == Clock(interval=0.5) and first.clock == Clock(rate=100)
    assert both.dampers["fl"]["command"] == Channel(None, (2.0,), 1.0, 0.0, "A")
    assert both.dampers["fl"]["displacement"].scale == 2.0 and first.dampers["fl"]["displacement"].scale == 1.0
    assert load(content, "z.csv").dampers["fl"]["command"].column == "I"


def test_numbers_with_exponents_are_numbers(load):
    channel = "{column: 1, unit: m, scale: 1e-3, offset: -2E+1}"
    read = load(f"dampers: {{fl: {{displacement: {channel}}}}}\ntime: {{rate: 1e3}}\n")
    assert read.dampers["fl"]["displacement"].scale == 1e-3 and read.clock.rate == 1000.0
    assert read.dampers["fl"]["displacement"].offset == -20.0


def test_a_map_is_a_file_or_a_shipped_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert load_column_maps("utfsm_mr_damper").path == share_path("config/columns/utfsm_mr_damper.yaml")
    Path("local").write_text(yaml.safe_dump(GOOD))
    assert load_column_maps("local").for_file("a").clock.rate == 100
