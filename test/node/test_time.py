"""Time against the running node: the age of stamps, a clock that is set back, and the stamp of stale estimates."""

import signal
import time

import numpy as np
import pytest
from rig import MS, PATIENCE, joint_state

GOOD, DEGRADED, STALE = 0, 3, 4
SECOND = 1000 * MS


def drive_now(rig, seconds: float) -> list:
    """Good samples with the stamps of this machine's clock; the answers."""
    before, sent, end = len(rig.forces), 0, time.monotonic() + seconds
    while time.monotonic() < end:
        rig.send([0.02 * np.sin(0.02 * sent)], stamp=time.time_ns())
        sent += 1
        rig.listen(0.003)
    rig.wait(lambda: rig.answered(before) >= sent, "answers")
    return [m for m in rig.forces[before:] if STALE not in m.status]


def good_again(rig) -> None:
    """Drives until an answer is GOOD: on a busy machine present samples are sometimes old as well."""
    end = time.monotonic() + PATIENCE
    while drive_now(rig, 0.5)[-1].status[0] != GOOD:
        assert time.monotonic() < end, "the estimate was not GOOD again"


def test_samples_above_the_maximum_age_are_not_good(start, identified, rig):
    process = start(model=identified("coulomb"), dampers="[left]", max_age=0.4, stale_after=30.0, qos_depth=400)
    rig.ready()
    good_again(rig)
    process.send_signal(signal.SIGSTOP)
    before = len(rig.forces)
    for i in range(100):
        rig.send([0.02 * np.sin(0.02 * i)], stamp=time.time_ns())
        time.sleep(0.01)
    process.send_signal(signal.SIGCONT)
    rig.wait(lambda: len(rig.forces) >= before + 100, "the answers")
    waited = rig.forces[before : before + 100]
    assert {m.status[0] for m in waited[:40]} == {DEGRADED}
    good_again(rig)
    assert int(rig.fresh_values(": left")["samples in doubt (age, sender, current)"]) >= 40


def test_a_stale_damper_keeps_its_last_stamp_while_others_continue(start, identified, rig):
    start(model=identified("coulomb"), dampers="[left, right]", stale_after=0.2)
    rig.ready()
    rig.drive(20, ["left", "right"])
    last = rig.forces[-1].header.stamp
    rig.wait(lambda: _go_on(rig), "STALE of one")
    (stale,) = [m for m in rig.forces if STALE in m.status and list(m.name) == ["right"]][-1:]
    assert stale.header.stamp == last
    assert any(list(m.name) == ["left"] and m.header.stamp != last for m in rig.forces)


def _go_on(rig) -> bool:
    rig.send([0.001], ["left"])
    rig.listen(0.005)
    return any(list(m.name) == ["right"] and STALE in m.status for m in rig.forces[-50:])


def test_after_a_simulated_clock_was_set_back_no_sample_is_fresh_and_no_force_desired(start, identified, rig):
    from rosgraph_msgs.msg import Clock

    start(model=identified("coulomb"), dampers="[left]", stale_after=0.5, use_sim_time=True)
    clock = rig.node.create_publisher(Clock, "/clock", 10)
    rig.ready()

    def at(now: int) -> None:
        message = Clock()
        message.clock.sec, message.clock.nanosec = divmod(now, SECOND)
        clock.publish(message)

    now = 1_000 * SECOND
    rig.wait(lambda: clock.get_subscription_count() > 0, "the clock's subscriber")
    for i in range(150):
        at(now + i * 10 * MS)
        rig.send_raw(joint_state([0.001 * i], ["left"], now + i * 10 * MS))
        rig.listen(0.002)
    rig.wait(lambda: rig.answered(0) >= 150, "answers")
    for i in range(600):  # back by a quarter of an hour, and no message follows
        at(100 * SECOND + i * 10 * MS)
        rig.listen(0.005)
        if any(STALE in m.status for m in rig.forces):
            break
    assert any(STALE in m.status for m in rig.forces) and i * 10 * MS < 4 * SECOND


@pytest.mark.parametrize("has_clock", [False, True])
def test_an_input_gets_stale_although_the_simulated_clock_stands_still(has_clock, start, identified, rig):
    """Absent, as on a vehicle with use_sim_time by mistake, or dead."""
    from rosgraph_msgs.msg import Clock

    start(model=identified("coulomb"), dampers="[left]", stale_after=0.5, use_sim_time=True)
    rig.ready()
    if has_clock:
        clock = rig.node.create_publisher(Clock, "/clock", 10)
        rig.wait(lambda: clock.get_subscription_count() > 0, "the clock's subscriber")
        message = Clock()
        message.clock.sec = 1_000
        clock.publish(message)
    end = time.monotonic() + 3.0
    while time.monotonic() < end:
        rig.send([0.001], ["left"])
        rig.listen(0.005)
    assert not any(STALE in m.status for m in rig.forces)
    rig.wait(lambda: STALE in rig.forces[-1].status, "STALE")
    rig.wait(lambda: "/clock stands still" in rig.message(": output"), "the report")
