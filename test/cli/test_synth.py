"""`synth`: recordings that the other verbs can read, and their true signals."""

import json
from pathlib import Path

import numpy as np
import pytest

from damper_estimator.cli.main import main
from damper_estimator.recordings import open_bag
from damper_estimator.signals import load_signal_map, measure

SHORT = ["--seconds", "7", "--rate", "250"]
GAUGE_NOISE = 8.0
"""N rms: noise, drift and quantisation of the gauge, and what its filter leaves of them."""


def synth(folder: Path, *words: str) -> dict:
    assert main(["synth", "-o", str(folder), *SHORT, *words]) == 0
    return json.loads((folder / "truth.json").read_text())


def topics(path: Path) -> dict[str, tuple[str, int]]:
    with open_bag(path) as bag:
        return {topic.name: (topic.type, topic.messages) for topic in bag.topics}


def test_a_recording_has_the_default_topics_and_the_damper_by_name(tmp_path: Path) -> None:
    truth = synth(tmp_path, "--excitation", "random", "step")
    assert sorted(path.name for path in tmp_path.glob("*.mcap")) == ["random.mcap", "step.mcap"]
    found = topics(tmp_path / "random.mcap")
    assert found["/suspension/displacement"][0] == "sensor_msgs/msg/JointState"
    assert found["/suspension/displacement"][1] == pytest.approx(1750, abs=5)
    assert found["/suspension/passenger_front/temperature"] == ("sensor_msgs/msg/Temperature", pytest.approx(69, abs=2))
    assert "/suspension/passenger_front/current" not in found
    with open_bag(tmp_path / "random.mcap") as bag:
        position = bag.columns("/suspension/displacement", ("position[passenger_front]",)).values
        effort = bag.columns("/suspension/force", ("effort[passenger_front]",)).values
    assert position.std() == pytest.approx(truth["recordings"]["random"]["displacement_rms_m"], rel=0.01)
    assert np.sqrt(np.mean(effort**2)) == pytest.approx(truth["recordings"]["random"]["force_rms_n"], rel=0.02)
    assert truth["hidden"] == []


def test_the_truth_lies_in_a_bag_of_its_own(tmp_path: Path) -> None:
    truth = synth(tmp_path)
    with open_bag(tmp_path / truth["truth_bags"]["random"]) as bag:
        force = bag.columns("/truth/force", ("effort[passenger_front]",))
        travel = bag.columns("/truth/displacement", ("position[passenger_front]",))
    with open_bag(tmp_path / "random.mcap") as bag:
        measured = bag.columns("/suspension/displacement", ("position[passenger_front]",))
    assert np.array_equal(force.stamp, measured.stamp)
    assert np.abs(travel.values - measured.values).max() < 1e-4
    assert np.sqrt(np.mean(force.values**2)) == pytest.approx(truth["recordings"]["random"]["force_rms_n"], rel=0.01)


def test_hiding_writes_base_fit_and_unseen(tmp_path: Path) -> None:
    truth = synth(tmp_path, "--hide", "friction", "--strength", "0.12", "--excitation", "random", "step")
    assert sorted(path.name for path in tmp_path.glob("*.mcap")) == ["base.mcap", "fit.mcap", "unseen.mcap"]
    assert [record["excitation"] for record in truth["recordings"].values()] == ["random", "random", "step"]
    (found,) = truth["hidden"]
    assert found["phenomenon"] == "friction"
    assert truth["fit_strength"] == pytest.approx(0.12, rel=0.03)
    assert truth["parameters"]["base"]["seal"]["force"] == 0.0
    assert truth["parameters"]["fit"]["seal"]["force"] > 0.0
    seeds = {record["seed"] for record in truth["recordings"].values()}
    assert len(seeds) == 3


def test_several_effects_are_hidden_at_once(tmp_path: Path) -> None:
    truth = synth(tmp_path, "--hide", "current", "force_offset", "--excitation", "random10")
    assert [item["phenomenon"] for item in truth["hidden"]] == ["current", "force_offset"]
    assert topics(tmp_path / "fit.mcap")["/suspension/passenger_front/current"][0] == "std_msgs/msg/Float64"
    assert truth["sensors"]["fit"]["force_offset"] != truth["sensors"]["base"]["force_offset"]


def test_a_semi_active_damper_always_records_its_current_and_others_on_request(tmp_path: Path) -> None:
    synth(tmp_path / "coil", "--damper", "semi_active")
    synth(tmp_path / "decoy", "--current")
    assert "/suspension/semi_active/current" in topics(tmp_path / "coil" / "random.mcap")
    assert "/suspension/passenger_front/current" in topics(tmp_path / "decoy" / "random.mcap")


def test_the_signal_map_takes_the_coil_spring_away_again(tmp_path: Path) -> None:
    synth(tmp_path, "--spring", "24000", "--preload", "-3000", "--excitation", "random10")
    (tmp_path / "truth.yaml").write_text(
        "dampers:\n  passenger_front:\n"
        '    displacement: {topic: /truth/displacement, field: "position[passenger_front]"}\n'
        '    force: {topic: /truth/force, field: "effort[passenger_front]"}\n'
    )
    found = []
    for bag_name, map_name in (("random10.mcap", "signals.yaml"), ("truth/random10.mcap", "truth.yaml")):
        with open_bag(tmp_path / bag_name) as bag:
            found.append(measure(bag, load_signal_map(tmp_path / map_name), "passenger_front"))
    measured, true = found
    both = measured.judged & true.judged
    assert np.count_nonzero(both) > 1500
    assert np.std((measured.force - true.force)[both]) < GAUGE_NOISE < 0.05 * np.std(true.force[both])


def test_without_a_spring_no_signal_map_is_needed(tmp_path: Path) -> None:
    synth(tmp_path)
    assert not (tmp_path / "signals.yaml").exists()


def test_a_seed_gives_the_same_recording_again(tmp_path: Path) -> None:
    for folder, seed in (("one", "5"), ("two", "5"), ("three", "6")):
        synth(tmp_path / folder, "--seed", seed)
    one, two, three = ((tmp_path / folder / "random.mcap").read_bytes() for folder in ("one", "two", "three"))
    assert one == two
    assert one != three


def test_a_record_that_hardly_shows_the_effect_says_so(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    truth = synth(tmp_path, "--hide", "inertia", "--excitation", "slow")
    assert "slow hardly excites inertia" in capsys.readouterr().err
    assert truth["fit_strength"] < 0.05


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["--strength", "1.5"], "--strength 1.5 is not between 0 and 1"),
        (["--seconds", "1"], "--seconds 1 is not between 6 and 3600"),
        (["--rate", "0"], "--rate 0 is not between 10 and 5000"),
        (["--rate", "nan"], "--rate nan is not between"),
        (["--seed", "-1"], "--seed -1 is negative"),
        (["--hide", "friction", "friction"], "names friction twice"),
    ],
)
def test_numbers_that_cannot_be_are_refused_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture, words: list[str], complaint: str
) -> None:
    assert main(["synth", "-o", str(tmp_path / "out"), *words]) == 1
    lines = capsys.readouterr().err.strip().splitlines()
    assert len(lines) == 1 and complaint in lines[0]
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("words", [["--damper", "tractor"], ["--hide", "gremlins"], ["--excitation", "moon"]])
def test_unknown_names_are_wrong_usage_and_the_known_ones_are_listed(
    tmp_path: Path, capsys: pytest.CaptureFixture, words: list[str]
) -> None:
    with pytest.raises(SystemExit) as stop:
        main(["synth", "-o", str(tmp_path), *words])
    assert stop.value.code == 2
    assert "choose from" in capsys.readouterr().err


def test_a_folder_that_cannot_be_made_is_refused_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    (tmp_path / "file").write_text("")
    assert main(["synth", "-o", str(tmp_path / "file" / "out"), *SHORT]) == 1
    assert "choose another place with -o" in capsys.readouterr().err


@pytest.mark.parametrize("words", [["--spring", "nan"], ["--spring", "-1"], ["--preload", "nan"]])
def test_a_spring_that_cannot_be_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture, words: list[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        main(["synth", "-o", str(tmp_path / "out"), *words])
    assert stop.value.code == 2 and not (tmp_path / "out").exists()
    assert f"argument {words[0]}: '{words[1]}' is not a finite number" in capsys.readouterr().err
