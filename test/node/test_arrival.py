"""Arrival of messages over DDS: padding after them, losses, two publishers of one damper."""

import os
import subprocess
import sys

import numpy as np
import pytest
from rig import MS, START, joint_state

GOOD, WARMING_UP, EXTRAPOLATING, DEGRADED, STALE = range(5)
TOPIC = "/suspension/displacement"

# Publishes samples far faster than the node processes them, then some slowly: losses show in the following sequence
# numbers.
FLOOD = """
import sys, time
import numpy as np
import rclpy
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState
from damper_estimator.recordings import joint_states
count, slow, start = (int(word) for word in sys.argv[1:])
i = np.arange(count + slow)
messages = joint_states(["left"], start + i * 1_000_000, position=(0.02 * np.sin(0.02 * i))[:, None])
rclpy.init()
quality = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
publisher = rclpy.create_node("flood").create_publisher(JointState, "/suspension/displacement", quality)
while publisher.get_subscription_count() < 1:
    time.sleep(0.02)
time.sleep(1.0)
for k, message in enumerate(messages[:count]):
    publisher.publish(message)
    if k % 50 == 0:
        time.sleep(0.002)
for message in messages[count:]:
    time.sleep(0.02)
    publisher.publish(message)
time.sleep(2.0)
"""


@pytest.fixture
def second(rig):
    """Creates further publishers of the displacement topic."""
    from sensor_msgs.msg import JointState

    made = []

    def make():
        made.append(rig.node.create_publisher(JointState, TOPIC, rig._quality))
        rig.wait(lambda: rig.values(f"input {TOPIC}")["publishers"] == str(1 + len(made)), "the publisher heard")
        return made[-1]

    yield make
    for publisher in made:
        rig.node.destroy_publisher(publisher)


@pytest.mark.parametrize("executor", ["events", "single"])
def test_a_flood_is_answered_correctly_and_every_loss_is_counted(executor, start, identified, rig):
    """The filter processes exactly the answered samples; those missing between two messages are counted."""
    count, slow = 20_000, 200
    asked = {"qos_reliability": "best_effort", "qos_depth": 5, "cutoff": 30.0, "executor": executor}
    # The answers wait for this test, which hears them more slowly than the node sends them.
    asked["qos_overrides./damper_estimator/force.publisher.depth"] = 5000
    start(model=identified("linear_viscous"), dampers="[left]", **asked)
    rig.wait(lambda: rig.values("output").get("subscribers", "0") != "0", "the node's forces")
    flood = subprocess.Popen([sys.executable, "-c", FLOOD, str(count), str(slow), str(START)], env=os.environ)
    last = START + (count + slow - 1) * MS
    # Checking all answers each time would take so long that this test would lose some.
    rig.wait(lambda: any(stamp_of(m) == last for m in rig.forces[-100:]), "the last answer")
    assert flood.wait(60.0) == 0
    values = rig.fresh_values(f"input {TOPIC}")
    received, lost = int(values["messages"]), int(values["lost"])
    answers = [m for m in rig.forces if STALE not in m.status]
    assert len(answers) == received < count
    first = (stamp_of(answers[0]) - START) // MS
    assert received + lost == count + slow - first
    velocity = independent_velocity(np.array([stamp_of(m) for m in answers]), cutoff=30.0)
    np.testing.assert_allclose([m.velocity[0] for m in answers], velocity, atol=1e-9)


def stamp_of(message) -> int:
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def independent_velocity(stamps: np.ndarray, cutoff: float) -> np.ndarray:
    """Third-order Butterworth of the flood's displacement at these stamps, by matrix exponentials; input linear between
    samples, at rest after gaps of more than 0.1 s."""
    from scipy.linalg import expm

    raw, w = 0.02 * np.sin(0.02 * ((stamps - START) // MS)), 2.0 * np.pi * cutoff
    state, velocity, steps = np.zeros(3), np.zeros(raw.size), {}
    for k, value in enumerate(raw):
        step = int(stamps[k] - stamps[k - 1]) if k else 10**9
        if step > 100 * MS:
            state = np.array([value, 0.0, 0.0])
            continue
        if step not in steps:
            system = np.zeros((5, 5))
            system[:3, :4] = [[0, 1, 0, 0], [0, 0, 1, 0], [-(w**3), -2 * w**2, -2 * w, w**3]]
            system[3, 4] = 1.0 / (step / 1e9)
            steps[step] = expm(system * (step / 1e9))
        state = (steps[step] @ [*state, raw[k - 1], value - raw[k - 1]])[:3]
        velocity[k] = state[1]
    return velocity


def test_padding_after_messages_changes_nothing(shared, identified, rig):
    """Published raw, as from rmw_serialize, and as buffers of a fixed size."""
    shared(rig, model=identified("linear_viscous"))
    rig.ready()
    before = int(rig.fresh_values(f"input {TOPIC}")["malformed"])
    tails = [b"", b"\xab" * 4, b"\xcd" * 12, b"\xff" * 3, bytes(200), bytes(64)]
    answers = {}
    for name, chosen in (("plain", [b""]), ("padded", tails)):
        rig.stamp += 10**9
        first = len(rig.forces)
        for i in range(400):
            rig.stamp += MS
            data = joint_state([0.02 * np.sin(0.02 * i)], ["left"], rig.stamp)
            rig.send_raw(data + chosen[i % len(chosen)])
            rig.wait(lambda i=i, first=first: rig.answered(first) >= i - 20, "answers")
        rig.wait(lambda first=first: rig.answered(first) >= 400, "answers")
        answers[name] = [(m.force[0], m.status[0]) for m in rig.forces[first:] if STALE not in m.status]
    assert answers["padded"] == answers["plain"]
    rig.send_raw(joint_state([0.0], ["left"], rig.stamp + MS) + b"\1" * 40)  # content of something else
    rig.wait(lambda: int(rig.values(f"input {TOPIC}")["malformed"]) == before + 1, "the report")


def test_messages_that_rclpy_serialises_are_answered(shared, identified, rig):
    from rclpy.serialization import serialize_message
    from sensor_msgs.msg import JointState

    shared(rig, model=identified("linear_viscous"))
    rig.ready()
    rig.stamp += 10**9
    before, values = len(rig.forces), rig.fresh_values(f"input {TOPIC}")
    for i in range(300):
        message = JointState(name=["left"], position=[0.001 * np.sin(0.02 * i)])
        rig.stamp += MS
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(rig.stamp, 10**9)
        message.header.frame_id = "f" * (i % 9)
        rig.send_raw(serialize_message(message))
        rig.wait(lambda i=i: rig.answered(before) >= i - 20, "answers")
    rig.wait(lambda: rig.answered(before) >= 300, "answers")
    assert rig.forces[-1].status[0] == GOOD
    assert rig.fresh_values(f"input {TOPIC}")["malformed"] == values["malformed"]


def alternate(rig, publishers, names, count=800):
    """Each publisher sends its damper's sample in turn, 1 ms apart in all; the answers."""
    before = len(rig.forces)
    for i in range(count):
        sender = i % len(publishers)
        rig.stamp += MS
        # Small enough to be neither a jump nor noise.
        value = 0.02 * np.sin(0.02 * i) + 2e-5 * sender
        publishers[sender].publish(joint_state([value], [names[sender]], rig.stamp))
        rig.wait(lambda i=i: rig.answered(before) >= i - 20, "answers")
    rig.wait(lambda: rig.answered(before) >= count, "answers")
    return [m for m in rig.forces[before:] if STALE not in m.status]


@pytest.mark.parametrize("executor", ["events", "single"])
def test_two_publishers_of_one_damper_are_never_good_and_are_named(executor, start, identified, rig, second):
    start(model=identified("linear_viscous"), dampers="[left, right]", stale_after=60.0, executor=executor)
    rig.ready()
    assert rig.drive(300, ["left", "right"])[-1].status[0] == GOOD
    other = second()
    assert rig.drive(300, ["left", "right"])[-1].status[0] == GOOD  # a silent publisher does no harm
    answers = alternate(rig, [rig.publisher(), other], ["left", "left"])
    assert {s for m in answers[2:] for s in m.status} == {DEGRADED}
    rig.wait(lambda: "two publishers send left on" in rig.message(f"input {TOPIC}"), "the report")
    assert "stop one or remap it" in rig.message(f"input {TOPIC}")
    assert rig.drive(300, ["left", "right"])[-1].status[0] == GOOD  # the second is silent again
    rig.wait(lambda: "two publishers" not in rig.message(f"input {TOPIC}"), "the end of the report")


def test_two_publishers_of_different_dampers_are_good(start, identified, rig, second):
    start(model=identified("linear_viscous"), dampers="[left, right]", stale_after=60.0)
    rig.ready()
    rig.drive(50, ["left"])
    answers = alternate(rig, [rig.publisher(), second()], ["left", "right"], count=1200)
    assert {s for m in answers[-600:] for s in m.status} == {GOOD}
    values = rig.fresh_values(f"input {TOPIC}")
    assert values["from one of two publishers"] == "" and values["lost"] == "0"


def test_a_publisher_that_restarts_next_to_another_is_not_reported(start, identified, rig, second):
    start(model=identified("linear_viscous"), dampers="[left, right]", stale_after=60.0)
    rig.ready()
    other = second()
    alternate(rig, [rig.publisher(), other], ["left", "right"], count=500)
    rig.forget()
    rig.listen(0.3)
    rig.publisher()
    rig.wait(lambda: rig.values(f"input {TOPIC}")["publishers"] == "2", "both publishers heard")
    rig.stamp += 10**9
    answers = alternate(rig, [rig.publisher(), other], ["left", "right"], count=1200)
    assert {s for m in answers for s in m.status} <= {GOOD, WARMING_UP}
    assert rig.fresh_values(f"input {TOPIC}")["from one of two publishers"] == ""
