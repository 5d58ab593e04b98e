"""`fit` with several settings of one damper, and with several objectives."""

import csv
import json

import numpy as np
import pytest

from damper_estimator.cli.main import main
from damper_estimator.model import load_model
from damper_estimator.recordings import BagWriter
from damper_estimator.signals.kinematics import differentiate_recording

RATE = 200.0
KIND = "sensor_msgs/msg/JointState"


@pytest.fixture
def bag(tmp_path):
    """Writes a recording of a damper that equals a model, with a constant command."""

    def write(name, model, seed=0, command=None, speed=1.0):
        random = np.random.default_rng(seed)
        stamp = np.round(np.arange(int(8.0 * RATE)) / RATE * 1e9).astype(np.int64) + 1_700_000_000_000_000_000
        t = np.arange(stamp.size) / RATE
        x = sum(0.02 * speed / f * np.sin(2 * np.pi * f * t + random.uniform(0.0, 6.0)) for f in (0.7, 1.3, 2.9, 9.3))
        kinematics, _ = differentiate_recording(stamp, x, 200.0, 0.1)
        force = model.force(kinematics.block) + random.standard_normal(x.size)
        path = tmp_path / f"{name}.mcap"
        with BagWriter(path) as writer:
            fields = {"header.stamp": stamp, "name": ["left"]}
            writer.write_columns("/suspension/displacement", KIND, stamp, {**fields, "position": x[:, None]})
            writer.write_columns("/suspension/force", KIND, stamp, {**fields, "effort": force[:, None]})
            if command is not None:
                fields = {"data": np.full(stamp.size, command)}
                writer.write_columns("/suspension/left/current", "std_msgs/msg/Float64", stamp, fields)
        return str(path)

    return write


def damper(rebound):
    values = {"linear_viscous.rebound": rebound, "linear_viscous.compression": 1300.0, "static_force.force": -150.0}
    return load_model("linear_viscous").with_values(values)


def values(path):
    return {slot.address: slot.value for slot in load_model(path).slots}


def test_each_position_gets_a_file_and_shared_values_are_equal_in_all(bag, tmp_path, capsys):
    bags = [bag("a", damper(900.0)), bag("b", damper(2600.0), 1), bag("c", damper(2600.0), 2)]
    out = tmp_path / "models"
    words = ["--each", "linear_viscous.rebound", "--by", "soft=a.mcap", "--by", "hard=b,c"]
    assert main(["fit", *bags, "-m", "linear_viscous", "-o", str(out), *words]) == 0
    soft, hard = values(out / "soft.yaml"), values(out / "hard.yaml")
    assert soft["linear_viscous.rebound"] == pytest.approx(900.0, rel=0.02)
    assert hard["linear_viscous.rebound"] == pytest.approx(2600.0, rel=0.02)
    assert soft["linear_viscous.compression"] == hard["linear_viscous.compression"]
    text = capsys.readouterr().out
    assert "soft" in text and "hard" in text and text.count("linear_viscous.compression") == 1


def test_the_command_determines_the_settings(bag, tmp_path, capsys):
    bags = [bag("a", damper(900.0), command=0.0), bag("b", damper(2600.0), 1, command=1.5)]
    words = ["--each", "*rebound", "--by", "command", "--json", "-"]
    assert main(["fit", *bags, "-m", "linear_viscous", "-o", str(tmp_path / "models"), *words]) == 0
    found = json.loads(capsys.readouterr().out)["dampers"]["left"]
    assert found["each"] == ["linear_viscous.rebound"] and set(found["settings"]) == {"0", "1.5"}
    named = {p["name"]: p["value"] for p in found["parameters"]}
    assert named["linear_viscous.rebound@1.5"] == pytest.approx(2600.0, rel=0.02)
    assert found["settings"]["0"]["esr"] < 0.01 and (tmp_path / "models" / "1.5.yaml").exists()


def test_a_front_is_stored_and_another_point_can_be_picked(bag, tmp_path, capsys):
    bags = [bag("fast", damper(900.0)), bag("slow", damper(2600.0), 1, speed=0.2)]
    out, front = tmp_path / "model.yaml", tmp_path / "model.front.csv"
    words = ["fit", *bags, "-m", "linear_viscous", "--method", "nsga2", "--group", "F=fast", "--group", "S=slow.mcap"]
    brief = ["--population", "20", "--generations", "10", "--json", "-"]
    assert main([*words, *brief, "-o", str(out)]) == 0
    captured = capsys.readouterr()
    found = json.loads(captured.out)["dampers"]["left"]["front"]
    assert "generation 10 of 10" in captured.err and found["groups"] == ["F", "S"] and found["excitations"] == [1, 1]
    assert set(found["regimes"]["F"]) == {
        "linear_viscous.rebound",
        "linear_viscous.compression",
        "static_force.force",
    }
    rows = list(csv.DictReader(front.open()))
    assert len(rows) == len(found["values"]) > 5
    assert main([*words, "-o", str(tmp_path / "other.yaml"), "--front", str(front), "--pick", "S"]) == 0
    assert "<- selected" in capsys.readouterr().out
    best = min(rows, key=lambda row: float(row["e_S"]))
    assert values(tmp_path / "other.yaml")["linear_viscous.rebound"] == float(best["linear_viscous.rebound"])
    assert values(tmp_path / "other.yaml")["linear_viscous.rebound"] > values(out)["linear_viscous.rebound"]


@pytest.mark.parametrize("method", ["least_squares", "hooke_jeeves", "nsga2"])
def test_a_limit_is_kept_and_said_to_be_reached(method, bag, tmp_path, capsys):
    out = tmp_path / "model.yaml"
    words = ["--method", method, "--limit", "*rebound=500:2000", "--population", "20", "--generations", "5"]
    assert main(["fit", bag("a", damper(2600.0)), "-m", "linear_viscous", "-o", str(out), *words]) == 0
    assert 1900.0 < values(out)["linear_viscous.rebound"] <= 2000.0
    assert method == "nsga2" or "at a bound: linear_viscous.rebound" in capsys.readouterr().out


REFUSED = {
    "a group without several objectives": (["--group", "F=a"], "--method nsga2"),
    "each without by": (["--each", "static_force"], "require each other"),
    "by without each": (["--by", "command"], "require each other"),
    "a recording that is not there": (["--each", "static_force", "--by", "soft=x.mcap"], "x.mcap is not among"),
    "a recording in no setting": (["--each", "static_force", "--by", "soft=a"], "no setting"),
    "a setting without a name": (["--each", "static_force", "--by", "=a"], "NAME=BAG"),
    "a channel that was not recorded": (["--each", "static_force", "--by", "command"], "has no command"),
    "one setting": (["--each", "static_force", "--by", "soft=a,b"], "needs two"),
    "a recording in no group": (["--method", "nsga2", "--group", "F=a"], "no group"),
    "a limit without ends": (["--limit", "static_force"], "NAME=LOW:HIGH"),
    "a limit that is no number": (["--limit", "static_force=a:b"], "NAME=LOW:HIGH"),
    "a limit of nothing": (["--limit", "*rebound=-9:-5"], "nothing lies between -9 and -5"),
    "a limit of an unknown parameter": (["--limit", "coulomb=0:1"], "no parameter coulomb"),
    "a front that is missing": (["--method", "nsga2", "--front", "none.csv"], "is no front"),
    "a point that is not there": (["--method", "nsga2", "--pick", "best", "--generations", "4"], "knee"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_invalid_options_are_refused_in_one_line(name, bag, tmp_path, capsys):
    words, reason = REFUSED[name]
    bags = [bag("a", damper(900.0)), bag("b", damper(2600.0), 1)]
    assert main(["fit", *bags, "-m", "linear_viscous", "-o", str(tmp_path / "models"), *words]) == 1
    captured = [line for line in capsys.readouterr().err.splitlines() if reason in line]
    assert len(captured) == 1 and not (tmp_path / "models").exists()


def test_a_joint_fit_wants_a_folder(bag, tmp_path, capsys):
    words = ["--each", "static_force", "--by", "x=a", "--by", "y=b", "-o", str(tmp_path / "m.yaml")]
    assert main(["fit", bag("a", damper(900.0)), bag("b", damper(900.0)), "-m", "linear_viscous", *words]) == 1
    assert "folder" in capsys.readouterr().err
