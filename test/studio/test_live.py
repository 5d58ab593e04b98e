"""The studio with a running node: rolling forces and health, the last minutes as a recording, its diagnosis."""

import json
import os
import subprocess
import sys
import sysconfig
from pathlib import Path

import numpy as np
import pytest
from browser import needs_browser, needs_playwright
from studio_page import open_page, served

from damper_estimator.cli.main import main
from damper_estimator.errors import InputError
from damper_estimator.recordings import open_bag
from damper_estimator.studio.callbacks.live_inputs import saved
from damper_estimator.studio.live import Live

NODE = Path(sysconfig.get_path("scripts")) / "estimator_node"
# Answers as the process that listens does, without ROS.
STANDS_IN = """
import json, sys, threading, time
def answer():
    for text in sys.stdin:
        path = json.loads(text)["save"]
        print(json.dumps({"failed": "no room"} if "full" in path else {"saved": path, "messages": 7}), flush=True)
threading.Thread(target=answer, daemon=True).start()
estimates = {"force": [[1.0, 2.0], [10.0, -10.0]], "residual": [[2.0], [3.0]], "status": "degraded", "level": 1,
             "message": "left: error grew from 5 % to 20 % in 3 min", "alarm": True}
print("a library says hello", flush=True)
while True:
    print(json.dumps({"dampers": {"left": estimates}, "held": {"seconds": 4.0, "messages": 7}}), flush=True)
    time.sleep(0.05)
"""
# Two dampers at 500 Hz; the force has a part that a linear damper lacks.
SENSORS = """
import math, time, rclpy
from sensor_msgs.msg import JointState
rclpy.init()
node = rclpy.create_node("sensors")
moved, pushed = (node.create_publisher(JointState, f"/suspension/{name}", 100) for name in ("displacement", "force"))
begin = time.time_ns()
while True:
    now = time.time_ns()
    t = (now - begin) * 1e-9
    x = [0.02 * math.sin(9.0 * t + phase) for phase in (0.0, 1.0)]
    v = [0.18 * math.cos(9.0 * t + phase) for phase in (0.0, 1.0)]
    for publisher, field, values in ((pushed, "effort", [1500.0 * u + 300.0 * math.tanh(u / 0.02) for u in v]),
                                     (moved, "position", x)):
        message = JointState(name=["left", "right"], **{field: values})
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(now, 1_000_000_000)
        publisher.publish(message)
    time.sleep(0.002)
"""


@pytest.fixture
def live():
    live = Live(1.0, (sys.executable, "-c", STANDS_IN))
    yield live
    live.close()


def waited(live):
    with live._lock:
        while "left" not in live.states():
            assert live._lock.wait(300.0)


def test_what_the_node_says_is_on_the_page_and_a_drift_is_an_alarm(live, tmp_path):
    waited(live)
    assert live.states()["left"][0] == "degraded" and live.states()["left"][3]
    figure = live.figures()["left"]
    assert [trace["name"] for trace in figure["data"]] == ["force", "residual"]
    assert live.save(tmp_path / "a.mcap") == 7
    with pytest.raises(InputError, match="no room"):
        live.save(tmp_path / "full.mcap")


def test_an_end_of_the_listener_is_no_end_of_the_studio(live, tmp_path):
    waited(live)
    live._process.kill()
    live._process.wait()
    assert not live.running
    with pytest.raises(InputError):
        live.save(tmp_path / "a.mcap")


def test_minutes_out_of_range_are_refused(tmp_path, capsys):
    assert main(["studio", str(tmp_path), "--live", "900"]) == 1
    assert "between 0 and 60" in capsys.readouterr().err


def test_thinning_keeps_the_extremes_and_leaves_out_what_is_no_number():
    pytest.importorskip("rclpy", reason="ROS 2 is not installed")
    from damper_estimator.node.watch import thinned

    time = np.arange(0.0, 1.0, 1e-3)
    values = np.sin(40.0 * time)
    values[500] = 9.0
    kept = thinned([*zip(time.tolist(), values.tolist(), strict=True), (1.0, float("nan"))])
    assert max(kept[1]) == 9.0 and min(kept[1]) == values.min() and len(kept[0]) <= 2 * 51
    assert kept[0] == sorted(kept[0])
    assert json.loads(json.dumps(kept)) == kept


@pytest.fixture
def running():
    """A node and its sensors on a ROS domain that nothing else uses."""
    for name in ("rclpy", "damper_msgs"):
        pytest.importorskip(name, reason="ROS 2 is not complete here")
    from damper_estimator.node.playback.domain import free_ros_domain

    before = dict(os.environ)
    with free_ros_domain():
        node = [NODE, "--ros-args", "-p", "model:=linear_viscous", "-p", "dampers:=[left, right]"]
        processes = [subprocess.Popen(node), subprocess.Popen([sys.executable, "-c", SENSORS])]
        yield processes
        for process in processes:
            process.terminate()
            process.wait()
    os.environ.clear()
    os.environ.update(before)


@needs_browser
@needs_playwright
def test_a_running_node_is_watched_saved_and_diagnosed(running, tmp_path):
    with served(tmp_path, "--live", "0.2") as (_, url), open_page(url, 1400, 900) as user:
        page = user.page
        user.until(lambda: page.locator("#live-dampers .card").count() == 2)
        user.until(lambda: page.locator("#live .figure .scatterlayer .trace").count() >= 4)
        user.until(lambda: "never identified" in user.text_of("live-dampers"))
        page.click("#freeze")
        user.until(lambda: user.text_of("freeze") == "Resume")
        page.click("#freeze")
        user.until(lambda: float(user.text_of("live-seconds").split()[0]) >= 8.0)
        page.click("#live-save")
        user.until(lambda: "saved live_" in user.text_of("live-words"))
        [path] = tmp_path.glob("live_*.mcap")
        with open_bag(path) as bag:
            topics = {topic.name for topic in bag.topics}
        assert {"/suspension/displacement", "/suspension/force", "/damper_estimator/force"} <= topics
        user.choose("live-model", "linear_viscous")
        page.click("#live-diagnose")
        user.until(lambda: user.text_of("live-words").endswith("diagnosing it"))
        for process in running:  # the machine is the diagnosis's from here on
            process.terminate()
        user.done("diagnosing all")
        user.until(lambda: page.locator(".corner").count() == 2)
        assert "not diagnosed yet" not in user.text_of("corners")
        assert not user.faults and not user.foreign


def test_what_leads_out_of_the_folder_is_not_opened_for_a_diagnosis(session):
    for recording, model in (("../a.mcap", "linear_viscous"), ("hidden_fit.mcap", "/etc/passwd"), ("a\0b", "x.yaml")):
        stage = session.stage
        session.open_and_diagnose(recording, model, "kept")
        session.job.wait()
        assert session.job.state == "failed" and "should not have" not in session.job.error
        assert session.stage is stage


def test_two_saves_in_one_second_are_two_recordings(session):
    class Inputs:
        def save(self, path):
            path.write_bytes(b"")
            return 1

    names = {saved(session, Inputs())[0] for _ in range(5)}
    assert len(names) == 5 and all((session.folder.root / name).exists() for name in names)
