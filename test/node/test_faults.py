"""Every fault of an input of the running node: survived, answered with numbers, counted, reported."""

import ctypes
import os
import resource
import signal
import time

import numpy as np
import pytest
import yaml
from rig import MS, START, joint_state
from semi_active import FIT

from damper_estimator.recordings import temperatures

GOOD, WARMING_UP, EXTRAPOLATING, DEGRADED, STALE = range(5)
SECOND = 1000 * MS


def settle(rig, names=("left",)) -> None:
    """A good input until the estimates are good."""
    answers = rig.drive(260, names)
    assert set(answers[-1].status) == {GOOD}


def checked(rig) -> None:
    """Every received force is a number."""
    for message in rig.forces:
        assert np.isfinite(message.force).all()
        assert len(message.force) == len(message.status) == len(message.name)


@pytest.mark.parametrize("executor", ["events", "single"])
def test_an_input_that_stops_is_stale_in_time_and_good_again_afterwards(executor, start, identified, rig):
    start(model=identified("linear_viscous"), dampers="[left, right]", stale_after=0.2, executor=executor)
    rig.ready()
    settle(rig, ["left", "right"])
    last = rig.forces[-1]
    rig.wait(lambda: STALE in rig.forces[-1].status, "STALE")
    stale = rig.forces[-1]
    assert list(stale.status) == [STALE, STALE] and list(stale.name) == ["left", "right"]
    assert stale.header.stamp == last.header.stamp and list(stale.force) == list(last.force)
    rig.wait(lambda: "stopped" in rig.message(": left"), "the report")
    # One of two is missing: only that one is stale.
    rig.stamp += SECOND
    for _ in range(600):
        rig.send([0.001], ["left"])
        rig.listen(0.002)
    alone = [m for m in rig.forces if STALE in m.status][-1]
    assert list(alone.name) == ["right"]
    assert GOOD in [m.status[0] for m in rig.forces[-5:] if list(m.name) == ["left"]]
    assert int(rig.fresh_values(": right")["not in the message"]) == 600
    checked(rig)


def test_an_input_that_stops_before_a_parameter_is_set_is_stale_as_well(start, identified, rig):
    start(model=identified("linear_viscous"), dampers="[left]", stale_after=2.0)
    rig.ready()
    settle(rig)
    last = rig.forces[-1]
    assert rig.set(max_gap=0.3)[0]
    rig.wait(lambda: STALE in rig.forces[-1].status, "STALE")
    assert rig.forces[-1].header.stamp == last.header.stamp and list(rig.forces[-1].force) == list(last.force)
    settle(rig)
    checked(rig)


def test_names_that_are_numbers_or_have_brackets_do_not_confuse_the_node(start, identified, rig):
    """Dampers that arrive by name: each gets its own displacement, and a strange name harms no other one."""
    start(model=identified("linear_viscous"))
    rig.ready()
    names = ["2", "1", "left[m]"]
    for k in range(400):
        rig.send([0.002 * number * np.sin(0.02 * k) for number in (2.0, 1.0, 3.0)], names)
        rig.listen(0.002)
    rig.wait(lambda: bool(rig.forces) and set(rig.forces[-1].status) == {GOOD}, "good estimates")
    force = dict(zip(rig.forces[-1].name, rig.forces[-1].force, strict=True))
    rates = {name: force[name] for name in names}
    assert rates["2"] == pytest.approx(2.0 * rates["1"], rel=0.05)
    assert rates["left[m]"] == pytest.approx(3.0 * rates["1"], rel=0.05)
    checked(rig)


def test_implausible_values_are_dropped_counted_and_degrade(shared, identified, rig):
    shared(rig, model=identified("carrera_akutain"))
    rig.ready()
    settle(rig)
    before = dict(rig.fresh_values(": left"))
    for value in (np.nan, np.inf, -np.inf, 1e300, -1e12):
        rig.send([value])
    (answer,) = rig.drive(1)
    assert answer.status[0] == DEGRADED
    rig.send([0.5])  # an outlier
    rig.send([0.0])
    settle(rig)
    after = rig.fresh_values(": left")
    new = {key: int(after[key]) - int(before[key]) for key in ("dropped: not finite", "jumps", "samples", "estimates")}
    assert new["dropped: not finite"] == 5 and new["samples"] - new["estimates"] == 5
    assert new["jumps"] >= 2
    checked(rig)


def test_a_slow_channel_that_was_never_heard_is_named_with_the_reason(start, rig, tmp_path):
    effects = [{"viscous": {"rate": 800.0}}, {"temperature_gain": {"fade": 0.01}}]
    model = tmp_path / "model.yaml"
    model.write_text(yaml.safe_dump({"effects": effects, "fit": FIT | {"region": {"displacement": [-0.1, 0.1]}}}))
    start(model=model, dampers="[left]", stale_after=60.0)
    rig.ready()
    assert rig.drive(300)[-1].status[0] == EXTRAPOLATING
    reason = "no temperature yet on /suspension/left/temperature, and the force depends on it: it has no publisher"
    rig.wait(lambda: reason in rig.message(": left"), "the reason", patience=60.0)
    assert int(rig.fresh_values(": left")["temperature: samples before the first value"]) >= 300
    warm = rig.publisher("/suspension/left/temperature", "sensor_msgs/msg/Temperature")
    rig.wait(lambda: rig.values(": left")["temperature: publishers"] == "1", "the publisher")
    warm.publish(temperatures(np.array([rig.stamp]), np.array([40.0]))[0])
    rig.wait(lambda: rig.drive(600)[-1].status[0] == GOOD, "a good estimate", patience=60.0)
    rig.wait(lambda: "no temperature" not in rig.message(": left"), "a report without the reason")


def test_clock_steps_and_disorder_are_dropped_or_reset_the_filter(shared, identified, rig):
    shared(rig, model=identified("carrera_akutain"))
    rig.ready()
    settle(rig)
    now = rig.stamp
    rig.send([0.0], stamp=now)  # a duplicate
    rig.send([0.0], stamp=now - 5 * MS)  # late
    rig.stamp += 20 * MS
    answers = rig.drive(2)  # twenty steps at once
    assert answers[-1].status[0] == DEGRADED
    settle(rig)
    for jump in (3600 * SECOND, -7200 * SECOND):
        rig.stamp += jump
        answers = rig.drive(250)
        assert answers[0].status[0] == WARMING_UP and answers[-1].status[0] == GOOD
    values = rig.fresh_values(": left")
    expected = {
        "dropped: equal stamp": 1, "dropped: older stamp": 1, "late: several steps at once": 1,
        "resets: gap": 1, "resets: clock stepped back": 1,
    }  # fmt: skip
    assert {key: int(values[key]) for key in expected} == expected
    for stamp in (0, -(2**31) * 10**9, (2**31 - 1) * 10**9):  # the limits of a stamp
        rig.send([0.0], stamp=stamp)
    rig.stamp = START
    settle(rig)
    checked(rig)


def test_names_that_vanish_change_their_order_or_come_twice_are_looked_up(shared, identified, rig):
    shared(rig, model=identified("linear_viscous"), dampers=["left", "right"])
    rig.ready()
    settle(rig, ["left", "right"])
    for i in range(300):
        rig.send([0.0, 0.001 * i], ["right", "left"])
    rig.wait(lambda: len(rig.forces) >= 560, "answers")
    last = dict(zip(rig.forces[-1].name, rig.forces[-1].velocity, strict=True))
    assert last["left"] == pytest.approx(1.0) and abs(last["right"]) < 0.1
    for values, names in (([0.3], ["left"]), ([], []), ([0.3], ["left", "right"]), ([0.3, 0.0], ["", "stranger"])):
        rig.send(values, names)
    rig.send([0.3, 9.0, 9.0], ["left", "left", "left"])
    values = rig.fresh_values(": right")
    assert int(values["not in the message"]) == 5
    assert int(rig.values(": left")["not in the message"]) == 2
    assert rig.drive(1, ["left", "right"])
    checked(rig)


def test_bytes_that_are_no_message_are_counted_and_change_nothing(shared, identified, rig):
    shared(rig, model=identified("linear_viscous"))
    rig.ready()
    settle(rig)
    random, good = np.random.default_rng(4), joint_state([0.0], ["left"], rig.stamp + MS)
    torn = [good[:n] for n in range(4, len(good) - 4, 5)]
    noise = [good[:4] + random.bytes(int(n)) for n in random.integers(1, 400, 60)]
    for data in torn + noise:
        rig.send_raw(data)
        rig.listen(0.001)
    values = rig.fresh_values("input /suspension/displacement")
    assert int(values["malformed"]) > 50 and int(values["failures"]) == 0
    assert int(values["malformed"]) + int(rig.values(": left")["samples"]) >= 260
    rig.stamp += 2**31 * 10**9 // 4
    settle(rig)
    checked(rig)


def test_a_rate_that_changes_and_a_publisher_that_restarts(shared, identified, rig):
    shared(rig, model=identified("carrera_akutain"))
    rig.ready()
    settle(rig)
    assert rig.drive(150, step=5 * MS)[-1].status[0] == GOOD
    assert rig.drive(500)[-1].status[0] == GOOD
    rig.forget()
    rig.stamp += SECOND
    rig.ready()
    before = len(rig.forces)
    while len(rig.forces) == before:  # the node has to discover the new publisher first
        rig.send([0.0])
        rig.listen(0.1)
    assert rig.forces[before].status[0] == WARMING_UP
    assert rig.drive(250)[-1].status[0] == GOOD
    checked(rig)


@pytest.mark.parametrize("seconds", [0.5, 2.5])
def test_a_burst_after_a_stall_is_processed_without_loss(seconds, start, identified, rig):
    """After a second the middleware gives up the shared memory of a process; reliable messages still arrive."""
    process = start(model=identified("carrera_akutain"), dampers="[left]", stale_after=0.2, qos_depth=400)
    rig.ready()
    settle(rig)
    before, first = len(rig.forces), rig.stamp + MS
    process.send_signal(signal.SIGSTOP)
    for _ in range(3):
        for _ in range(100):
            rig.send([0.01])
        time.sleep(seconds / 3.0)
    process.send_signal(signal.SIGCONT)
    rig.wait(lambda: rig.answered(before) >= 300, "the answers to the burst")
    answers = [message for message in rig.forces[before:] if STALE not in message.status]
    stamps = [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in answers]
    assert stamps == list(range(first, first + 300 * MS, MS))
    # Waiting messages arrive immediately; those given up are sent again, which takes longer than ``stale_after``.
    assert seconds > 1.0 or not [m for m in rig.forces[before : before + 300] if STALE in m.status]


def test_qualities_of_service_that_do_not_match_are_reported_on_both_sides(start, identified, rig):
    from damper_msgs.msg import DamperForces
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from std_msgs.msg import Float64

    start(model=identified("coulomb"), dampers="[left]")
    rig.ready()
    wanting = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    rig.node.create_subscription(DamperForces, "/damper_estimator/force", lambda _: None, wanting)
    rig.wait(lambda: "not offered" in rig.message("output"), "the report of the output")
    rig.forget()
    rig.node.create_publisher(Float64, "/suspension/displacement", 10)
    rig.wait(lambda: "another type" in rig.message("input /suspension/displacement"), "the other type")


def test_a_full_disk_stops_recording_and_never_the_estimates(start, identified, rig, tmp_path):
    """A limit on the size of files acts like a disk that is full, for the log as well."""
    start(
        model=identified("coulomb"), dampers="[left]", stale_after=60.0, record=str(tmp_path / "bags"),
        before=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (30_000, 30_000)),
    )  # fmt: skip
    rig.ready()
    rig.wait(lambda: rig.drive(100) and "File too large" in rig.message("recording"), "the report of the full disk")
    assert rig.status("recording").level == b"\x02"
    assert int(rig.values("recording")["not recorded"]) > 0
    settle(rig)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_in_the_middle_of_the_input_ends_it_without_an_error(number, start, identified, rig):
    process = start(model=identified("carrera_akutain"), dampers="[left, right]")
    rig.ready()
    rig.drive(50, ["left", "right"])
    for _ in range(200):
        rig.send([0.0, 0.0], ["left", "right"])
    os.kill(process.pid, number)
    os.kill(process.pid, number)
    said = process.communicate(timeout=60.0)[1]
    assert process.returncode == 0
    assert "Traceback" not in said and "FATAL" not in said and "Failed" not in said, said


def without_the_right_to_priorities() -> None:
    """Drops CAP_SYS_NICE, which only the administrator has, and the limit that can replace it."""
    drop_from_bounding_set, sys_nice = 24, 23
    ctypes.CDLL(None).prctl(drop_from_bounding_set, sys_nice)
    resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))


def test_a_priority_that_is_not_permitted_is_reported_and_the_node_continues(start, identified, rig):
    process = start(
        model=identified("coulomb"), dampers="[left]", realtime_priority=50, before=without_the_right_to_priorities
    )
    rig.ready()
    assert rig.drive(5)
    process.terminate()
    said = process.communicate(timeout=60.0)[1]
    assert "realtime_priority 50 is not allowed here" in said and "limits.conf" in said
