"""replay: the line of the node over a file, in order of arrival."""

import json
from pathlib import Path

import numpy as np
import pytest

from damper_estimator.cli.main import main
from damper_estimator.model import load_model
from damper_estimator.recordings import BagWriter, joint_states, open_bag
from damper_estimator.runtime import DamperEstimator, deployed
from damper_estimator.signals import SignalMap, load_signal_map, measure
from damper_estimator.signals.channels import signals_for
from damper_estimator.workflows import ReplaySetup, replay_bag

JOINT_STATE = "sensor_msgs/msg/JointState"
FORCE, RESIDUAL = "/damper_estimator/force", "/damper_estimator/residual"
FIELDS = ("displacement", "velocity", "acceleration", "force", "status")


def replay(bag, model, out, *words):
    assert main(["replay", str(bag), "-m", str(model), "-o", str(out), *map(str, words)]) == 0
    return out


def read(path, topic, *paths):
    with open_bag(path) as bag:
        return bag.columns(topic, paths)


def messages(path, topic):
    with open_bag(path) as bag:
        return [message for batch in bag.batches([topic]) for _, message in batch.messages(topic)]


def sample_by_sample(model_file, stamp, x, **held):
    """What the node would do, one sample at a time: stamps and fields of the estimates."""
    estimator = DamperEstimator(deployed(load_model(model_file), 60.0, 0.1))
    stamps, rows = [], []
    for i in range(stamp.size):
        slow = {role: values[i] for role, values in held.items()}
        estimates = estimator.block(stamp[i : i + 1], x[i : i + 1], **slow)
        if estimates.force.size:
            fields = estimates.fields()
            stamps.append(int(stamp[i]))
            rows.append([fields[name][0] for name in FIELDS])
    return np.array(stamps), np.array(rows)


def test_forces_equal_a_sample_by_sample_run_bit_for_bit(driven, model_file, tmp_path):
    bag, stamp, x, _ = driven()
    out = replay(bag, model_file, tmp_path / "out.mcap")
    for k, damper in enumerate(("front_left", "front_right")):
        columns = read(out, FORCE, *(f"{name}[{damper}]" for name in FIELDS))
        stamps, expected = sample_by_sample(model_file, stamp, x[:, k])
        assert np.array_equal(columns.stamp, stamps) and np.array_equal(columns.values, expected)


@pytest.mark.parametrize("size", [1, 7, 1000])
def test_the_size_of_blocks_changes_no_bit(size, driven, model_file, tmp_path):
    bag, _, _, _ = driven(
        seconds=2.0, temperature={"front_left": (1_700_000_000 * 10**9 + np.arange(20) * 10**8, np.arange(20.0))}
    )
    paths = [f"{name}[{damper}]" for name in FIELDS for damper in ("front_left", "front_right")]
    whole = replay(bag, model_file, tmp_path / "whole.mcap")
    with open_bag(bag) as opened, BagWriter(tmp_path / "parts.mcap") as writer:
        chosen = signals_for(opened, SignalMap())
        models = {name: load_model(model_file) for name in chosen.dampers}
        replay_bag(opened, ReplaySetup(chosen, models), writer, size=size)
    for topic, fields in ((FORCE, paths), (RESIDUAL, ["effort[front_left]", "effort[front_right]"])):
        one, other = (read(path, topic, *fields) for path in (whole, tmp_path / "parts.mcap"))
        assert np.array_equal(one.stamp, other.stamp) and np.array_equal(one.log, other.log)
        assert np.array_equal(one.values, other.values)


def test_input_topics_are_copied_as_they_were(driven, model_file, tmp_path):
    bag, *_ = driven(seconds=1.0)
    out = replay(bag, model_file, tmp_path / "out.mcap")

    def raw(path):
        with open_bag(path) as opened:
            topics = [t.name for t in opened.topics if t.name.startswith("/suspension")]
            return [(c.topic, c.schema.type, log, data) for b in opened.batches(topics) for c, log, data in b.raw()]

    assert raw(bag) == raw(out)


def test_estimates_have_the_inputs_stamp_and_log_time(driven, model_file, tmp_path):
    late = np.arange(4000) % 7 * 100_000 + 5_000_000
    path, stamp, _, _ = driven()
    path, stamp, _, _ = driven(name="late.mcap", log=stamp + late)
    columns = read(replay(path, model_file, tmp_path / "out.mcap"), FORCE, "force[0]")
    order = np.argsort(stamp + late, kind="stable")
    assert np.array_equal(columns.log, (stamp + late)[order])
    assert set(columns.stamp) <= set(stamp)


def test_the_residual_is_model_less_measured_through_the_same_filter(driven, model_file, tmp_path):
    bag, *_ = driven()
    out = replay(bag, model_file, tmp_path / "out.mcap")
    with open_bag(bag) as opened:
        m = measure(opened, SignalMap(), "front_right")
    expected = load_model(model_file).force(m.kinematics.block) - m.force
    columns = read(out, RESIDUAL, "effort[front_right]")
    assert np.array_equal(columns.stamp, m.kinematics.stamp)
    assert columns.values[:, 0] == pytest.approx(expected, abs=1e-9)


def test_spring_preload_and_skew_enter_the_residual(driven, model_file, tmp_path):
    bag, *_ = driven()
    chain = (
        "{topic: suspension/force, field: 'effort[front_left]', skew: 0.0031, spring_rate: 20000.0, preload: -300.0}"
    )
    (tmp_path / "map.yaml").write_text(f"dampers: {{front_left: {{force: {chain}}}}}")
    out = replay(bag, model_file, tmp_path / "out.mcap", "-s", tmp_path / "map.yaml")
    with open_bag(bag) as opened:
        m = measure(opened, load_signal_map(tmp_path / "map.yaml"), "front_left")
    columns = read(out, RESIDUAL, "effort[front_left]")
    chosen = np.isin(m.kinematics.stamp, columns.stamp) & m.judged
    expected = load_model(model_file).force(m.kinematics.block) - m.force
    assert chosen.sum() > 3800
    assert columns.values[np.isin(columns.stamp, m.kinematics.stamp[chosen]), 0] == pytest.approx(
        expected[chosen], abs=1e-6
    )


def test_slow_channels_hold_what_arrived_last(driven, write_current, tmp_path):
    """By arrival, not by any stamp; a model that answers to the temperature shows it."""
    model = tmp_path / "fading.yaml"
    model.write_text("name: f\nsource: t\neffects:\n  - linear_viscous: {}\n  - temperature_gain: {fade: 0.01}\n")
    (tmp_path / "map.yaml").write_text("dampers: {front_left: {temperature: {topic: /celsius, field: data}}}")
    bag, stamp, x, _ = driven(seconds=1.0, names=("front_left",))
    arrive = stamp[0] + np.array([100_000_500, 400_000_500])
    bag = write_current(bag, "with.mcap", "/celsius", arrive, np.array([50.0, 90.0]))
    out = replay(bag, model, tmp_path / "out.mcap", "-s", tmp_path / "map.yaml")
    celsius = np.where(stamp < arrive[0], np.nan, np.where(stamp < arrive[1], 50.0, 90.0))
    _, expected = sample_by_sample(model, stamp, x[:, 0], temperature=celsius)
    got = read(out, FORCE, *(f"{name}[0]" for name in FIELDS)).values
    assert np.array_equal(got, expected)
    _, cold = sample_by_sample(model, stamp, x[:, 0])
    answer = got[1:, 3] / cold[1:, 3]
    assert answer[49] == 1.0 and answer[60] == pytest.approx(0.9) and answer[300] == pytest.approx(0.5)


def test_drops_and_resets_are_the_nodes(write_bag, model_file, tmp_path, capsys):
    step = 2_000_000
    stamp = 1_700_000_000 * 10**9 + np.arange(1000, dtype=np.int64) * step
    log = stamp.copy()
    stamp[100] = stamp[99]  # equal
    stamp[200] = stamp[190]  # older
    stamp[400:] += 500_000_000  # gap
    stamp[700:] -= 800_000_000  # step back
    x = 0.01 * np.sin(np.arange(1000) / 25.0)[:, None]
    x[300] = np.nan
    bag = write_bag("bad.mcap", ["one"], stamp, x, log=log)
    out = replay(bag, model_file, tmp_path / "out.mcap", "--json", tmp_path / "r.json")
    record = json.loads((tmp_path / "r.json").read_text())["dampers"]["one"]
    counts = {
        name: record[name]
        for name in ("duplicates", "inversions", "non_finite", "gaps", "steps_back", "samples", "estimates")
    }
    assert counts == {
        "duplicates": 1,
        "inversions": 1,
        "non_finite": 1,
        "gaps": 1,
        "steps_back": 1,
        "samples": 1000,
        "estimates": 997,
    }
    columns = read(out, FORCE, *(f"{name}[one]" for name in FIELDS))
    stamps, expected = sample_by_sample(model_file, stamp, x[:, 0])
    assert np.array_equal(columns.stamp, stamps) and np.array_equal(columns.values, expected)
    status = columns.values[:, FIELDS.index("status")]
    assert (status[:100] == 1).all() and (status[100:199] == 0).all() and (status[397:490] == 1).all()
    assert (status[199:297] == 3).all() and (status[298:396] == 3).all()  # 0.2 s from the older stamp and the NaN on
    assert "997 estimates of 1000 samples" in capsys.readouterr().out


def test_a_name_that_is_not_in_every_message_is_left_out_there(model_file, tmp_path):
    stamp = 1_700_000_000 * 10**9 + np.arange(600, dtype=np.int64) * 2_000_000
    x = 0.01 * np.sin(np.arange(600) / 20.0)
    path = tmp_path / "in.mcap"
    with BagWriter(path) as writer:
        for i in range(600):
            names = ["a", "b"] if i % 3 else ["b"]
            values = np.array([[x[i]] * len(names)])
            writer.write_messages(
                "/suspension/displacement",
                JOINT_STATE,
                stamp[i : i + 1],
                joint_states(names, stamp[i : i + 1], position=values),
            )
    out = messages(replay(path, model_file, tmp_path / "out.mcap"), FORCE)
    assert [m.name for m in out] == [["b", "a"] if i % 3 else ["b"] for i in range(600)]
    chosen = np.arange(600) % 3 > 0
    _, alone = sample_by_sample(model_file, stamp[chosen], x[chosen])
    assert [m.force[1] for m in out if len(m.name) == 2] == alone[:, FIELDS.index("force")].tolist()


def test_dampers_on_separate_topics_have_separate_messages(model_file, tmp_path):
    stamp = 1_700_000_000 * 10**9 + np.arange(500, dtype=np.int64) * 2_000_000
    x = 0.01 * np.sin(np.arange(500) / 20.0)[:, None]
    path = tmp_path / "in.mcap"
    with BagWriter(path) as writer:
        writer.write_messages("/left/travel", JOINT_STATE, stamp, joint_states(["only"], stamp, position=1000 * x))
        writer.write_messages("/right/travel", JOINT_STATE, stamp + 7, joint_states(["only"], stamp + 7, position=-x))
    (tmp_path / "map.yaml").write_text(
        "dampers:\n  left: {displacement: {topic: /left/travel, field: 'position[only]', scale: 0.001}}\n"
        "  right: {displacement: {topic: /right/travel, field: 'position[0]', scale: -1.0}}\n"
    )
    out = messages(replay(path, model_file, tmp_path / "out.mcap", "-s", tmp_path / "map.yaml"), FORCE)
    assert [m.name for m in out] == [["left"], ["right"]] * 500
    assert [m.force[0] for m in out[::2]] == pytest.approx([m.force[0] for m in out[1::2]], rel=1e-9)


def test_a_folder_of_models_gives_each_damper_its_own(driven, model_file, tmp_path):
    bag, *_ = driven(seconds=1.0, force=False)
    folder = tmp_path / "models"
    folder.mkdir()
    (folder / "front_left.yaml").write_text(model_file.read_text())
    (folder / "front_right.yaml").write_text(model_file.read_text().replace("1500.0", "3000.0"))
    columns = read(
        replay(bag, folder, tmp_path / "out.mcap"),
        FORCE,
        "force[front_left]",
        "velocity[front_left]",
        "force[front_right]",
    )
    assert np.isfinite(columns.values).all() and not np.array_equal(columns.values[:, 0], columns.values[:, 2])


def test_only_the_chosen_damper_and_time_are_estimated(driven, model_file, tmp_path):
    bag, _, _, _ = driven(seconds=3.0)
    columns = replay(bag, model_file, tmp_path / "out.mcap", "-d", "front_right", "--from", 1.0, "--to", 2.0)
    out = messages(columns, FORCE)
    assert {tuple(m.name) for m in out} == {("front_right",)} and len(out) == 501


def test_a_bag_without_force_has_no_residual(driven, model_file, tmp_path):
    bag, *_ = driven(seconds=1.0, force=False)
    with open_bag(replay(bag, model_file, tmp_path / "out.mcap")) as out:
        assert RESIDUAL not in {t.name for t in out.topics}


def test_an_older_output_is_replaced_and_the_input_never(driven, model_file, tmp_path, refused):
    bag, *_ = driven(seconds=1.0)
    out = tmp_path / "out.mcap"
    out.write_text("an older one")
    replay(bag, model_file, out)
    content = bag.read_bytes()
    (tmp_path / "link.mcap").symlink_to(bag)
    for target in (bag, tmp_path / "link.mcap"):
        assert "is the recording itself" in refused("replay", bag, "-m", model_file, "-o", target)
    assert bag.read_bytes() == content and out.stat().st_size > 1000


def leftovers(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir() if "out" in path.name or path.name.endswith(".part")}


def test_unusable_input_is_one_line_and_leaves_nothing(driven, model_file, tmp_path, refused):
    bag, *_ = driven(seconds=1.0)
    out = tmp_path / "out.mcap"
    (tmp_path / "topic.yaml").write_text("dampers: {a: {displacement: {topic: /nowhere}}}")
    (tmp_path / "field.yaml").write_text(
        "dampers: {a: {displacement: {topic: /suspension/displacement, field: 'positions[a]'}}}"
    )
    (tmp_path / "name.yaml").write_text(
        "dampers: {a: {displacement: {topic: /suspension/displacement, field: 'position[a]'}}}"
    )
    for words, message in (
        (["-s", tmp_path / "topic.yaml"], "/nowhere"),
        (["-s", tmp_path / "field.yaml"], "positions"),
        (["-s", tmp_path / "name.yaml"], "position[a]"),
        (["-d", "rear"], "rear"),
    ):
        line = refused("replay", bag, "-m", model_file, "-o", out, *words)
        assert message in line and leftovers(tmp_path) == set()
    assert "no_model" in refused("replay", bag, "-m", "no_model", "-o", out)
    assert "missing.mcap" in refused("replay", tmp_path / "missing.mcap", "-m", model_file, "-o", out)
    assert "folder" in refused("replay", bag, "-m", model_file, "-o", tmp_path / "absent" / "out.mcap")
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(bag.read_bytes()[:3000])
    assert "cut.mcap" in refused("replay", cut, "-m", model_file, "-o", out)
    assert leftovers(tmp_path) == set()


@pytest.mark.parametrize("value", ["-1", "0", "nan", "inf", "long"])
def test_a_gap_that_cannot_be_is_refused(value, tmp_path, capsys):
    with pytest.raises(SystemExit) as stopped:
        main(["replay", "a.mcap", "-m", "coulomb", "-o", str(tmp_path / "out.mcap"), "--max-gap", value])
    assert stopped.value.code == 2
    assert f"argument --max-gap: '{value}' is not a finite number above 0" in capsys.readouterr().err
