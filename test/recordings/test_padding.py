"""Bytes after the last field of a message: serialisers leave some, ROS readers ignore them."""

import sqlite3
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from damper_estimator.errors import InputError
from damper_estimator.recordings.bag import Bag
from damper_estimator.recordings.cdr_layout import MalformedMessage
from damper_estimator.recordings.decode import Decoder
from damper_estimator.recordings.definitions import builtin_schema, definition_of

JOINT_STATE = "sensor_msgs/msg/JointState"
TOPIC = "/suspension/displacement"
START = 1_700_000_000_000_000_000
quick = settings(max_examples=80, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])

JOINT_STATE_TEXT = f"""std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
{"=" * 80}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{"=" * 80}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""


def decode(messages: list[bytes], paths: list[str], type_name: str = JOINT_STATE):
    length = np.array([len(message) for message in messages], np.int64)
    decoder = Decoder(definition_of(builtin_schema(type_name)), paths)
    return decoder.decode(b"".join(messages), np.cumsum(length) - length, length)


@quick
@given(
    arrays=st.lists(st.integers(0, 3), min_size=3, max_size=3),
    names=st.lists(st.sampled_from(["left", "l", "rear_left", ""]), max_size=3),
    tails=st.lists(st.binary(max_size=15) | st.integers(0, 500).map(bytes), min_size=1, max_size=30),
)
def test_numbers_are_the_same_with_any_padding(joint_state, arrays, names, tails):
    position, velocity, effort = ([k + 0.5] * count for k, count in enumerate(arrays))
    plain = joint_state(stamp=5, names=names, position=position, velocity=velocity, effort=effort)
    paths = ["position[0]", "velocity[1]", "effort[left]"]
    padded, alone = decode([plain + tail for tail in tails], paths), decode([plain], paths)
    assert (padded.present == alone.present).all() and (padded.stamp == 5).all()
    np.testing.assert_array_equal(padded.values, np.repeat(alone.values, len(tails), axis=0))


@pytest.mark.parametrize(
    ("type_name", "content", "most"),
    [
        ("std_msgs/msg/Float64", bytes(8), 3),
        ("sensor_msgs/msg/Temperature", bytes(8) + b"\1\0\0\0" + bytes(4) + bytes(16), 3),
        (JOINT_STATE, bytes(8) + b"\1\0\0\0" + bytes(4 + 16), 15),
        ("damper_msgs/msg/DamperForces", bytes(8) + b"\1\0\0\0" + bytes(4 + 44), 39),
    ],
)
def test_more_than_padding_is_content_of_another_type(type_name, content, most):
    """As many bytes as serialisers leave, or zeros; a Temperature is not read as a Float64."""
    plain = b"\0\1\0\0" + content
    for tail in (b"\xff" * most, bytes(most + 1), bytes(4000)):
        decode([plain + tail], [], type_name)
    for tail in (b"\xff" * (most + 1), bytes(most) + b"\1", bytes(4000) + b"\1"):
        with pytest.raises(MalformedMessage, match=f"{len(tail)} of its .* bytes are left over"):
            decode([plain + tail], [], type_name)


def test_content_after_a_known_structure_is_detected_as_well(joint_state):
    plain = joint_state(names=["a"], position=[1.0])
    with pytest.raises(MalformedMessage):
        decode([plain, plain + bytes(50), plain + bytes(49) + b"\1"], ["position[a]"])


def ros_messages(count: int, seed: int = 3) -> list[tuple[bytes, float]]:
    """JointState of many structures as rclpy serialises them, and ``position[left]`` (NaN if there is none)."""
    pytest.importorskip("rclpy")
    from rclpy.serialization import serialize_message
    from sensor_msgs.msg import JointState

    random, made, junk = np.random.default_rng(seed), [], []
    for i in range(count):
        junk = [*junk[-20:], random.bytes(int(random.integers(20, 300)))]  # buffers are not initialised
        names = ["left", *("n" * int(size) for size in random.integers(0, 12, int(random.integers(0, 4))))]
        random.shuffle(names)
        values = random.normal(size=len(names)) if random.random() < 0.9 else np.zeros(0)
        message = JointState(name=names, position=values)
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(START + i * 1_000_000, 10**9)
        message.header.frame_id = "f" * int(random.integers(0, 9))
        if random.random() < 0.3:
            message.effort = [1.5] * len(names)
        made.append((serialize_message(message), float(values[names.index("left")]) if values.size else np.nan))
    return made


def test_everything_that_rclpy_serialises_is_read():
    pytest.importorskip("rclpy")
    from damper_msgs.msg import DamperForces
    from geometry_msgs.msg import AccelStamped
    from rclpy.serialization import serialize_message
    from sensor_msgs.msg import Temperature
    from std_msgs.msg import Float64
    from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

    messages = ros_messages(400)
    read = decode([raw for raw, _ in messages], ["position[left]"])
    np.testing.assert_array_equal(read.values[:, 0], [value for _, value in messages])
    assert len({len(raw) for raw, _ in messages}) > 10
    for size in range(8):
        header = Temperature().header
        header.frame_id = "f" * size
        points = [JointTrajectoryPoint(positions=[1.0], effort=[2.0])] * size
        others = {
            "std_msgs/msg/Float64": Float64(data=1.5),
            "sensor_msgs/msg/Temperature": Temperature(header=header, temperature=40.0),
            "geometry_msgs/msg/AccelStamped": AccelStamped(header=header),
            "damper_msgs/msg/DamperForces": DamperForces(header=header, name=["n" * size], force=[1.0]),
            "trajectory_msgs/msg/JointTrajectory": JointTrajectory(joint_names=["n" * size], points=points),
        }
        for type_name, message in others.items():
            decode([serialize_message(message)], [], type_name)


def write_mcap(path: Path, messages: list[bytes]) -> Path:
    """As rosbag2's mcap storage writes serialised messages: payload unchanged."""
    from mcap.writer import Writer

    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2", library="rosbag2_storage_mcap")
        schema = writer.register_schema(JOINT_STATE, "ros2msg", JOINT_STATE_TEXT.encode())
        channel = writer.register_channel(TOPIC, "cdr", schema)
        for i, data in enumerate(messages):
            log = START + i * 1_000_000
            writer.add_message(channel, log, data, log, i)
        writer.finish()
    return path


def write_sqlite(path: Path, messages: list[bytes]) -> Path:
    """As rosbag2's sqlite3 storage writes them."""
    database = sqlite3.connect(path)
    database.executescript(
        """
        CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
        CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);
        CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
            serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL,
            type_description_hash TEXT NOT NULL);
        CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, encoding TEXT NOT NULL,
            encoded_message_definition TEXT NOT NULL, type_description_hash TEXT NOT NULL);
        CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL,
            data BLOB NOT NULL);
        CREATE INDEX timestamp_idx ON messages (timestamp ASC);
        INSERT INTO schema VALUES(4, 'jazzy');
        """
    )
    database.execute("INSERT INTO topics VALUES(1, ?, ?, 'cdr', '', '')", (TOPIC, JOINT_STATE))
    database.execute("INSERT INTO message_definitions VALUES(1, ?, 'ros2msg', ?, '')", (JOINT_STATE, JOINT_STATE_TEXT))
    rows = [(START + i * 1_000_000, data) for i, data in enumerate(messages)]
    database.executemany("INSERT INTO messages(topic_id, timestamp, data) VALUES(1, ?, ?)", rows)
    database.commit()
    database.close()
    return path


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_bags_of_messages_that_rclpy_serialised_are_read(storage, tmp_path):
    messages = ros_messages(300)
    data = [raw for raw, _ in messages]
    path = write_mcap(tmp_path / "x.mcap", data) if storage == "mcap" else write_sqlite(tmp_path / "x.db3", data)
    with Bag(path) as bag:
        columns = bag.columns(TOPIC, ["position[left]"])
        np.testing.assert_array_equal(columns.values[:, 0], [value for _, value in messages])
        np.testing.assert_array_equal(columns.stamp, START + np.arange(300) * 1_000_000)
        whole = [message for batch in bag.batches() for _, message in batch.messages(TOPIC)]
    lefts = [m.position[m.name.index("left")] if len(m.position) else np.nan for m in whole]
    np.testing.assert_array_equal(lefts, columns.values[:, 0])


def test_a_bag_whose_messages_contain_more_than_their_type_is_reported(joint_state, tmp_path):
    plain = joint_state(names=["left"], position=[1.0])
    path = write_mcap(tmp_path / "x.mcap", [plain, plain + b"\1" * 40])
    with Bag(path) as bag:
        with pytest.raises(InputError, match="does not fit its type sensor_msgs/msg/JointState .40 of its"):
            bag.columns(TOPIC, ["position[left]"])
        with pytest.raises(InputError, match="does not fit its type sensor_msgs/msg/JointState"):
            list(next(iter(bag.batches())).messages(TOPIC))
