"""inspect: what is there, a proposed map, a verdict."""

import json

import numpy as np
import pytest

from damper_estimator.cli.main import main
from damper_estimator.recordings import BagWriter, floats, open_bag
from damper_estimator.signals import load_signal_map, measure

START = 1_700_000_000 * 10**9


def inspect(tmp_path, bag, *words):
    assert main(["inspect", str(bag), "--json", str(tmp_path / "r.json"), *map(str, words)]) == 0
    return json.loads((tmp_path / "r.json").read_text())


def test_topics_rates_and_quality_are_reported(driven, tmp_path, capsys):
    record = inspect(tmp_path, driven(rest=2.0)[0])
    topics = {t["name"]: t for t in record["topics"]}
    assert topics["/suspension/displacement"]["messages"] == 4000
    assert topics["/suspension/displacement"]["rate_hz"] == pytest.approx(500.0, rel=1e-3)
    damper = record["dampers"]["front_left"]
    assert damper["displacement"]["rate_hz"] == pytest.approx(500.0, rel=1e-6) and damper["force"]["samples"] == 4000
    assert damper["rests"] and damper["verdict"]["good"]
    assert "front_left: good enough" in capsys.readouterr().out


def test_the_proposed_map_reads_the_recording(driven, tmp_path):
    bag, *_ = driven()
    inspect(tmp_path, bag, "-o", tmp_path / "map.yaml")
    with open_bag(bag) as opened:
        m = measure(opened, load_signal_map(tmp_path / "map.yaml"), "front_right")
    assert m.judged.sum() == 3900


def test_millimetres_and_a_wrong_sign_are_guessed_and_said(driven, tmp_path):
    bag, *_ = driven(scale=-1000.0)
    guesses = " ".join(inspect(tmp_path, bag, "-o", tmp_path / "map.yaml")["guesses"])
    assert load_signal_map(tmp_path / "map.yaml").dampers["front_left"].displacement.scale == -1e-3
    assert "in mm" in guesses and "compression" in guesses


@pytest.mark.parametrize(("gauge", "fault"), [(0.0, "never changes"), (-1.0, "sign"), (1e-3, "in kN")])
def test_a_force_that_means_nothing_is_a_fault(driven, write_bag, tmp_path, gauge, fault):
    _, stamp, x, measured = driven()
    bag = write_bag("faulty.mcap", ["front_left", "front_right"], stamp, x, gauge * measured)
    (tmp_path / "map.yaml").write_text("dampers: {front_left: {}}")  # otherwise sign and unit are guessed
    damper = inspect(tmp_path, bag, "-s", tmp_path / "map.yaml")["dampers"]["front_left"]
    assert not damper["verdict"]["good"]
    assert any(fault in text for text in damper["verdict"]["faults"])


def test_channels_are_found_by_name_and_type(tmp_path):
    """No JointState: plain numbers, distinguished by their topics."""
    time = np.arange(4000) / 500.0
    x = 0.02 * np.sin(2 * np.pi * 2.0 * time)
    stamp = START + (time * 1e9).astype(np.int64)
    path = tmp_path / "plain.mcap"
    with BagWriter(path) as writer:
        for topic, value in (
            ("/rig/travel", 1e3 * x),
            ("/rig/load_cell", 1500.0 * np.gradient(x, time)),
            ("/rig/coil_current", 0 * x + 0.5),
            ("/rig/address", x),
        ):
            writer.write_messages(topic, "std_msgs/msg/Float64", stamp, floats(value))
    inspect(tmp_path, path, "-o", tmp_path / "map.yaml")
    (signals,) = load_signal_map(tmp_path / "map.yaml").dampers.values()
    assert (signals.displacement.topic, signals.displacement.scale) == ("/rig/travel", 1e-3)
    assert (signals.force.topic, signals.command.topic) == ("/rig/load_cell", "/rig/coil_current")


def test_a_recording_without_force_is_not_good_enough(driven, tmp_path, capsys):
    record = inspect(tmp_path, driven(force=False)[0])
    assert not record["dampers"]["front_left"]["verdict"]["good"]
    assert "no force was measured" in capsys.readouterr().out


def test_real_bags_of_other_things_are_inspected(shared_data, tmp_path, capsys):
    for name in (
        "mcap_talker",
        "sqlite_talker",
        "split_mcap_wbag",
        "mcap_cdr_test",
        "mcap_topics_services",
        "zstd_file_compressed_db3",
    ):
        record = inspect(tmp_path, shared_data / "rosbag2_bags" / name)
        assert record["dampers"] == {}
    assert "no displacement was recognised" in capsys.readouterr().out


def test_no_map_is_written_where_nothing_was_recognised(shared_data, tmp_path, refused):
    line = refused("inspect", shared_data / "rosbag2_bags" / "mcap_talker", "-o", tmp_path / "map.yaml")
    assert "no displacement" in line and not (tmp_path / "map.yaml").exists()


def test_unusable_files_are_one_line(tmp_path, driven, refused):
    (tmp_path / "empty.mcap").write_bytes(b"")
    for path in (tmp_path / "empty.mcap", tmp_path / "missing.mcap"):
        assert path.name in refused("inspect", path)
    assert "'rear'" in refused("inspect", driven()[0], "-d", "rear")


@pytest.mark.parametrize("verb", ["fit", "compare", "diagnose"])
def test_a_force_of_another_time_is_named_by_every_verb(driven, tmp_path, capsys, verb):
    """Two loggers with different clocks: there is a force, and a displacement, but never both."""
    _, stamp, x, measured = driven(names=("left",))
    with BagWriter(tmp_path / "both.mcap") as writer:
        fields = {"header.stamp": stamp, "name": ["left"], "position": x}
        writer.write_columns("/suspension/displacement", "sensor_msgs/msg/JointState", stamp, fields)
        fields = {"header.stamp": stamp + 100 * 10**9, "name": ["left"], "effort": measured}
        writer.write_columns("/suspension/force", "sensor_msgs/msg/JointState", stamp + 100 * 10**9, fields)
    verdict = inspect(tmp_path, tmp_path / "both.mcap")["dampers"]["left"]["verdict"]
    assert not verdict["good"] and any("not recorded at the same time" in text for text in verdict["faults"])
    words = ["-o", str(tmp_path / "m.yaml")] if verb == "fit" else []
    assert main([verb, str(tmp_path / "both.mcap"), "-m", "linear_viscous", *words]) == 1
    assert "was not recorded at the same time as its displacement" in capsys.readouterr().err
