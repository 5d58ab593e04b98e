"""Damaged, cut off and foreign files: refused in one line, or read as far as their checks allow."""

import random
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
import yaml
from mcap.reader import make_reader

from damper_estimator.errors import InputError
from damper_estimator.recordings import BagWriter, LiveBagWriter, joint_states, open_bag

STAMPS = np.arange(1, 301) * 1_000_000
CASES = 150


def use_everything(path: Path) -> int:
    """Reads a whole recording; returns the number of messages."""
    count = 0
    with open_bag(path) as bag:
        for batch in bag.batches(size=64):
            count += len(batch)
        for topic in bag.topics:
            try:
                for batch in bag.batches([topic.name]):
                    batch.columns(topic.name, ["position[a]", "position[1]"])
                    for _ in batch.messages(topic.name):
                        pass
            except InputError as error:
                assert one_line(error)
    return count


def one_line(error: InputError) -> bool:
    return "\n" not in str(error) and len(str(error)) < 2000


def survives(path: Path) -> bool:
    """True if it was read, False if it was refused."""
    try:
        use_everything(path)
    except InputError as error:
        assert one_line(error)
        assert str(path) in str(error)
        return False
    return True


@pytest.fixture(scope="module")
def recording(tmp_path_factory) -> bytes:
    path = tmp_path_factory.mktemp("hostile") / "good.mcap"
    with BagWriter(path) as writer:
        messages = joint_states(["a", "b"], STAMPS, position=np.random.default_rng(0).normal(size=(300, 2)))
        writer.write_messages("/x", "sensor_msgs/msg/JointState", STAMPS, messages)
    return path.read_bytes()


def test_an_mcap_cut_anywhere_yields_its_whole_chunks_and_reports_the_loss(tmp_path, caplog):
    """As left by a killed recorder: in the middle of a chunk, an index, or the summary."""
    writer, ends = LiveBagWriter(tmp_path / "whole.mcap"), []
    messages = joint_states(["a"], STAMPS, position=np.arange(300.0)[:, None])
    for i, message in enumerate(messages):
        writer.write_raw("/x", "sensor_msgs/msg/JointState", int(STAMPS[i]), message)
        if i % 60 == 59:
            ends.append((writer.flush(), i + 1))
    writer.close()
    recording = (tmp_path / "whole.mcap").read_bytes()
    path = tmp_path / "cut.mcap"
    for length in [ends[0][0], *random.Random(1).sample(range(9, len(recording)), CASES)]:
        path.write_bytes(recording[:length])
        caplog.clear()
        # A chunk is whole a little before its indexes are.
        least = max((count for end, count in ends if end <= length), default=0)
        most = least if least == 300 else least + 60
        try:
            with open_bag(path) as bag:
                values = bag.columns("/x", ["position[a]"]).values[:, 0]
        except InputError as error:
            assert least == 0
            assert re.search(r"cut\.mcap: cut off before .*; recover the readable part with: mcap recover", str(error))
            continue
        assert values.size in (least, most) and np.array_equal(values, np.arange(values.size))
        assert f"{values.size} messages are whole" in caplog.text and "bytes are lost" in caplog.text


def test_the_closed_file_of_a_live_recorder_is_an_ordinary_one(tmp_path):
    path = tmp_path / "x.mcap"
    writer = LiveBagWriter(path)
    messages = joint_states(["a"], STAMPS, position=np.zeros((300, 1)))
    for stamp, message in zip(STAMPS.tolist(), messages, strict=True):
        writer.write_raw("/x", "sensor_msgs/msg/JointState", stamp, message)
    writer.close()
    with open(path, "rb") as file:
        assert [m.data for _, _, m in make_reader(file, validate_crcs=True).iter_messages()] == messages
    with pytest.raises(FileExistsError):
        LiveBagWriter(path)


def test_flipped_bytes_in_an_mcap_never_end_in_a_traceback(tmp_path, recording):
    chance = random.Random(2)
    verdicts = []
    for _ in range(CASES):
        damaged = bytearray(recording)
        for _ in range(chance.choice((1, 1, 4, 30))):
            damaged[chance.randrange(len(damaged))] = chance.randrange(256)
        (tmp_path / "x.mcap").write_bytes(damaged)
        verdicts.append(survives(tmp_path / "x.mcap"))
    assert verdicts.count(False) > CASES // 2


def test_a_flipped_byte_inside_a_chunk_is_detected(tmp_path, recording):
    damaged = bytearray(recording)
    damaged[len(recording) // 3] ^= 0x10
    (tmp_path / "x.mcap").write_bytes(damaged)
    with pytest.raises(InputError, match="damaged"):
        use_everything(tmp_path / "x.mcap")


@pytest.mark.parametrize(
    "name",
    [
        "split_sqlite_wbag",
        "sqlite_cdr_test",
        "mcap_cdr_test",
        "zstd_file_compressed_split_db3",
        "zstd_message_compressed_split_db3",
    ],
)
def test_real_bags_damaged_at_random_never_end_in_a_traceback(tmp_path, shared_data, name):
    chance = random.Random(3)
    folder = tmp_path / name
    shutil.copytree(shared_data / "rosbag2_bags" / name, folder, copy_function=shutil.copyfile)
    folder.chmod(0o755)
    files = sorted(folder.iterdir())
    for _ in range(24):
        file = chance.choice(files)
        good = file.read_bytes()
        damaged = bytearray(good)
        for _ in range(chance.choice((1, 5, 50))):
            damaged[chance.randrange(len(damaged))] = chance.randrange(256)
        file.write_bytes(damaged if chance.random() < 0.7 else damaged[: chance.randrange(len(damaged))])
        survives(folder)
        file.write_bytes(good)
    assert survives(folder)


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (b"", "empty; record or copy it again"),
        (b"time,force\n0,1\n", "neither mcap nor sqlite3; give an .mcap file or a rosbag2 folder"),
        (b"\x89MCAP0\r\n", "cut off before"),
        (b"\x89MCAP0\r\n\x89MCAP0\r\n", None),
        (b"SQLite format 3\0" + b"\0" * 100, "damaged"),
        (b"\x28\xb5\x2f\xfd", ""),
        (b"\x28\xb5\x2f\xfdxxxxxxxx", "damaged"),
    ],
)
def test_a_file_that_is_no_recording_is_reported(tmp_path, content, complaint):
    path = tmp_path / "x.mcap"
    path.write_bytes(content)
    if complaint is None:
        assert use_everything(path) == 0
        return
    with pytest.raises(InputError, match=f"x.mcap: .*{complaint}"):
        use_everything(path)


def test_a_missing_path_is_named(tmp_path):
    with pytest.raises(InputError, match="nowhere: does not exist; give an .mcap file or a rosbag2 folder"):
        open_bag(tmp_path / "nowhere")


def test_a_folder_without_recording_is_distinguished_from_a_bag_without_metadata(tmp_path):
    with pytest.raises(InputError, match="no rosbag2 folder \\(metadata.yaml is missing\\)"):
        open_bag(tmp_path)
    (tmp_path / "x_0.mcap").touch()
    with pytest.raises(InputError, match="ros2 bag reindex .* \\(or give one file: x_0.mcap\\)"):
        open_bag(tmp_path)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[",
        "{}",
        "rosbag2_bagfile_information: 3",
        "rosbag2_bagfile_information: {relative_file_paths: 3}",
        "\0",
        "a: &a [*a]",
    ],
)
def test_metadata_that_makes_no_sense_is_refused(tmp_path, text):
    (tmp_path / "metadata.yaml").write_text(text)
    with pytest.raises(InputError, match="metadata.yaml: damaged .*; write it again with: ros2 bag reindex"):
        open_bag(tmp_path)


def test_a_missing_part_of_a_split_recording_is_named(tmp_path):
    information = {"relative_file_paths": ["x_0.mcap", "x_1.mcap"], "compression_mode": "", "compression_format": ""}
    (tmp_path / "metadata.yaml").write_text(yaml.safe_dump({"rosbag2_bagfile_information": information}))
    (tmp_path / "x_0.mcap").touch()
    with pytest.raises(InputError, match="x_1.mcap is missing; copy it next to metadata.yaml"):
        open_bag(tmp_path)


def test_another_compression_than_zstd_is_refused(tmp_path):
    information = {"relative_file_paths": [], "compression_mode": "FILE", "compression_format": "lzma"}
    (tmp_path / "metadata.yaml").write_text(yaml.safe_dump({"rosbag2_bagfile_information": information}))
    with pytest.raises(InputError, match="compressed with 'lzma'; only zstd"):
        open_bag(tmp_path)


def test_an_unreadable_file_is_named(tmp_path, recording, monkeypatch):
    path = tmp_path / "x.mcap"
    path.write_bytes(recording)
    real = open

    def denied(name, *more, **options):
        if str(name) == str(path):
            raise PermissionError(13, "Permission denied", str(name))
        return real(name, *more, **options)

    monkeypatch.setattr("builtins.open", denied)  # permissions do not restrict a test that runs as root
    with pytest.raises(InputError, match="x.mcap: cannot be read \\(Permission denied\\)"):
        open_bag(path)


def test_a_topic_with_line_breaks_in_its_name_makes_no_error_of_several_lines(tmp_path):
    path = tmp_path / "odd.mcap"
    with BagWriter(path) as writer:
        messages = joint_states(["a"], STAMPS, position=np.zeros((300, 1)))
        writer.write_messages("/a\nb\x1b[31m", "sensor_msgs/msg/JointState", STAMPS, messages)
    with pytest.raises(InputError) as caught, open_bag(path) as bag:
        next(iter(bag.batches(["/c"])))
    assert one_line(caught.value) and str(caught.value).isprintable() and r"\x1b" in str(caught.value)
