"""Bags that real rosbag2 and mcap tools wrote: read, or refused with a clear reason."""

from pathlib import Path

import numpy as np
import pytest

from damper_estimator.errors import InputError
from damper_estimator.recordings import open_bag

# Messages by topic, from the bags' provenance.
WBAG = {"AAA": 804, "BBB": 742, "CCC": 742, "DDD": 753, "EEE": 804, "FFF": 772, "GGG": 731, "HHH": 726}
BAGS = {
    "split_sqlite_wbag": WBAG,
    "split_mcap_wbag": WBAG,
    "mcap_talker": {"/parameter_events": 0, "/rosout": 10, "/topic": 10},
    "sqlite_talker": {"/parameter_events": 0, "/rosout": 10, "/topic": 10},
    "mcap_cdr_test": {"/array_topic": 4, "/test_topic": 3},
    "sqlite_cdr_test": {"/array_topic": 4, "/test_topic": 3},
    "mcap_topics_services": {
        "/events/write_split": 0,
        "/test_service1/_service_event": 4,
        "/test_service2/_service_event": 4,
        "/test_topic1": 1,
        "/test_topic2": 1,
    },
    "zstd_message_compressed_split_db3": {"/parameter_events": 0, "/rosout": 758, "/topic": 369},
    "zstd_file_compressed_split_db3": {"/parameter_events": 0, "/rosout": 392, "/topic": 383},
    "zstd_file_compressed_db3": {"/parameter_events": 0, "/rosout": 0},
}


@pytest.fixture
def bags(shared_data: Path) -> Path:
    return shared_data / "rosbag2_bags"


@pytest.mark.parametrize("name", BAGS)
def test_topics_and_counts_of_every_real_bag(bags, name):
    with open_bag(bags / name) as bag:
        assert {topic.name: topic.messages for topic in bag.topics} == BAGS[name]
        counted = {topic.name: 0 for topic in bag.topics}
        for batch in bag.batches():
            for connection, _, _ in batch.raw():
                counted[connection.topic] += 1
    assert counted == BAGS[name]


@pytest.mark.parametrize("name", BAGS)
def test_log_times_never_step_back_and_ranks_count_all_messages(bags, name):
    with open_bag(bags / name) as bag:
        batches = list(bag.batches(size=100))
    log = np.concatenate([np.empty(0, np.int64), *(batch.log for batch in batches)])
    rank = np.concatenate([np.empty(0, np.int64), *(batch.rank for batch in batches)])
    assert (np.diff(log) >= 0).all()
    assert (rank == np.arange(sum(BAGS[name].values()))).all()
    assert all(len(batch) <= 100 for batch in batches)


@pytest.mark.parametrize("name", ["mcap_talker", "sqlite_talker"])
def test_talkers_that_other_readers_find_empty_are_read_whole(bags, name):
    with open_bag(bags / name) as bag:
        texts = [message.data for batch in bag.batches() for _, message in batch.messages("/topic")]
    assert texts == [f"Hello, world! {number}" for number in range(10)]


def test_sqlite_and_mcap_twins_agree_in_order_and_content(bags):
    def texts(name: str) -> list[tuple[int, str, bytes]]:
        with open_bag(bags / name) as bag:
            return [(log, item.topic, data) for batch in bag.batches() for item, log, data in batch.raw()]

    assert sorted(texts("split_sqlite_wbag")) == sorted(texts("split_mcap_wbag"))


@pytest.mark.parametrize("name", ["zstd_message_compressed_split_db3", "zstd_file_compressed_split_db3"])
def test_compressed_bags_decode(bags, name):
    with open_bag(bags / name) as bag:
        lines = bag.columns("/rosout", ["line", "level"])
        texts = [message.data for batch in bag.batches(["topic"]) for _, message in batch.messages("topic")]
    assert lines.present.all() and (lines.values[:, 1] == 20).all()
    assert all(text.startswith("Hello, world!") for text in texts)


@pytest.mark.parametrize("name", ["mcap_cdr_test", "sqlite_cdr_test"])
def test_number_fields_of_all_kinds_agree_with_whole_decoding(bags, name):
    fields = [
        f"{kind}_values[{index}]" for kind in ("int8", "uint16", "int64", "float32", "float64") for index in (0, 2)
    ]
    with open_bag(bags / name) as bag:
        columns = bag.columns("/array_topic", fields)
        whole = [message for batch in bag.batches() for _, message in batch.messages("/array_topic")]
    for row, message in enumerate(whole):
        expected = [getattr(message, field[:-3])[int(field[-2])] for field in fields]
        assert columns.values[row].tolist() == [float(value) for value in expected]


def test_a_service_event_is_listed_but_refused_by_name(bags):
    with open_bag(bags / "mcap_topics_services") as bag:
        with pytest.raises(
            InputError, match=r"/test_service1/_service_event: test_msgs/srv/BasicTypes_Event is a service"
        ):
            bag.columns("/test_service1/_service_event", ["info.event_type"])


def test_a_definition_that_contradicts_the_messages_is_refused(bags):
    # The bag declares "uint8 level" for messages of 176 bytes.
    with (
        open_bag(bags / "sqlite_talker") as bag,
        pytest.raises(InputError, match="does not fit its type rcl_interfaces/msg/Log"),
    ):
        bag.columns("/rosout", ["level"])
