"""Refusals at the start of the node, its end, and its health."""

import re
import signal
import subprocess
import sys

import numpy as np
import pytest

from damper_estimator.errors import InputError
from damper_estimator.recordings import joint_states
from damper_estimator.signals import load_signal_map

JOINT_STATE = "sensor_msgs/msg/JointState"
OK, WARN, ERROR = b"\x00", b"\x01", b"\x02"
ENDED_WITHIN = 120.0  # s, far more than a refusal needs on a busy machine

REFUSED = [
    ({}, "", "parameter model is not set"),
    ({"model": "nonsense"}, "", "nonsense: is neither a model file nor a model's name"),
    ({"model": "broken.yaml"}, "effects: [{viscous_nonsense: {}}]", "broken.yaml: .*viscous_nonsense"),
    ({"model": "broken.yaml"}, "effects: [{linear_viscous: {rebound: -1.0e9}}]", "broken.yaml: .*rebound"),
    ({"model": "coulomb", "signals": "missing.yaml"}, "", "missing.yaml: cannot be read"),
    (
        {"model": "coulomb", "signals": "broken.yaml"},
        "dampers: {left: {displacment: {}}}",
        "broken.yaml: .*displacment",
    ),
    (
        {"model": "coulomb", "signals": "broken.yaml"},
        "dampers: {left: {displacement: {field: 'height[left]'}}}",
        "displacement on .*height.*position",
    ),
    (
        {"model": "coulomb", "signals": "broken.yaml", "dampers": "[right]"},
        "dampers: {left: {}}",
        "dampers: right not in .*left",
    ),
    ({"model": "coulomb", "executor": "fast"}, "", "executor is 'fast'; allowed are events, single"),
    (
        {"model": "coulomb", "qos_reliability": "maybe"},
        "",
        "qos_reliability is 'maybe'; allowed are best_effort, reliable",
    ),
    ({"model": "coulomb", "qos_depth": 0}, "", "qos_depth: must be between 1 and"),
    ({"model": "coulomb", "cutoff": 60}, "", r"cutoff: must be .* written with a point \(60.0\)"),
    ({"model": "coulomb", "max_gap": -1.0}, "", "max_gap: must be between"),
    *(
        ({"model": "coulomb", "signals": "broken.yaml"}, f"dampers: {{left: {{{role}: {{topic: {topic}}}}}}}", reason)
        for role, topic, reason in (
            ("force", "/diagnostics", "broken.yaml: /diagnostics is published by this node"),
            ("displacement", "/rosout", "/rosout is published by this node"),
            ("force", "/damper_estimator/residual", "residual is published by this node"),
            ("displacement", "suspension/left/current_command", "given for sensor_msgs.* and for std_msgs"),
            ("command", "/damper_estimator/desired_force", "given for .* and for .*; use one topic per message type"),
        )
    ),
]


@pytest.mark.parametrize("parameters, content, reason", REFUSED)
def test_unusable_parameters_are_refused_with_the_reason(parameters, content, reason, domain, tmp_path, monkeypatch):
    """In this process; the next test checks that a refusal is one line and ends the node's process."""
    import rclpy

    from damper_estimator.node.estimator_node import EstimatorNode
    from damper_estimator.node.ros_parameters import check_words

    (tmp_path / "broken.yaml").write_text(content)
    monkeypatch.chdir(tmp_path)
    rclpy.init(args=["test", "--ros-args", *(w for n, v in parameters.items() for w in ("-p", f"{n}:={v}"))])
    node = None
    try:
        with pytest.raises(InputError, match=reason) as refusal:
            node = EstimatorNode()
            check_words(node)
            node.start()
    finally:
        if node is not None:
            node.destroy_node()
        rclpy.shutdown()
    assert "\n" not in str(refusal.value)


def test_everything_that_the_node_publishes_is_known_to_the_check_of_its_inputs(domain):
    import rclpy

    from damper_estimator.node.estimator_node import EstimatorNode
    from damper_estimator.node.inputs import OUTPUTS

    rclpy.init(args=["test", "--ros-args", "-p", "model:=coulomb", "-p", "dampers:=[left]"])
    node = EstimatorNode()
    try:
        node.start()
        published = {name for name, _ in node.get_publisher_names_and_types_by_node("damper_estimator", "/")}
        assert published == {node.resolve_topic_name(topic) for topic in OUTPUTS}
    finally:
        node.destroy_node()
        rclpy.shutdown()


@pytest.mark.parametrize("parameters, content, reason", [REFUSED[i] for i in (0, 3, 8, 12)])
def test_unusable_parameters_end_it_in_one_line(parameters, content, reason, start, tmp_path, monkeypatch):
    """Refused before, while and after the parameters are declared."""
    (tmp_path / "broken.yaml").write_text(content)
    monkeypatch.chdir(tmp_path)
    process = start(**parameters)
    said = process.communicate(timeout=ENDED_WITHIN)[1]
    assert process.returncode == 1
    lines = [line for line in said.splitlines() if not line.startswith("[")]  # lines of the log
    assert len(lines) == 1, said
    assert lines[0].startswith("estimator_node: ")
    assert re.search(reason, lines[0]), lines[0]


def test_a_missing_parameter_file_is_refused_in_one_line(start):
    process = start("--params-file", "missing.yaml", model="coulomb")
    said = process.communicate(timeout=ENDED_WITHIN)[1]
    assert process.returncode == 1
    (line,) = [line for line in said.splitlines() if not line.startswith("[")]
    assert line.startswith("estimator_node: ") and "missing.yaml" in line


def level(player, ending: str) -> bytes | None:
    """Level of the status whose name ends so, in the last report; None if there is none."""
    statuses = player.health[-1].status if player.health else ()
    return next((bytes(s.level) for s in statuses if s.name.endswith(ending)), None)


def test_health_follows_the_input(start, identified, player):
    start(model=identified("coulomb"), dampers="[left, right]", stale_after=20.0)
    name = "input /suspension/displacement"
    player.wait(lambda: level(player, name) == WARN, "a warning that nothing has come yet")
    assert level(player, ": left") == WARN
    player.connect({"/suspension/displacement": JOINT_STATE})
    status = next(s for s in player.health[-1].status if s.name.endswith(name))
    assert {pair.key: pair.value for pair in status.values}["publishers"] == "1"
    assert (bytes(status.level), status.message) == (WARN, "there is a publisher, but it has not sent a message yet")
    stamps = np.arange(10**18, 10**18 + 10**8, 10**6)
    messages = joint_states(["left", "stranger"], stamps, position=np.zeros((stamps.size, 2)))
    for first in range(0, stamps.size, 10):
        part = [("/suspension/displacement", message) for message in messages[first : first + 10]]
        player.play(part, {"/suspension/displacement"})
        seen = len(player.health)
        player.wait(lambda seen=seen: len(player.health) > seen, "diagnostics")
        if level(player, name) == OK:
            break
    assert level(player, ": left") == OK
    assert level(player, ": right") == ERROR
    status = next(s for s in player.health[-1].status if s.name.endswith(name))
    assert {pair.key: pair.value for pair in status.values}["names not estimated"] == "stranger"
    player.wait(lambda: level(player, name) == ERROR, "an error that the input has stopped")


def test_a_publisher_that_does_not_match_is_reported(start, player):
    import rclpy
    from rclpy.qos import qos_profile_sensor_data
    from sensor_msgs.msg import JointState

    start(model="coulomb", qos_reliability="reliable")
    node = rclpy.create_node("unreliable")
    node.create_publisher(JointState, "/suspension/displacement", qos_profile_sensor_data)
    player.wait(lambda: level(player, "input /suspension/displacement") == ERROR, "an error")
    node.destroy_node()
    status = next(s for s in player.health[-1].status if "input" in s.name)
    assert "quality of service" in status.message


def test_namespace_and_remapping_move_the_relative_topics(start, tmp_path):
    import rclpy

    from damper_estimator.node.playback.player import Player

    start("-r", "__ns:=/car_7", "-r", "suspension/displacement:=sensors/stroke", model="coulomb")
    rclpy.init()
    player = Player("/car_7/damper_estimator")
    player.connect({"/car_7/sensors/stroke": JOINT_STATE})
    (message,) = joint_states(["left"], np.array([7_000_000_001]), position=np.zeros((1, 1)))
    player.play([("/car_7/sensors/stroke", message)], {"/car_7/sensors/stroke"})
    player.close()
    rclpy.shutdown()
    (answer,) = player.forces
    assert (answer.header.stamp.sec, answer.header.stamp.nanosec, list(answer.name)) == (7, 1, ["left"])


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_it_without_an_error(number, start, player):
    process = start(model="coulomb", dampers="[left]")
    player.wait(lambda: player.health, "diagnostics")
    process.send_signal(number)
    said = process.communicate(timeout=ENDED_WITHIN)[1]
    assert process.returncode == 0
    assert "Traceback" not in said and "rror" not in said.replace("damper_estimator", ""), said


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_while_it_starts_ends_it_without_an_error(number):
    code = (
        "import os, sys, rclpy\nfrom damper_estimator.node import estimator_node, main\nmake = "
        "estimator_node.make_roster\n"
        "def interrupted(settings):\n"
        f"    os.kill(os.getpid(), {int(number)})\n"
        "    while rclpy.ok(): pass\n"
        "    return make(settings)\n"
        "estimator_node.make_roster = interrupted\nsys.exit(main.main())"
    )
    words = [sys.executable, "-c", code, "--ros-args", "-p", "model:=coulomb"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=ENDED_WITHIN)
    assert done.returncode == 0
    assert [line for line in done.stderr.splitlines() if not line.startswith("[INFO]")] == []


def test_the_shipped_parameter_file_with_a_model_starts_it(start, player):
    from damper_estimator.share import share_path

    words = "--params-file", str(share_path("config/node.yaml"))
    said = start(*words).communicate(timeout=ENDED_WITHIN)[1]
    assert "estimator_node: parameter model is not set" in said
    start(*words, "-p", "model:=coulomb")
    player.wait(lambda: level(player, "input /suspension/displacement") == WARN, "diagnostics")
    assert load_signal_map(None).cutoff == 60.0  # the comment in the file says so


def test_the_quality_of_service_of_every_topic_can_be_overridden(start, rig):
    start(
        *("-p", "qos_overrides./suspension/displacement.subscription.depth:=7"),
        *("-p", "qos_overrides./damper_estimator/force.publisher.reliability:=best_effort"),
        model="coulomb",
        dampers="[left]",
    )
    rig.wait(lambda: rig.node.get_publishers_info_by_topic("/damper_estimator/force"), "the forces")
    (info,) = rig.node.get_publishers_info_by_topic("/damper_estimator/force")
    assert info.qos_profile.reliability.name == "BEST_EFFORT"
    assert rig.get("qos_overrides./suspension/displacement.subscription.depth") == 7
    assert rig.get("qos_overrides./suspension/force.subscription.depth") == 2000
    rig.wait(lambda: rig.status(": node") or rig.status(": left"), "diagnostics")
    assert all(status.hardware_id for status in rig.health[-1].status)
