"""Fields of serialised messages: one array per structure, the same numbers as decoding each message."""

import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from damper_estimator.errors import InputError
from damper_estimator.recordings.cdr_layout import MalformedMessage
from damper_estimator.recordings.decode import Decoder
from damper_estimator.recordings.definitions import Schema, builtin_schema, definition_of, store_of

JOINT_STATE = definition_of(builtin_schema("sensor_msgs/msg/JointState"))
NAMES = ["front_left", "rear_left", "fl", "hinten_links_ä", ""]
FIELDS = [
    "position[front_left]",
    "position[rear_left]",
    "position[1]",
    "velocity[fl]",
    "effort[0]",
    "effort[hinten_links_ä]",
]
quick = settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])

numbers = st.floats(width=64)
one_message = st.builds(
    dict,
    stamp=st.integers(0, 2**31 * 10**9 - 1),
    names=st.lists(st.sampled_from(NAMES), max_size=4, unique=True),
    position=st.lists(numbers, max_size=4),
    velocity=st.lists(numbers, max_size=4),
    effort=st.lists(numbers, max_size=4),
    frame=st.sampled_from(["", "a", "base_link"]),
    little_endian=st.booleans(),
)


def decode(messages: list[bytes], fields: list[str], definition=JOINT_STATE):
    length = np.array([len(message) for message in messages], np.int64)
    return Decoder(definition, fields).decode(b"".join(messages), np.cumsum(length) - length, length)


def expected(message: dict, field: str) -> float | None:
    array, index = message[field[: field.index("[")]], field[field.index("[") + 1 : -1]
    if not index.isdigit():
        if index not in message["names"]:
            return None
        index = message["names"].index(index)
    return array[int(index)] if int(index) < len(array) else None


@quick
@given(messages=st.lists(one_message, max_size=12))
def test_any_mixture_of_structures_decodes_to_what_was_sent(joint_state, messages):
    read = decode([joint_state(**message) for message in messages], FIELDS)
    for row, message in enumerate(messages):
        for column, field in enumerate(FIELDS):
            value = expected(message, field)
            assert read.present[row, column] == (value is not None)
            sent = math.nan if value is None else value
            assert read.values[row, column] == sent or (math.isnan(sent) and math.isnan(read.values[row, column]))
        assert read.stamp[row] == message["stamp"]


def test_a_nan_that_was_sent_is_present(joint_state):
    read = decode([joint_state(names=["a"], position=[math.nan]), joint_state(names=["a"])], ["position[a]"])
    assert read.present.tolist() == [[True], [False]]
    assert np.isnan(read.values).all()


def test_names_of_equal_length_in_changed_order_are_followed(joint_state):
    messages = [joint_state(names=order, position=[1.0, 2.0]) for order in (["ab", "cd"], ["cd", "ab"]) * 50]
    read = decode(messages, ["position[ab]", "position[cd]"])
    assert read.values.tolist() == [[1.0, 2.0], [2.0, 1.0]] * 50


def test_a_block_of_one_structure_after_a_block_of_two(joint_state):
    first, second = (joint_state(names=order, position=[1.0, 2.0]) for order in (["ab", "cd"], ["cd", "ab"]))
    decoder = Decoder(JOINT_STATE, ["position[ab]"])
    for block in ([first, second], [first, first], [second]):
        length = np.array([len(message) for message in block], np.int64)
        read = decoder.decode(b"".join(block), np.cumsum(length) - length, length)
        assert read.values[:, 0].tolist() == [1.0 if message is first else 2.0 for message in block]


def test_more_structures_than_are_remembered_are_still_read(joint_state):
    names = [f"damper_{number:04}" for number in range(200)]
    messages = [joint_state(names=[name, "wanted"], position=[0.0, float(row)]) for row, name in enumerate(names)] * 2
    read = decode(messages, ["position[wanted]"])
    assert read.values[:, 0].tolist() == [float(row) for row in range(200)] * 2


def test_the_same_path_twice_and_two_ways_to_one_element(joint_state):
    read = decode([joint_state(names=["a", "b"], position=[1.0, 2.0])], ["position[b]", "position[1]", "position[b]"])
    assert read.values.tolist() == [[2.0, 2.0, 2.0]]


def test_nested_fields_integers_and_booleans_become_numbers():
    definition = (
        "bool on\nint16[3] steps\nInner[] inner\nuint64 last\n"
        + "=" * 80
        + "\nMSG: x_msgs/Inner\nstring label\nint8 depth\nfloat32 z\n"
    )
    schema = Schema("x_msgs/msg/Outer", "ros2msg", definition)
    types = store_of(schema).types
    inner = [types["x_msgs/msg/Inner"]("label", -5, 0.5), types["x_msgs/msg/Inner"]("", 7, -1.5)]
    message = types["x_msgs/msg/Outer"](True, np.array([1, -2, 3], np.int16), inner, 2**53)
    for little_endian in (True, False):
        raw = bytes(store_of(schema).serialize_cdr(message, "x_msgs/msg/Outer", little_endian=little_endian))
        read = decode(
            [raw], ["on", "steps[1]", "inner[1].depth", "inner[0].z", "inner[2].z", "last"], definition_of(schema)
        )
        assert read.values[0, [0, 1, 2, 3, 5]].tolist() == [1.0, -2.0, 7.0, 0.5, 2.0**53]
        assert read.present[0].tolist() == [True, True, True, True, False, True]
        assert read.stamp is None


def test_names_of_an_inner_message_take_precedence_over_outer_ones():
    definition = (
        "string[] name\nInner inner\nfloat64[] outer\n"
        + "=" * 80
        + "\nMSG: x_msgs/Inner\nfloat64[] value\nstring[2] name\n"
    )
    schema = Schema("x_msgs/msg/Named", "ros2msg", definition)
    types = store_of(schema).types
    inner = types["x_msgs/msg/Inner"](np.array([1.0, 2.0]), ["b", "a"])
    raw = bytes(
        store_of(schema).serialize_cdr(types["x_msgs/msg/Named"](["a", "b"], inner, np.array([3.0, 4.0])), schema.type)
    )
    read = decode([raw], ["inner.value[a]", "outer[a]"], definition_of(schema))
    assert read.values.tolist() == [[2.0, 3.0]]


@pytest.mark.parametrize(
    ("path", "complaint"),
    [
        ("speed[a]", "has no field 'speed'; there are header, name, position, velocity, effort"),
        ("header.stamp.hours", "has no field 'hours'; there are sec, nanosec"),
        ("position", "is an array; add an index such as position\\[0\\]"),
        ("header.stamp", "ends at a builtin_interfaces/msg/Time; continue with sec, nanosec"),
        ("header.frame_id", "is a string, not a number"),
        ("name[0]", "is a string, not a number"),
        ("header[0].stamp", "gives an index to 'header', which is no array"),
        ("position[0].x", "has 'x' below a field without fields"),
        ("position[", "is no field path"),
        ("", "is no field path"),
        ("position[a] ", "is no field path"),
        (".position[a]", "is no field path"),
        ("position[a].", "is no field path"),
    ],
)
def test_a_wrong_path_is_answered_with_the_existing_fields(path, complaint):
    with pytest.raises(InputError, match=complaint):
        Decoder(JOINT_STATE, [path])


def test_an_index_beyond_a_fixed_array_is_refused_at_once():
    imu = definition_of(builtin_schema("sensor_msgs/msg/Imu"))
    with pytest.raises(InputError, match="has index 9, but 'orientation_covariance' has 9 elements"):
        Decoder(imu, ["orientation_covariance[9]"])


@pytest.mark.parametrize(
    ("type_name", "text"),
    [
        ("x/msg/3rd", "float64 a"),
        ("x/msg/A:\n    pass\nimport os\nclass B", "float64 a"),
        ("x/msg/A", "y/B b\n" + "=" * 80 + "\nMSG: y/B;import os\nfloat64 a"),
    ],
)
def test_a_schema_cannot_inject_code(type_name, text):
    """Names become Python code when whole messages are decoded."""
    with pytest.raises(InputError):
        store_of(Schema(type_name, "ros2msg", text))


@quick
@given(
    message=one_message,
    cut=st.integers(0, 400),
    flips=st.lists(st.tuples(st.integers(0, 400), st.integers(0, 255)), max_size=4),
)
def test_damaged_messages_are_read_or_malformed(joint_state, message, cut, flips):
    raw = bytearray(joint_state(**message)[: cut or None])
    for place, value in flips:
        if place < len(raw):
            raw[place] = value
    try:
        decode([bytes(raw)], FIELDS)
    except MalformedMessage:
        pass
