"""Serialised messages to numbers: the structure is looked up once, with any bytes between and after the fields."""

import struct

import numpy as np
import pytest

from damper_estimator.node.wire import MalformedMessage, NumbersReader
from damper_estimator.recordings import joint_states
from damper_estimator.signals import default_signals

JOINT_STATE = "sensor_msgs/msg/JointState"


def message(*names: str) -> bytes:
    values = np.arange(1.0, len(names) + 1.0)[None]
    return joint_states(names, np.array([7]), position=values)[0]


def test_a_structure_is_known_with_any_padding_after_it():
    reader, plain = NumbersReader(JOINT_STATE, ["position[left]", "position[right]"]), message("left", "right")
    assert not reader.knows(plain)
    for tail in (b"", b"\xab" * 8, b"\xcd" * 15, bytes(3), bytes(1000)):
        reading = reader.read(plain + tail)
        assert reading.values.tolist() == [1.0, 2.0] and reading.stamp == 7 and reading.is_whole
    assert reader.knows(plain + b"\x01" * 12)
    assert not reader.knows(plain + bytes(30) + b"\1") and not reader.knows(plain[:-1])
    with pytest.raises(MalformedMessage):
        reader.read(plain + bytes(30) + b"\1")


def test_a_structure_is_known_with_any_padding_between_its_fields():
    """Fast CDR skips the bytes of the alignment without clearing them."""
    reader, plain = NumbersReader(JOINT_STATE, ["position[l]"]), message("l")
    reader.read(plain)
    gaps = [17, 18, 19, 30, 31]  # after the empty frame (16) and after the name (28, 29)
    for place in gaps:
        assert plain[place] == 0
    changed = bytearray(plain)
    for place in gaps:
        changed[place] = 0xCC
    assert reader.knows(bytes(changed)) and reader.read(bytes(changed)).values.tolist() == [1.0]


def test_dampers_whose_names_are_numbers_or_have_brackets_are_read_by_name():
    names = ("2", "1", "left[m]", 'a"b')
    paths = [default_signals(name).displacement.field for name in names[::-1]]
    assert NumbersReader(JOINT_STATE, paths).read(message(*names)).values.tolist() == [4.0, 3.0, 2.0, 1.0]


def test_a_stamp_with_a_second_of_nanoseconds_is_malformed():
    reader, broken = NumbersReader(JOINT_STATE, ["position[l]"]), bytearray(message("l"))
    reader.read(bytes(broken))
    struct.pack_into("<iI", broken, 4, 2**31 - 1, 10**9)
    with pytest.raises(MalformedMessage, match="stamp"):
        reader.read(bytes(broken))
