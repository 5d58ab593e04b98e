"""`compare` by excitation: groups formed or given, relative error over frequency, coherences, accelerometer."""

import json

import numpy as np
import pytest

from damper_estimator.cli.main import main
from damper_estimator.cli.recording_groups import parse_groups
from damper_estimator.errors import InputError
from damper_estimator.recordings import BagWriter, Stream, joint_states
from damper_estimator.recordings.encode import accelerations

RATE = 500.0
KIND = "sensor_msgs/msg/JointState"


def write(path, frequency, amplitude, damping=2000.0, seconds=8.0, accelerometer=False):
    time = np.arange(round(seconds * RATE)) / RATE
    stamps = np.round(1e9 * (7.0 + time)).astype(np.int64)
    w = 2.0 * np.pi * frequency
    x, v = amplitude * np.sin(w * time), amplitude * w * np.cos(w * time)
    streams = [
        Stream("/suspension/displacement", KIND, stamps, joint_states(["d"], stamps, position=x[:, None])),
        Stream("/suspension/force", KIND, stamps, joint_states(["d"], stamps, effort=damping * v[:, None])),
    ]
    if accelerometer:
        messages = accelerations(stamps, -(w**2) * x)
        streams.append(Stream("/suspension/d/acceleration", "geometry_msgs/msg/AccelStamped", stamps, messages))
    with BagWriter(path) as bag:
        bag.write_streams(streams)
    return str(path)


def compared(bags, tmp_path, *more):
    assert main(["compare", *bags, "-m", "linear_viscous", "--json", str(tmp_path / "r.json"), *more]) == 0
    return json.loads((tmp_path / "r.json").read_text())["dampers"]["d"]


@pytest.fixture
def bags(tmp_path):
    return [write(tmp_path / "slow.mcap", 1.0, 0.02), write(tmp_path / "fast.mcap", 12.0, 0.01)]


def test_groups_and_frequencies_are_in_the_json(bags, tmp_path, capsys):
    found = compared(bags, tmp_path)
    assert [group["name"] for group in found["groups"]] == ["LVLF", "HVHF"]
    assert found["relative_rms"]["frequency_hz"] == pytest.approx([1.0, 12.0], rel=0.01)
    assert set(found["partial_coherence"]["partial"]) == {"velocity", "displacement", "acceleration"}
    assert "LVLF" in capsys.readouterr().out


def test_given_groups_replace_those_that_form(bags, tmp_path):
    found = compared(bags, tmp_path, "--group", "comfort=slow", "--group", f"track={bags[1]}")
    assert [(group["name"], group["recordings"]) for group in found["groups"]] == [("comfort", 1), ("track", 1)]


def test_an_accelerometers_velocity_is_compared(tmp_path):
    found = compared([write(tmp_path / "a.mcap", 2.0, 0.01, accelerometer=True)], tmp_path)
    (velocity,) = found["velocity"].values()
    assert velocity["correlation"] > 0.99
    assert velocity["gain"] == pytest.approx(1.0, abs=0.02)


def test_the_page_shows_them(bags, tmp_path):
    compared(bags, tmp_path, "--html", str(tmp_path / "p.html"), "--group", "comfort=slow")
    page = (tmp_path / "p.html").read_text()
    assert "Error by group" in page and "comfort: slow.mcap" in page


@pytest.mark.parametrize(
    ("text", "wrong"),
    [("comfort", "is not a group"), ("a=none", "is not one of the recordings"), ("=slow", "is not a group")],
)
def test_invalid_groups_are_refused(text, wrong, tmp_path):
    with pytest.raises(InputError, match=wrong):
        parse_groups([text], [tmp_path / "slow.mcap", tmp_path / "fast.mcap"])


def test_a_group_given_twice_is_refused(tmp_path):
    with pytest.raises(InputError, match="given twice"):
        parse_groups(["a=slow", "a=slow"], [tmp_path / "slow.mcap"])
