"""The live comparison with the gauge: the residual of ``replay``, a running error, an alarm when it grows."""

import numpy as np
import pytest
from rig import MS, START, joint_state

from damper_estimator.cli.main import main
from damper_estimator.recordings import BagWriter, Stream, joint_states, open_bag

SECOND = 1000 * MS
NAMES = ["left", "right"]


def test_the_live_residual_is_that_of_replay(start, rig, tmp_path):
    """Gauge at another rate and phase, with a gap; bit for bit where both have one. Half a second is sent at once, as
    after a stall, so that one comparison has hundreds of residuals and the topics arrive in any order.
    """
    model = tmp_path / "model.yaml"
    model.write_text("effects: [{linear_viscous: {rebound: 1500.0, compression: 1000.0}}]")
    stamps = START + 2 * MS * np.arange(1000)
    gauge = START + 300_000 + 3 * MS * np.arange(660)
    gauge = gauge[(gauge < START + SECOND) | (gauge > START + int(1.3 * SECOND))]
    time = (stamps - START)[:, None] / 1e9
    position = 0.02 * np.sin(time * [9.0, 15.0])
    force = 1300.0 * np.cos((gauge - START)[:, None] / 1e9 * [9.0, 15.0])
    displacement_messages = joint_states(NAMES, stamps, position=position)
    force_messages = joint_states(NAMES, gauge, effort=force)
    with BagWriter(tmp_path / "bag.mcap") as writer:
        kind = "sensor_msgs/msg/JointState"
        writer.write_streams(
            [
                Stream("/suspension/displacement", kind, stamps, displacement_messages),
                Stream("/suspension/force", kind, gauge, force_messages),
            ]
        )
    assert main(["replay", str(tmp_path / "bag.mcap"), "-m", str(model), "-o", str(tmp_path / "out.mcap")]) == 0
    with open_bag(tmp_path / "out.mcap") as bag:
        expected = bag.columns("/damper_estimator/residual", [f"effort[{name}]" for name in NAMES])
    queue = {"qos_reliability": "reliable", "qos_depth": 2000}
    start(model=model, dampers="[left, right]", stale_after=60.0, **queue)
    rig.ready_for_residuals()
    order = np.argsort(np.concatenate([stamps, gauge]), kind="stable")
    sent = 0
    for place in order.tolist():
        if place < stamps.size:
            rig.send_raw(displacement_messages[place])
            sent += 1
            if sent % 250 == 0:
                rig.wait(lambda sent=sent: rig.answered(0) >= sent, f"{sent} answers")
        else:
            rig.send_raw(force_messages[place - stamps.size], "/suspension/force")
    rig.wait(lambda: len(rig.residuals) >= expected.stamp.size, "residuals")
    live = {m.header.stamp.sec * 10**9 + m.header.stamp.nanosec: list(m.effort) for m in rig.residuals}
    same = [live.get(s) == list(v) for s, v in zip(expected.stamp.tolist(), expected.values, strict=True)]
    assert all(same)
    values = rig.fresh_values(": left")
    assert "error against the gauge [N rms]" in values


def driven(temperatures, scales, window=1.0):
    """A drift after one window per entry."""
    from damper_estimator.node.error_drift import Drift

    drift = Drift("front_left", window, 2.0)
    random = np.random.default_rng(3)
    stamp = START
    for celsius, scale in zip(temperatures, scales, strict=True):
        for _ in range(2):
            stamps = stamp + MS * np.arange(500)
            stamp = int(stamps[-1]) + MS
            v = 0.3 * np.cos(stamps / 1e9 * 9.0)
            force = 1500.0 * v
            residual = scale * force + 5.0 * random.standard_normal(500)
            drift.add(stamps, residual, force, v, 0.03 * np.sin(stamps / 1e9 * 9.0), celsius)
    return drift


def test_a_constant_error_raises_no_alarm():
    random = np.random.default_rng(1)
    drift = driven(20.0 + np.zeros(40), 0.05 + 0.02 * random.random(40))
    assert not drift.is_alarm and drift.error == pytest.approx(0.06, abs=0.02)
    assert drift.sentence().startswith("error ")


def test_an_error_that_grows_with_temperature_is_reported_in_words():
    celsius = np.linspace(20.0, 110.0, 40)
    drift = driven(celsius, 0.04 + 0.0008 * (celsius - 20.0) * (1.0 + 0.1 * np.sin(np.arange(40))))
    assert drift.is_alarm
    sentence = drift.sentence()
    assert sentence.startswith("front_left: error grew from 4 % to ") and sentence.endswith("grows with temperature")


def test_the_alarm_is_withdrawn_when_the_error_is_small_again():
    drift = driven(np.full(30, 20.0), [0.04] * 10 + [0.2] * 10 + [0.04] * 10)
    assert not drift.is_alarm
    assert driven(np.full(20, 20.0), [0.04] * 10 + [0.2] * 10).is_alarm


def test_a_damper_that_stands_still_is_not_judged():
    from damper_estimator.node.error_drift import Drift

    drift = Drift("one", 1.0, 2.0)
    for second in range(10):
        stamps = START + second * SECOND + MS * np.arange(1000)
        noise = np.random.default_rng(second).standard_normal(1000)
        drift.add(stamps, noise, noise, 1e-4 * noise, 1e-5 * noise, 20.0)
    assert not drift.windows and not drift.is_alarm and drift.rms_n == pytest.approx(1.0, rel=0.1)


def test_an_alarm_reaches_the_diagnostics(start, rig, tmp_path):
    model = tmp_path / "model.yaml"
    model.write_text("effects: [{linear_viscous: {rebound: 1500.0, compression: 1500.0}}]")
    start(model=model, dampers="[left]", drift_window=1.0, stale_after=60.0)
    rig.ready_for_residuals()
    stamp = START
    for second in range(14):
        scale = 1.02 if second < 6 else 1.5
        for i in range(0, 1000, 4):
            now = (stamp - START) / 1e9
            force = 1500.0 * scale * 0.3 * np.cos(9.0 * now)
            rig.send_raw(joint_state([0.3 / 9.0 * np.sin(9.0 * now)], ["left"], stamp))
            rig.send_raw(joint_states(["left"], np.array([stamp]), effort=np.array([[force]]))[0], "/suspension/force")
            stamp += 4 * MS
            if i % 40 == 0:
                rig.listen(0.005)
    rig.wait(lambda: "error grew" in rig.message(": left"), "the alarm", 20.0)
    assert rig.status(": left").level == b"\x01"
