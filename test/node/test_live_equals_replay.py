"""The estimator as a process on real DDS publishes the forces of `replay`, bit for bit, also for disturbed input."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from damper_estimator.cli.main import main
from damper_estimator.recordings import BagWriter, Stream, accelerations, floats, joint_states, temperatures
from damper_estimator.signals import load_signal_map

START = 1_700_000_000_000_000_000
STEP = 2_000_000  # ns, 500 Hz
NAMES = ["front_left", "front_right", "rear"]
GOOD, DEGRADED = 0, 3
TOPIC, JOINT_STATE = "/suspension/displacement", "sensor_msgs/msg/JointState"


def motion(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Jittered stamps (n,) and displacements (n, 3) as from a road."""
    random = np.random.default_rng(5)
    stamps = START + np.cumsum(random.integers(STEP // 2, STEP * 2, count))
    time = (stamps - START)[:, None] / 1e9
    return stamps, 0.02 * np.sin(time * [9.0, 11.0, 80.0]) + 1e-5 * random.standard_normal((count, 3))


def replayed(bag: Path, model: Path | str, *options: str) -> Path:
    """The recording with the forces of the verb `replay`."""
    output = bag.with_name("replayed.mcap")
    assert main(["replay", str(bag), "-m", str(model), "-o", str(output), *options]) == 0
    return output


def rehearsed(player, output: Path, signals: Path | None = None):
    from damper_estimator.node.playback.rehearsal import rehearse

    return rehearse(player, output, load_signal_map(signals))


@pytest.mark.parametrize("executor", ["events", "single"])
def test_every_force_of_a_clean_recording_is_equal(executor, start, player, tmp_path):
    stamps, position = motion(1500)
    with BagWriter(tmp_path / "bag.mcap") as writer:
        writer.write_messages(TOPIC, JOINT_STATE, stamps, joint_states(NAMES, stamps, position=position))
    output = replayed(tmp_path / "bag.mcap", "carrera_akutain")
    start(model="carrera_akutain", executor=executor)
    outcome = rehearsed(player, output)
    assert outcome.replayed == 1500
    assert outcome.is_equal, outcome
    assert max(abs(force) for message in player.forces for force in message.force) > 100.0


def disturbed() -> list[tuple[np.ndarray, list[bytes]]]:
    """Messages with every fault of an input: (log times, serialised messages), in order of arrival."""
    stamps, position = motion(900)
    position[100, 0] = np.nan
    position[101, 1] = np.inf
    position[102] = -np.inf
    position[103, 2] = 1e300
    stamps[200] = stamps[199]  # equal
    stamps[301] = stamps[299] - 1000  # older, within the largest gap
    stamps[400:] += 10**9  # a gap
    stamps[500:] -= 5 * 10**9  # the clock is set back
    stamps[600:] += 3600 * 10**9  # and forward
    names = [NAMES] * 900
    names[700] = NAMES[::-1]  # order changes
    names[701] = ["front_left", "unknown", "rear"]  # one is missing
    names[702] = ["unknown"] * 3
    messages = [joint_states(n, stamps[i : i + 1], position=position[i : i + 1])[0] for i, n in enumerate(names)]
    messages[710] = joint_states(NAMES, stamps[710:711])[0]  # no positions
    messages[711] = joint_states([], stamps[711:712])[0]  # empty
    messages[712] = joint_states(NAMES, stamps[712:713], position=position[712:713, :2])[0]  # one position too few
    messages[713] = joint_states(["front_left"] * 3, stamps[713:714], position=position[713:714])[0]  # names thrice
    log = START + STEP * np.arange(900)
    return [(log[i : i + 1], [message]) for i, message in enumerate(messages)]


def test_disturbed_input_is_answered_like_replay_and_counted(start, player, tmp_path):
    with BagWriter(tmp_path / "bag.mcap") as writer:
        for log, messages in disturbed():
            writer.write_messages(TOPIC, JOINT_STATE, log, messages)
    (tmp_path / "map.yaml").write_text("dampers: {front_left: {}, front_right: {}, rear: {}}")
    output = replayed(tmp_path / "bag.mcap", "carrera_akutain", "-s", str(tmp_path / "map.yaml"))
    process = start(model="carrera_akutain", signals=tmp_path / "map.yaml", executor="single")
    outcome = rehearsed(player, output, tmp_path / "map.yaml")
    assert outcome.is_equal, outcome
    for message in player.forces:
        assert all(np.isfinite(f) for f, s in zip(message.force, message.status, strict=True) if s == GOOD)
    assert process.poll() is None
    expected = {
        "front_left": {"samples": 897, "dropped: not finite": 2, "not in the message": 3},
        "front_right": {"samples": 895, "dropped: not finite": 2, "not in the message": 5},
        "rear": {"samples": 895, "dropped: not finite": 2, "not in the message": 5},
    }
    common = {"dropped: equal stamp": 1, "dropped: older stamp": 1, "resets: gap": 2, "resets: clock stepped back": 1}
    reported = values_by_damper(player)
    for name, counts in expected.items():
        assert {key: int(reported[name][key]) for key in counts | common} == counts | common, name


def values_by_damper(player) -> dict[str, dict[str, str]]:
    """The counts of the next complete report."""
    seen = len(player.health)
    player.wait(lambda: len(player.health) > seen + 1, "diagnostics")
    return {s.name.split(": ")[1]: {pair.key: pair.value for pair in s.values} for s in player.health[-1].status}


def test_signal_map_and_slow_channels_act_live_as_offline(start, player, tmp_path):
    """Two displacement topics, scale, offset, table, and a temperature and a command that change on the way."""
    stamps, position = motion(600)
    signals = {
        "filter": {"cutoff": 35.0},
        "dampers": {
            "left": {
                "displacement": {"topic": "/bench/a", "field": "position[stroke]", "scale": -0.001, "offset": 0.01},
                "temperature": {"topic": "/bench/oil", "field": "temperature"},
            },
            "right": {
                "displacement": {
                    "topic": "/bench/b", "field": "effort[0]",
                    "table": {"raw": [-1.0, -0.01, 0.012, 1.0], "value": [-0.9, -0.012, 0.01, 0.8]},
                },
                "temperature": {"topic": "/bench/number", "field": "temperature", "scale": 2.0},
                "command": {"topic": "/bench/current", "field": "data", "unit": "A"},
            },
        },
    }  # fmt: skip
    model = {"name": "fading", "effects": [{"viscous_curve": {}}, {"temperature_gain": {"fade": 0.01}}]}
    for name, content in (("map.yaml", signals), ("model.yaml", model)):
        (tmp_path / name).write_text(yaml.safe_dump(content))
    slow = slice(50, None, 200)
    with BagWriter(tmp_path / "bag.mcap") as writer:
        writer.write_messages(
            "/bench/a", JOINT_STATE, stamps, joint_states(["stroke"], stamps, position=1e3 * position[:, :1])
        )
        writer.write_messages("/bench/b", JOINT_STATE, stamps + 1, joint_states(["x"], stamps, effort=position[:, 1:2]))
        for topic, later in (("/bench/oil", 2), ("/bench/number", 3)):
            celsius = temperatures(stamps[slow], 30.0 + 15.0 * np.arange(stamps[slow].size) + later)
            writer.write_messages(topic, "sensor_msgs/msg/Temperature", stamps[slow] + later, celsius)
        writer.write_messages(
            "/bench/current", "std_msgs/msg/Float64", stamps[slow] + 4, floats(np.arange(stamps[slow].size))
        )
    output = replayed(tmp_path / "bag.mcap", tmp_path / "model.yaml", "-s", str(tmp_path / "map.yaml"))
    start(model=tmp_path / "model.yaml", signals=tmp_path / "map.yaml")
    outcome = rehearsed(player, output, tmp_path / "map.yaml")
    assert outcome.replayed == 1200
    assert outcome.is_equal, outcome


def test_a_fused_accelerometer_and_reachable_forces_are_live_as_offline(start, identified, player, tmp_path):
    """The accelerometer becomes silent on the way."""
    stamps, position = motion(500)
    current = "/suspension/left/current"
    signals = {
        "filter": {"cutoff": 60.0, "fusion": {"acceleration_noise": 0.5}},
        "dampers": {"left": {"command": {"topic": current, "limits": [0.0, 1.8]}}},
    }
    (tmp_path / "map.yaml").write_text(yaml.safe_dump(signals))
    felt = stamps[:400:4] - 1000
    vertical = -0.02 * 81.0 * np.sin((felt - START) / 1e9 * 9.0) + 0.3
    with BagWriter(tmp_path / "bag.mcap") as writer:
        writer.write_streams([
            Stream(current, "std_msgs/msg/Float64", stamps[10::100] - 500, floats(0.3 * np.arange(5))),
            Stream(
                "/suspension/left/acceleration", "geometry_msgs/msg/AccelStamped", felt, accelerations(felt, vertical)
            ),
            Stream(TOPIC, JOINT_STATE, stamps, joint_states(["left"], stamps, position=position[:, :1])),
        ])  # fmt: skip
    model = identified("semi_active_on_mount", command=[0.0, 1.8])
    output = replayed(tmp_path / "bag.mcap", model, "-s", str(tmp_path / "map.yaml"))
    start(model=model, signals=tmp_path / "map.yaml")
    outcome = rehearsed(player, output, tmp_path / "map.yaml")
    assert outcome.replayed == 500
    assert outcome.is_equal, outcome
    # It is fused: without delay, and degraded after the accelerometer has become silent.
    time = (stamps - START) / 1e9
    velocity = np.array([message.velocity[0] for message in player.forces])
    assert np.sqrt(np.mean((velocity - 0.18 * np.cos(9.0 * time))[200:390] ** 2)) < 0.01
    status = [message.status[0] for message in player.forces]
    assert set(status[300:390]) == {GOOD} and status[-1] == DEGRADED
    reach = np.array([[m.force_min[0], m.force_max[0], m.dforce_dcurrent[0]] for m in player.forces[30:]])
    assert np.isfinite(reach).all() and np.all(reach[:, 0] <= reach[:, 1]) and np.ptp(reach[:, 1]) > 100.0


def test_a_difference_is_detected():
    from damper_msgs.msg import DamperForces

    from damper_estimator.node.playback.rehearsal import compared

    one, other, late = (DamperForces(name=["a"], force=[force]) for force in (1.0, np.nextafter(1.0, 2.0), 1.0))
    late.header.stamp.sec = 1
    assert compared([one], [one]).is_equal
    for live in ([other], [late], [], [one, one]):
        assert not compared([one], live).is_equal
