"""Recordings in all shapes of storage: the same messages in the same order."""

import sqlite3
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.writer import CompressionType, IndexType, Writer
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as FolderWriter

from damper_estimator.errors import InputError
from damper_estimator.recordings import floats, open_bag
from damper_estimator.recordings.definitions import builtin_schema

FLOAT = "std_msgs/msg/Float64"
SCHEMA = builtin_schema(FLOAT)
quick = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
messages_of = st.lists(st.tuples(st.sampled_from(["/a", "/b", "/c"]), st.integers(0, 30)), max_size=60)


def write_mcap(path: Path, messages, schema: bool = True, **options) -> Path:
    """Messages (topic, log time); the value of each is its position in the list."""
    with open(path, "wb") as file:
        writer = Writer(file, **options)
        writer.start("ros2")
        number = writer.register_schema(FLOAT, "ros2msg", SCHEMA.text.encode()) if schema else 0
        channels = {topic: writer.register_channel(topic, "cdr", number) for topic in ("/a", "/b", "/c")}
        for place, (topic, log) in enumerate(messages):
            writer.add_message(channels[topic], log, floats(np.array([float(place)]))[0], log)
        writer.finish()
    return path


def write_folder(path: Path, messages, storage: StoragePlugin, mode: CompressionMode, store) -> Path:
    writer = FolderWriter(path, version=9, storage_plugin=storage)
    if mode != CompressionMode.NONE:
        writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        connections = {topic: writer.add_connection(topic, FLOAT, typestore=store) for topic in ("/a", "/b", "/c")}
        for place, (topic, log) in enumerate(messages):
            writer.write(connections[topic], log, floats(np.array([float(place)]))[0])
    return path


def in_order(messages) -> list[tuple[str, int, float]]:
    placed = [(topic, log, float(place)) for place, (topic, log) in enumerate(messages)]
    return sorted(placed, key=lambda item: item[1])


def read(path: Path) -> list[tuple[str, int, float]]:
    found = []
    with open_bag(path) as bag:
        for batch in bag.batches():
            for topic in bag.topics:
                columns = batch.columns(topic.name, ["data"])
                names = [topic.name] * len(columns.rank)
                found += zip(
                    columns.rank.tolist(), names, columns.log.tolist(), columns.values[:, 0].tolist(), strict=True
                )
    return [tuple(rest) for _, *rest in sorted(found)]


OPTIONS = {
    "rosbag2_like": {},
    "small_chunks": {"chunk_size": 200},
    "lz4": {"compression": CompressionType.LZ4, "chunk_size": 300},
    "plain_chunks": {"compression": CompressionType.NONE, "chunk_size": 300, "enable_crcs": False},
    "no_chunks": {"use_chunking": False},
    "no_index": {"index_types": IndexType.NONE, "chunk_size": 200},
    "no_summary": {
        "index_types": IndexType.NONE, "chunk_size": 200, "repeat_channels": False, "repeat_schemas": False,
        "use_statistics": False, "use_summary_offsets": False,
    },
    "no_chunks_no_summary": {
        "index_types": IndexType.NONE, "use_chunking": False, "repeat_channels": False, "repeat_schemas": False,
        "use_statistics": False, "use_summary_offsets": False,
    },
    "no_repeated_channels": {"repeat_channels": False, "chunk_size": 200},
}  # fmt: skip


@pytest.mark.parametrize("options", OPTIONS.values(), ids=OPTIONS.keys())
@quick
@given(messages=messages_of)
def test_mcap_of_every_kind_reads_in_stable_log_order(tmp_path, options, messages):
    path = write_mcap(tmp_path / "a.mcap", messages, **options)
    assert read(path) == in_order(messages)
    with open_bag(path) as bag:
        counts = {topic.name: topic.messages for topic in bag.topics if topic.messages}
    assert counts == {topic: sum(name == topic for name, _ in messages) for topic in {name for name, _ in messages}}


@quick
@given(parts=st.lists(messages_of, min_size=1, max_size=4), size=st.integers(1, 50))
def test_split_bags_merge_by_log_time_and_earlier_files_come_first(tmp_path, parts, size):
    folder = tmp_path / "bag"
    folder.mkdir(exist_ok=True)
    for number, part in enumerate(parts):
        write_mcap(folder / f"{number}.mcap", part, chunk_size=150)
    describe(folder, [f"{number}.mcap" for number in range(len(parts))], "mcap")
    merged = sorted((log, number, place) for number, part in enumerate(parts) for place, (_, log) in enumerate(part))
    with open_bag(folder) as bag:
        batches = list(bag.batches(size=size))
        values = [message.data for batch in batches for _, message in every(batch)]
    assert values == [float(place) for _, _, place in merged]
    assert all(len(batch) <= size for batch in batches)


def every(batch):
    """All messages of a batch in order."""
    found = [
        (log, rank, message)
        for topic in ("/a", "/b", "/c")
        for (log, message), rank in zip(batch.messages(topic), batch.columns(topic, ["data"]).rank, strict=True)
    ]
    return [(log, message) for log, _, message in sorted(found, key=lambda item: item[1])]


def describe(folder: Path, files: list[str], storage: str, **more) -> None:
    information = {"version": 9, "storage_identifier": storage, "relative_file_paths": files, **more}
    (folder / "metadata.yaml").write_text(yaml.safe_dump({"rosbag2_bagfile_information": information}))


@pytest.mark.parametrize("storage", StoragePlugin)
@pytest.mark.parametrize("mode", [CompressionMode.NONE, CompressionMode.FILE, CompressionMode.MESSAGE])
def test_folders_of_every_storage_and_compression_read_alike(tmp_path, store, storage, mode):
    messages = [("/" + "abc"[place % 3], 1000 - place // 7) for place in range(50)]
    folder = write_folder(tmp_path / "bag", messages, storage, mode, store)
    assert read(folder) == in_order(messages)


def test_ranks_count_the_topics_that_were_not_requested(tmp_path):
    path = write_mcap(tmp_path / "a.mcap", [("/a", 1), ("/b", 2), ("/b", 2), ("/a", 3)])
    with open_bag(path) as bag:
        assert bag.columns("a", ["data"]).rank.tolist() == [0, 3]
        assert bag.columns("/b", ["data"]).rank.tolist() == [1, 2]
        both = bag.read({"/a": ["data"], "b": []})
    assert both["/a"].values.tolist() == [[0.0], [3.0]] and both["b"].values.shape == (2, 0)


def test_a_type_without_header_is_stamped_with_its_log_time(tmp_path):
    with open_bag(write_mcap(tmp_path / "a.mcap", [("/a", 7)])) as bag:
        columns = bag.columns("/a", ["data"])
    assert columns.stamp.tolist() == columns.log.tolist() == [7]


def test_wrong_folders_before_the_file_names_are_ignored(tmp_path):
    write_mcap(tmp_path / "x.mcap", [("/a", 1)])
    describe(
        tmp_path, ["elsewhere/deep/x.mcap"], "mcap", version=4, starting_time={"nanoseconds_since_epoch": 2**63 - 1}
    )
    assert read(tmp_path) == [("/a", 1, 0.0)]


def test_a_topic_without_definition_is_listed_and_falls_back_or_is_refused(tmp_path):
    folder = tmp_path / "bag"
    folder.mkdir()
    database = sqlite3.connect(folder / "x.db3")
    database.executescript("""
        CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);
        CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);
        INSERT INTO topics VALUES (3, '/known', 'std_msgs/msg/Float64', 'cdr'), (9, '/own', 'my_msgs/msg/Own', 'cdr'),
                                  (11, '/other', 'my_msgs/msg/Own', 'json');
    """)
    for topic in (3, 9, 11):
        database.execute(
            "INSERT INTO messages(topic_id, timestamp, data) VALUES (?, 5, ?)", (topic, floats(np.array([2.5]))[0])
        )
    database.commit()
    database.close()
    describe(folder, ["x.db3"], "sqlite3", version=2)
    with open_bag(folder) as bag:
        assert {topic.name for topic in bag.topics} == {"/known", "/own", "/other"}
        assert bag.columns("/known", ["data"]).values.tolist() == [[2.5]]
        with pytest.raises(InputError, match="/own: my_msgs/msg/Own has no definition in the bag .* record it with"):
            bag.columns("/own", ["data"])
        with pytest.raises(InputError, match="encoded as 'json'; only cdr"):
            bag.columns("/other", ["data"])


def test_an_unknown_topic_is_answered_with_the_existing_ones(tmp_path):
    with open_bag(write_mcap(tmp_path / "a.mcap", [("/a", 1)])) as bag:
        with pytest.raises(InputError, match="a.mcap: has no topic '/d'; there are: /a, /b, /c"):
            bag.columns("/d", ["data"])
        with pytest.raises(
            InputError, match="topic /a: field \"speed\" of std_msgs/msg/Float64 has no field 'speed'; there are data"
        ):
            bag.columns("/a", ["speed"])


def test_a_wrong_field_is_refused_even_if_the_topic_is_empty(tmp_path):
    with open_bag(write_mcap(tmp_path / "a.mcap", [("/a", 1)])) as bag:
        with pytest.raises(InputError, match="no field 'speed'"):
            bag.columns("/b", ["speed"])
        assert bag.columns("/b", ["data"]).values.shape == (0, 1)
