"""The verb import: bench files to recordings with the default topics."""

import json

import numpy as np
import pytest
import scipy.io
import yaml

from damper_estimator.cli.main import main
from damper_estimator.recordings import open_bag

RATE = 200.0
TIME = np.arange(400) / RATE
REST = 100  # samples at rest before and after the motion
POSITION = np.concatenate([np.zeros(REST), 10 * np.sin(2 * np.pi * 2 * TIME[: 400 - 2 * REST]), np.zeros(REST)])
FORCE = np.gradient(POSITION, 1 / RATE) * 2.0


def channels(**more) -> dict:
    given = {
        "displacement": {"column": "Position", "unit": "mm"},
        "force": {"column": "Load", "unit": "kN", "scale": 0.001},
    }
    return {"dampers": {"front_left": {**given, **more}}}


@pytest.fixture
def bench(tmp_path):
    """Runs the verb on a CSV file and a map; returns status and output folder."""

    def run(rules: dict, text: str | None = None, *words: str, output="out", further=()):
        (tmp_path / "run.csv").write_text(csv(TIME, POSITION, FORCE) if text is None else text)
        (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules))
        named = ["--columns", str(tmp_path / "map.yaml"), "-o", str(tmp_path / output)]
        return main(["import", str(tmp_path / "run.csv"), *further, *named, *words]), tmp_path / output

    return run


def csv(time, position, force, events=None) -> str:
    events = [""] * len(time) if events is None else events
    lines = [
        f"{t:.6f};{x!r};{f!r};{e}" for t, x, f, e in zip(time, position.tolist(), force.tolist(), events, strict=True)
    ]
    return "Time;Position;Load;Event\n" + "\n".join(lines) + "\n"


def test_channels_arrive_in_si_units_on_the_default_topics(bench):
    status, folder = bench({**channels(), "time": {"column": "Time"}})
    assert status == 0
    with open_bag(folder / "run.mcap") as bag:
        assert [(topic.name, topic.type) for topic in bag.topics] == [
            ("/suspension/displacement", "sensor_msgs/msg/JointState"),
            ("/suspension/force", "sensor_msgs/msg/JointState"),
        ]
        position = bag.columns("suspension/displacement", ["position[front_left]"])
        force = bag.columns("suspension/force", ["effort[front_left]"])
    assert position.values[:, 0] == pytest.approx(POSITION * 1e-3) and force.values[:, 0] == pytest.approx(FORCE)
    assert (position.stamp == position.log).all() and (position.stamp == force.stamp).all()
    assert np.abs(np.diff(position.stamp) - 5_000_000).max() <= 1


def test_a_constant_comes_with_the_first_sample_before_it_and_once_a_second(bench):
    rules = {
        **channels(command={"value": 300, "unit": "mA"}, temperature={"value": 293.15, "unit": "K"}),
        "time": {"rate": RATE},
    }
    _, folder = bench(rules)
    with open_bag(folder / "run.mcap") as bag:
        position = bag.columns("suspension/displacement", [])
        command = bag.columns("suspension/front_left/current", ["data"])
        temperature = bag.columns("suspension/front_left/temperature", ["temperature"])
    assert command.values.tolist() == [[0.3], [0.3]] and temperature.values == pytest.approx(20.0)
    assert command.rank[0] < position.rank[0] and command.log[0] < position.log[0]
    assert np.diff(temperature.stamp).tolist() == [10**9] and temperature.stamp[0] == position.stamp[0]


def test_slow_columns_skip_empty_cells(bench):
    text = "Position;Load;Oil\n" + "".join(
        f"{x};1;{20 + row if row % 10 == 0 else ''}\n" for row, x in enumerate(POSITION)
    )
    status, folder = bench({**channels(temperature={"column": "Oil", "unit": "degC"}), "time": {"rate": RATE}}, text)
    assert status == 0
    with open_bag(folder / "run.mcap") as bag:
        oil = bag.columns("suspension/front_left/temperature", ["temperature"])
    assert oil.values[:, 0].tolist() == [20.0 + row for row in range(0, 400, 10)]


def test_several_dampers_share_the_messages(bench):
    rules = {
        "dampers": {
            "a": {"displacement": {"column": "Position", "unit": "mm"}},
            "b": {"displacement": {"column": "Position", "unit": "cm"}, "force": {"column": "Load", "unit": "N"}},
        },
        "time": {"rate": RATE},
    }
    _, folder = bench(rules)
    with open_bag(folder / "run.mcap") as bag:
        position = bag.columns("suspension/displacement", ["position[a]", "position[b]"])
        force = bag.columns("suspension/force", ["effort[a]", "effort[b]"])
    assert position.values[:, 1] == pytest.approx(10 * position.values[:, 0])
    assert force.present.all(axis=0).tolist() == [False, True]


def test_parts_split_at_events_have_their_constants_and_names(bench):
    events = ["Start", *[""] * 199, "Resume", *[""] * 199]
    rules = {
        **channels(command={"values": [0.0, 1.5], "unit": "A"}),
        "time": {"rate": RATE},
        "split": {"column": "Event", "equals": "Resume"},
        "name": "{stem}_{command}A_{part}",
    }
    _, folder = bench(rules, csv(TIME, POSITION, FORCE, events))
    assert sorted(path.name for path in folder.iterdir()) == ["run_0A_1.mcap", "run_1.5A_2.mcap"]
    with open_bag(folder / "run_1.5A_2.mcap") as bag:
        assert bag.columns("suspension/displacement", ["position[0]"]).values[:, 0] == pytest.approx(
            POSITION[200:] * 1e-3
        )
        assert (bag.columns("suspension/front_left/current", ["data"]).values == 1.5).all()


def test_parts_split_at_pauses(bench):
    time = np.where(TIME < 1.0, TIME, TIME + 7.0)
    _, folder = bench({**channels(), "time": {"column": "Time"}, "split": {"pause": 2.0}}, csv(time, POSITION, FORCE))
    counts = []
    for name in ("run_1.mcap", "run_2.mcap"):
        with open_bag(folder / name) as bag:
            counts.append(bag.topic("suspension/displacement").messages)
    assert counts == [200, 200]


def test_rest_is_trimmed_to_its_margin_and_its_position_becomes_zero(bench):
    text = csv(TIME, POSITION - 29.9, FORCE)
    rules = {**channels(), "time": {"rate": RATE}, "trim_rest": {"margin": 0.1}, "center": "rest"}
    _, folder = bench(rules, text)
    with open_bag(folder / "run.mcap") as bag:
        values = bag.columns("suspension/displacement", ["position[0]"]).values[:, 0]
    assert abs(len(values) - (200 + 2 * 0.1 * RATE)) <= 6
    assert values[:15] == pytest.approx(0.0, abs=1e-9) and values.max() == pytest.approx(0.010, rel=0.01)


def test_mat_files_are_read_by_expression(bench, tmp_path):
    nested = {"data": {"x": POSITION[:, None], "t": TIME}, "F": np.stack([FORCE, FORCE * 2], axis=1)}
    scipy.io.savemat(tmp_path / "run.mat", nested)
    rules = {
        "dampers": {
            "d": {
                "displacement": {"column": "data.x", "unit": "mm"},
                "force": {"column": "F[:,1]", "unit": "N", "scale": 0.5},
            }
        },
        "time": {"column": "data.t"},
    }
    (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules))
    words = [
        "import",
        str(tmp_path / "run.mat"),
        "--columns",
        str(tmp_path / "map.yaml"),
        "-o",
        str(tmp_path / "one.mcap"),
    ]
    assert main(words) == 0
    with open_bag(tmp_path / "one.mcap") as bag:
        assert bag.columns("suspension/force", ["effort[d]"]).values[:, 0] == pytest.approx(FORCE)


def test_the_results_are_one_line_per_part_or_json(bench, capsys):
    rules = {**channels(command={"value": 1, "unit": "V"}), "time": {"rate": RATE}}
    bench(rules)
    line = capsys.readouterr().out
    assert line.count("\n") == 1
    for fact in ("run.mcap: 400 samples, 200 Hz, 1.995 s", "displacement -0.01 to 0.01 m", "command 1 V"):
        assert fact in line
    bench(rules, None, "--json", "-")
    (part,) = json.loads(capsys.readouterr().out)["parts"]
    assert (part["samples"], part["rate_hz"], part["part"]) == (400, pytest.approx(RATE), 1)
    assert part["dampers"]["front_left"]["displacement"] == {
        "min": pytest.approx(-0.01),
        "max": pytest.approx(0.01),
        "unit": "m",
    }
    assert part["dampers"]["front_left"]["command"]["unit"] == "V"


def test_cells_without_numbers_are_counted_and_become_nan(bench, capsys):
    text = csv(TIME, POSITION, FORCE).replace(";0.0;", ";overflow;", 3)
    bench({**channels(), "time": {"rate": RATE}}, text)
    assert "3 cells of front_left.displacement are no numbers" in capsys.readouterr().out


def rules_with(**more) -> dict:
    return {**channels(), "time": {"rate": RATE}, **more}


EVENTS = csv(TIME, POSITION, FORCE, ["a", "", "b", *[""] * 397])
TWO_PARTS = {"split": {"column": "Event", "equals": ["b"]}}
BAD = {
    "missing column": (
        rules_with(**channels(force={"column": "Kraft", "unit": "N"})), None, "'Kraft'; there are: Time, Position",
    ),
    "text column": (rules_with(**channels(force={"column": "Event", "unit": "N"})), None, "are no numbers"),
    "empty": (rules_with(), " \n", "run.csv: empty"),
    "one row": (rules_with(), "Position;Load\n1;2\n", "fewer than two rows"),
    "constants": (
        rules_with(**channels(command={"values": [1, 2, 3], "unit": "A"})), None,
        "3 values of front_left.command, but 1 parts",
    ),
    "name": (rules_with(name="{current}"), None, "cannot be filled in"),
    "folder in name": (rules_with(name="a/b"), None, "is no name for a recording"),
    "same names": (rules_with(name="x", **TWO_PARTS), EVENTS, "several parts would be named x"),
    "pause without times": (rules_with(split={"pause": 1}), None, "pauses cannot be seen at a fixed rate"),
    "unknown key": (rules_with(colour=1), None, "unknown keys colour"),
    "no rate line": (rules_with(time={"rate": {"line": "Rate"}}), None, "no header line begins with 'rate'"),
    "rate of no sense": (rules_with(time={"rate": 1e-9}), None, "are no plausible dates; check time"),
}  # fmt: skip


@pytest.mark.parametrize(("rules", "text", "complaint"), BAD.values(), ids=BAD.keys())
def test_unusable_input_is_one_line_and_leaves_no_file(bench, capsys, rules, text, complaint):
    status, folder = bench(rules, text)
    error = capsys.readouterr().err.splitlines()
    assert status == 1 and complaint in error[-1]
    assert not folder.exists()


def test_several_parts_do_not_fit_one_file(bench, capsys):
    status, path = bench(rules_with(**TWO_PARTS), EVENTS, output="out.mcap")
    assert status == 1 and "2 parts do not fit into one recording; name a folder" in capsys.readouterr().err
    assert not path.exists()


def test_a_bad_file_among_good_ones_leaves_no_file(bench, tmp_path, capsys):
    (tmp_path / "bad.csv").write_text("")
    status, folder = bench(rules_with(), further=[str(tmp_path / "bad.csv")])
    assert status == 1 and not folder.exists()
    assert "bad.csv: empty" in capsys.readouterr().err


def test_an_output_that_cannot_be_created_is_named(bench, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert bench(rules_with(), output="file/out")[0] == 1
    assert "file/out: cannot be created (Not a directory)" in capsys.readouterr().err
    assert bench(rules_with(), output="none/out.mcap")[0] == 1
    assert "none/out.mcap: cannot be written (there is no folder" in capsys.readouterr().err
