"""Written recordings open in rosbags and mcap, and are read back unchanged."""

import os

import numpy as np
import pytest
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import Reader

from damper_estimator.errors import InputError
from damper_estimator.recordings import BagWriter, damper_forces, floats, joint_states, open_bag
from damper_estimator.recordings.definitions import DAMPER_FORCES

JOINT_STATE = "sensor_msgs/msg/JointState"
NAMES = ["front_left", "front_right"]
START = 1_700_000_000 * 10**9
STAMPS = START + np.arange(500) * 1_000_000
POSITION = np.random.default_rng(1).normal(size=(500, 2))


@pytest.fixture
def written(tmp_path):
    path = tmp_path / "out.mcap"
    with BagWriter(path) as writer:
        fields = {"header.stamp": STAMPS, "name": NAMES, "position": POSITION}
        writer.write_columns("/suspension/displacement", JOINT_STATE, STAMPS + 5, fields)
        writer.write_columns(
            "/suspension/front_left/current", "std_msgs/msg/Float64", STAMPS[:2], {"data": np.array([0.5, 1.0])}
        )
        forces = damper_forces(NAMES, STAMPS, {"force": POSITION * 100})
        writer.write_messages("/damper_estimator/force", DAMPER_FORCES, STAMPS + 9, forces)
        writer.write_raw("/suspension/rear/current", "std_msgs/msg/Float64", START, floats(np.array([2.0]))[0])
    return path


def test_written_messages_are_read_back(written):
    with open_bag(written) as bag:
        read = bag.read({
            "suspension/displacement": ["position[front_right]", "position[front_left]"],
            "/damper_estimator/force": ["force[front_left]", "force_min[1]", "status[0]"],
            "/suspension/front_left/current": ["data"],
        })  # fmt: skip
    moved, forces, current = read.values()
    assert (
        (moved.values == POSITION[:, ::-1]).all() and (moved.stamp == STAMPS).all() and (moved.log == STAMPS + 5).all()
    )
    assert (forces.values[:, 0] == POSITION[:, 0] * 100).all() and np.isnan(forces.values[:, 1]).all()
    assert (forces.values[:, 2] == 0).all() and forces.present.all()
    assert current.values.tolist() == [[0.5], [1.0]] and current.log.tolist() == STAMPS[:2].tolist()


def test_rosbags_opens_it_and_decodes_by_the_definitions_in_the_file(written):
    with AnyReader([written]) as reader:
        assert {item.topic: item.msgcount for item in reader.connections} == {
            "/suspension/displacement": 500,
            "/suspension/front_left/current": 2,
            "/damper_estimator/force": 500,
            "/suspension/rear/current": 1,
        }
        for connection, _, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            if connection.topic == "/damper_estimator/force":
                row = (message.header.stamp.sec * 10**9 + message.header.stamp.nanosec - START) // 1_000_000
                assert message.force.tolist() == (POSITION[row] * 100).tolist()
                assert message.name == NAMES


def test_rosbags_reads_the_quality_of_service(written):
    with Reader(written) as reader:
        profile = reader.connections[0].ext.offered_qos_profiles[0]
        digests = {connection.msgtype: connection.digest for connection in reader.connections}
    assert (profile.history.name, profile.reliability.name, profile.durability.name) == (
        "KEEP_LAST",
        "RELIABLE",
        "VOLATILE",
    )
    assert set(digests) == {JOINT_STATE, DAMPER_FORCES, "std_msgs/msg/Float64"}


def test_the_mcap_library_finds_profile_schemas_and_index(written):
    with open(written, "rb") as file:
        reader = make_reader(file, validate_crcs=True)
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
        assert sum(1 for _ in reader.iter_messages()) == summary.statistics.message_count == 1003
    assert {schema.name: schema.encoding for schema in summary.schemas.values()} == {
        JOINT_STATE: "ros2msg", DAMPER_FORCES: "ros2msg", "std_msgs/msg/Float64": "ros2msg",
    }  # fmt: skip
    assert {chunk.compression for chunk in summary.chunk_indexes} == {"zstd"}
    assert all(channel.metadata["topic_type_hash"].startswith("RIHS01_") for channel in summary.channels.values())


def test_a_copy_keeps_bytes_order_and_foreign_definitions(tmp_path, written, shared_data):
    foreign = shared_data / "rosbag2_bags" / "mcap_topics_services"
    for source in (written, foreign):
        copy = tmp_path / "copy.mcap"
        with open_bag(source) as bag, BagWriter(copy) as writer:
            for batch in bag.batches():
                writer.write_batch(batch)
        with open_bag(source) as old, open_bag(copy) as new:
            assert [topic for topic in old.topics if topic.messages] == list(new.topics)
            rows = ([list(batch.raw()) for batch in bag.batches()] for bag in (old, new))
            for before, after in zip(*rows, strict=True):
                assert [(c.topic, c.schema, log, raw) for c, log, raw in before] == [
                    (c.topic, c.schema, log, raw) for c, log, raw in after
                ]


def test_an_error_leaves_neither_the_file_nor_a_part_of_it(tmp_path):
    with pytest.raises(ZeroDivisionError), BagWriter(tmp_path / "out.mcap") as writer:
        writer.write_messages("/a", "std_msgs/msg/Float64", STAMPS, floats(np.zeros(500)))
        raise ZeroDivisionError
    assert os.listdir(tmp_path) == []


def test_an_error_keeps_the_existing_recording(tmp_path, written):
    before = written.read_bytes()
    with pytest.raises(ZeroDivisionError), BagWriter(written):
        raise ZeroDivisionError
    assert written.read_bytes() == before


@pytest.mark.parametrize("place", ["missing/out.mcap", "file/out.mcap", "folder.mcap"])
def test_a_path_that_cannot_be_written_is_named(tmp_path, place):
    (tmp_path / "file").write_text("")
    (tmp_path / "folder.mcap").mkdir()
    with pytest.raises(InputError, match=f"{place}: cannot be written"), BagWriter(tmp_path / place):
        pass


def test_only_mcap_is_written(tmp_path):
    with pytest.raises(InputError, match="out.db3: recordings are written as mcap; give a name ending in .mcap"):
        BagWriter(tmp_path / "out.db3")


def test_an_empty_recording_is_a_recording(tmp_path):
    with BagWriter(tmp_path / "out.mcap") as writer:
        writer.write_messages("/a", JOINT_STATE, STAMPS[:0], joint_states(["a"], STAMPS[:0], position=np.zeros((0, 1))))
    with open_bag(tmp_path / "out.mcap") as bag:
        assert [(topic.name, topic.type, topic.messages) for topic in bag.topics] == [("/a", JOINT_STATE, 0)]
        assert bag.columns("/a", ["position[a]"]).values.shape == (0, 1)
