"""The verb `characterize` over real bags: output and refused input."""

import json

import numpy as np
import pytest
from shapes import sine

from damper_estimator.cli.main import main
from damper_estimator.model import load_model
from damper_estimator.recordings import BagWriter, Stream, floats, joint_states

RATE = 400.0


def write(path, law, frequency=2.0, amplitude=0.02, seconds=5.0, current=None):
    """A bag of a sine test."""
    time = np.arange(round(seconds * RATE)) / RATE
    stamps = np.round(1e9 * (1000.0 + time)).astype(np.int64)
    x, v, a = sine(time, frequency, amplitude)
    kind = "sensor_msgs/msg/JointState"
    streams = [
        Stream("/suspension/displacement", kind, stamps, joint_states(["d"], stamps, position=x[:, None])),
        Stream("/suspension/force", kind, stamps, joint_states(["d"], stamps, effort=law(x, v, a)[:, None])),
    ]
    if current is not None:
        streams.append(
            Stream("/suspension/d/current", "std_msgs/msg/Float64", stamps - 1, floats(np.full(time.size, current)))
        )
    with BagWriter(path) as bag:
        bag.write_streams(streams)
    return str(path)


def digressive(x, v, a):
    return 600.0 * np.tanh(v / 0.08) + 400.0 * v


@pytest.fixture
def bags(tmp_path):
    return [
        write(
            tmp_path / f"{current}.mcap",
            lambda x, v, a, c=current: digressive(x, v, a) + 300.0 * c * np.tanh(v / 0.02),
            current=current,
        )
        for current in (0.0, 1.0)
    ]


def test_results_go_to_standard_output_json_page_table_and_model(bags, tmp_path, capsys):
    out = {name: str(tmp_path / name) for name in ("r.json", "p.csv", "m.yaml", "p.html")}
    assert (
        main(
            [
                "characterize",
                *bags,
                "--json",
                out["r.json"],
                "--peaks",
                out["p.csv"],
                "-o",
                out["m.yaml"],
                "--html",
                out["p.html"],
            ]
        )
        == 0
    )
    printed = capsys.readouterr().out
    assert "passive type 1, semi-active type 4" in printed
    assert "lozoya_santos_simple" in printed
    found = json.loads((tmp_path / "r.json").read_text())["dampers"]["d"]
    assert found["bands"][0]["passive"] == 1 and found["structure"]["semi_active"] == "simple"
    assert len((tmp_path / "p.csv").read_text().splitlines()) == 3
    assert load_model(out["m.yaml"]).name == "lozoya_santos_simple_symmetric"
    page = (tmp_path / "p.html").read_text()
    assert "yield, rebound" in page and 'src="http' not in page


def test_standard_output_has_only_json(bags, capsys):
    assert main(["characterize", *bags, "--json", "-"]) == 0
    assert "d" in json.loads(capsys.readouterr().out)["dampers"]


def test_settings_are_subtracted_and_a_slow_test_is_subtracted(bags, tmp_path, capsys):
    slow = write(tmp_path / "slow.mcap", lambda x, v, a: -200.0 - 3000.0 * x, frequency=0.05, seconds=45.0)
    assert (
        main(
            ["characterize", bags[1], "--subtract", bags[0], "--quasi-static", slow, "--json", str(tmp_path / "r.json")]
        )
        == 0
    )
    found = json.loads((tmp_path / "r.json").read_text())["dampers"]["d"]
    assert found["differences"][0]["role"] == "command"
    assert found["differences"][0]["type"] == 4
    assert "slow.mcap" in capsys.readouterr().out


def test_a_recording_at_rest_is_refused_in_one_line(tmp_path, capsys):
    still = write(tmp_path / "still.mcap", lambda x, v, a: 0.0 * x, amplitude=0.0)
    assert main(["characterize", still]) == 1
    errors = capsys.readouterr().err.strip().splitlines()
    assert len(errors) == 1 and "no motion that characterizes" in errors[0]
