"""Signal maps: defaults, units, tables, round trip, and every mistake named at once."""

import numpy as np
import pytest
import yaml
from hypothesis import example, given
from hypothesis import strategies as st

from damper_estimator.errors import InputError
from damper_estimator.recordings import parse_path
from damper_estimator.recordings.field_path import Step
from damper_estimator.signals import named_element
from damper_estimator.signals.map_writing import save_signal_map, signal_map_yaml
from damper_estimator.signals.signal_map import (
    Channel,
    SignalMap,
    default_signals,
    load_signal_map,
    parse_signal_map,
)

FULL = """
filter: {cutoff: 60.0, band: 30.0}
dampers:
  front_left:
    displacement: {topic: /suspension/displacement, field: "position[front_left]", scale: 1.0, offset: 0.0, skew: 0.0}
    force: {topic: /suspension/force, field: "effort[front_left]", scale: 1.0, offset: 0.0, skew: 0.0,
            spring_rate: 28000.0, preload: -3000.0}
    command: {topic: /suspension/front_left/current, field: data, unit: A}
    temperature: {topic: /suspension/front_left/temperature, field: temperature}
use: [{from: 1.0, to: 5.0}, {from: 10.0}]
"""


def test_the_documented_example_is_completely_understood():
    signal_map = parse_signal_map(yaml.safe_load(FULL), "map.yaml")
    front_left = signal_map.dampers["front_left"]
    assert (signal_map.cutoff, signal_map.band) == (60.0, 30.0)
    assert signal_map.windows == ((1.0, 5.0), (10.0, float("inf")))
    assert (front_left.spring_rate, front_left.preload) == (28000.0, -3000.0)
    assert front_left.command.unit == "A" and front_left.command.given
    assert front_left.pressure == default_signals("front_left").pressure


def test_omitted_entries_have_the_defaults():
    signal_map = parse_signal_map({"dampers": {"rear": {"displacement": {"scale": 0.001}}}}, "m")
    displacement = signal_map.dampers["rear"].displacement
    assert displacement.topic == "suspension/displacement" and displacement.field == "position[rear]"
    assert displacement.scale == 0.001 and not signal_map.dampers["rear"].force.given
    assert parse_signal_map(None, "m") == SignalMap(where="m")


@pytest.mark.parametrize("word", ["none", None])
def test_no_cutoff_is_the_unfiltered_mode(word):
    assert parse_signal_map({"filter": {"cutoff": word}}, "m").cutoff == 0.0


@given(st.floats(-10, 10), st.floats(-5, 5), st.floats(-100, 100))
def test_value_is_scale_times_raw_plus_offset(scale, offset, raw):
    channel = Channel("t", "f", scale=scale, offset=offset)
    assert channel.value(np.array([raw]))[0] == scale * raw + offset


def test_one_sample_and_a_record_are_scaled_to_the_same_bits():
    raw = np.random.default_rng(0).normal(size=1000)
    for channel in (Channel("t", "f", 0.1234567, -0.07), Channel("t", "f", table=((-1.0, 0.1, 2.0), (0.3, 0.2, -5.0)))):
        each = np.concatenate([channel.value(raw[i : i + 1]) for i in range(1000)])
        assert np.array_equal(channel.value(raw), each, equal_nan=True)


def test_tables_are_straight_between_their_points():
    channel = parse_signal_map(
        {"dampers": {"a": {"displacement": {"table": {"raw": [0, 1, 3], "value": [0.0, 0.5, 2.5]}}}}}, "m"
    )
    assert channel.dampers["a"].displacement.value(np.array([0.5, 2.0])).tolist() == [0.25, 1.5]


@pytest.mark.parametrize("raw", [65535.0, -1e300, np.inf, -np.inf, np.nan, 4.1, -0.1])
def test_what_is_beyond_a_table_is_no_value(raw):
    channel = Channel("t", "f", table=((0.0, 1.0, 4.0), (0.0, 0.5, 2.5)), limits=(-10.0, 10.0))
    assert np.isnan(channel.value(raw))
    assert channel.value(np.array([4.05, -0.05])).tolist() == [2.5, 0.0]  # noise at the ends
    assert channel.value_limits == (0.0, 2.5)


@given(st.text(min_size=1))
@example("1")
@example("a]")
@example('"quoted"')
@example("front left")
def test_an_element_is_found_by_any_name(name):
    """A damper may be called 1: that is no position."""
    assert parse_path(named_element("position", name)).steps == (Step("position", name),)


def test_ordinary_names_are_written_plainly():
    assert named_element("position", "front_left") == "position[front_left]"
    assert named_element("effort", "1") == 'effort["1"]'


@given(st.floats(-3, 3))
def test_raw_inverts_value(raw):
    rising, falling = ((-4.0, 0.0, 4.0), (0.0, 1.0, 5.0)), ((-4.0, 0.0, 4.0), (5.0, 1.0, 0.0))
    for channel in (Channel("t", "f", 1e-3, 0.5), Channel("t", "f", table=rising), Channel("t", "f", table=falling)):
        assert channel.raw(float(channel.value(raw))) == pytest.approx(raw, abs=1e-9)


def test_limits_of_a_command_are_raw_and_value_limits_are_in_order():
    assert Channel("t", "f", scale=-1e-3, limits=(0.0, 2000.0)).value_limits == (-2.0, 0.0)
    assert Channel("t", "f").value_limits is None


def test_a_saved_map_loads_again(tmp_path):
    content = yaml.safe_load(FULL)
    content["dampers"]["rear"] = {
        "displacement": {"table": {"raw": [0, 1], "value": [0.0, 2.0]}},
        "force": {"skew": 0.003},
        "command": {"limits": [0.0, 1.8]},
    }
    content["filter"]["fusion"] = {"acceleration_noise": 0.5}
    signal_map = parse_signal_map(content, str(tmp_path / "map.yaml"))
    save_signal_map(signal_map, tmp_path / "map.yaml")
    assert load_signal_map(tmp_path / "map.yaml") == signal_map
    assert "nan" not in signal_map_yaml(signal_map)


@pytest.mark.parametrize(
    ("text", "faults"),
    [
        ("filter: {cutof: 3}", ["'cutof' in filter"]),
        (
            "filter: {fusion: {displacement_noise: 0, noise: 1}}",
            ["displacement_noise = 0 must lie between 1e-9 and 1e6", "'noise'"],
        ),
        ("dampers: {a: {command: {limits: [2, 0]}}}", ["2 is not below 0"]),
        ("dampers: {a: {command: {limits: 2}}}", ["limits must be two numbers"]),
        ("dampers: {a: {force: {limits: [0, 2]}}}", ["'limits'"]),
        ("filter: {cutoff: -3, band: fast}", ["above 0 Hz", "'fast' is not a number"]),
        ("dampers: [a]", ["dampers must be a mapping"]),
        ("dampers: {a: {displacment: {}, force: {spring: 1}}}", ["'displacment'", "'spring'"]),
        ("dampers: {a: {displacement: {spring_rate: 1}}}", ["'spring_rate'"]),
        ("dampers: {a: {displacement: {scale: big, skew: .nan}}}", ["'big' is not a number", "nan is not a number"]),
        ("dampers: {a: {displacement: {table: {raw: [1, 1], value: [0, 1]}}}}", ["rise strictly"]),
        ("dampers: {a: {displacement: {table: {raw: [0, 1], value: [0, 1]}, scale: 2}}}", ["both a table and a scale"]),
        ("use: [{from: 5, to: 2}]", ["is empty"]),
        ("use: 3", ["use must be a list"]),
        ("colour: red", ["'colour'"]),
        ("dampers: {a: {displacement: {unit: mm}}}", ["displacement.unit is mm, but values are in m"]),
        ("filter: [", ["not valid YAML"]),
    ],
)
def test_mistakes_are_all_named_in_one_line_with_the_file(tmp_path, text, faults):
    path = tmp_path / "map.yaml"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        load_signal_map(path)
    message = str(caught.value)
    assert "\n" not in message and str(path) in message
    assert all(fault in message for fault in faults), message


def test_a_missing_map_is_named():
    with pytest.raises(InputError, match="nowhere.yaml"):
        load_signal_map("nowhere.yaml")
