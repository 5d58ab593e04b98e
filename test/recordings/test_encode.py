"""Encoders equal rosbags' serialisation byte for byte, and their messages can be read back."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rosbags.typesys import get_types_from_msg

from damper_estimator.recordings import (
    accelerations,
    damper_forces,
    encode,
    floats,
    joint_states,
    pressures,
    temperatures,
)
from damper_estimator.recordings.definitions import DAMPER_FORCES, builtin_schema, builtin_store
from damper_estimator.share import share_path

STORE = builtin_store()
TYPES = STORE.types
quick = settings(max_examples=50, deadline=None)
stamps_of = st.lists(st.integers(0, 2**31 * 10**9 - 1), max_size=5).map(lambda items: np.array(items, np.int64))
names_of = st.lists(st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=9), max_size=5)
FIELDS = [
    "displacement", "velocity", "acceleration", "force", "force_stddev",
    "force_min", "force_max", "dforce_dvelocity", "dforce_dcurrent",
]  # fmt: skip


def header(stamp):
    seconds, nanoseconds = divmod(int(stamp), 10**9)
    return TYPES["std_msgs/msg/Header"](TYPES["builtin_interfaces/msg/Time"](seconds, nanoseconds), "")


def serialised(type_name: str, *fields) -> bytes:
    return bytes(STORE.serialize_cdr(TYPES[type_name](*fields), type_name, little_endian=True))


@quick
@given(
    names=names_of,
    stamps=stamps_of,
    given=st.tuples(st.booleans(), st.booleans(), st.booleans()),
    seed=st.integers(0, 99),
)
def test_joint_states_equal_rosbags(names, stamps, given, seed):
    random = np.random.default_rng(seed)
    arrays = [random.normal(size=(len(stamps), len(names))) if there else None for there in given]
    encoded = joint_states(names, stamps, *arrays)
    for row, raw in enumerate(encoded):
        rows = [np.zeros(0) if array is None else array[row] for array in arrays]
        assert raw == serialised("sensor_msgs/msg/JointState", header(stamps[row]), names, *rows)
    assert len(encoded) == len(stamps)


@quick
@given(names=names_of, stamps=stamps_of, seed=st.integers(0, 99))
def test_damper_forces_equal_rosbags(names, stamps, seed):
    random = np.random.default_rng(seed)
    shape = (len(stamps), len(names))
    fields = {field: random.normal(size=shape) for field in FIELDS}
    status = random.integers(0, 5, shape).astype(np.uint8)
    encoded = damper_forces(names, stamps, {**fields, "status": status})
    for row, raw in enumerate(encoded):
        rows = [fields[field][row] for field in FIELDS]
        assert raw == serialised(DAMPER_FORCES, header(stamps[row]), names, *rows, status[row])
    assert len(encoded) == len(stamps)


def test_omitted_fields_of_damper_forces_are_not_available():
    raw = damper_forces(["a", "b"], np.array([5]), {"force": np.array([[1.0, 2.0]])})[0]
    message = STORE.deserialize_cdr(raw, DAMPER_FORCES)
    assert message.force.tolist() == [1.0, 2.0]
    assert np.isnan(message.force_min).all() and len(message.velocity) == 2
    assert message.status.tolist() == [0, 0]


def test_a_misspelt_field_of_damper_forces_is_refused():
    with pytest.raises(ValueError, match="no field forec; there are displacement"):
        damper_forces(["a"], np.array([0]), {"forec": np.zeros((1, 1))})


@quick
@given(stamps=stamps_of, seed=st.integers(0, 99))
def test_plain_and_stamped_numbers_equal_rosbags(stamps, seed):
    values = np.random.default_rng(seed).normal(size=len(stamps))
    zero = TYPES["geometry_msgs/msg/Vector3"]
    for row, value in enumerate(values):
        head = header(stamps[row])
        assert floats(values)[row] == serialised("std_msgs/msg/Float64", value)
        assert temperatures(stamps, values)[row] == serialised("sensor_msgs/msg/Temperature", head, value, 0.0)
        assert pressures(stamps, values)[row] == serialised("sensor_msgs/msg/FluidPressure", head, value, 0.0)
        accel = TYPES["geometry_msgs/msg/Accel"](zero(0.0, 0.0, value), zero(0.0, 0.0, 0.0))
        assert accelerations(stamps, values)[row] == serialised("geometry_msgs/msg/AccelStamped", head, accel)


@pytest.mark.parametrize("type_name", sorted(STORE.fielddefs))
def test_every_known_type_has_a_blank_message(type_name):
    raw = encode(type_name, 1, {})[0]
    STORE.deserialize_cdr(raw, type_name)


def test_an_array_of_the_wrong_length_is_refused():
    with pytest.raises(ValueError, match=r"data: shape \(3,\) does not fit 2 messages"):
        encode("std_msgs/msg/Float64", 2, {"data": np.zeros(3)})


def test_the_message_definition_has_the_fields_of_the_interface():
    text = share_path("msg_defs/msg/DamperForces.msg").read_text()
    constants, fields = get_types_from_msg(text, DAMPER_FORCES)[DAMPER_FORCES]
    assert {name: value for name, _, value in constants} == {
        "GOOD": 0, "WARMING_UP": 1, "EXTRAPOLATING": 2, "DEGRADED": 3, "STALE": 4,
    }  # fmt: skip
    assert [name for name, _ in fields] == ["header", "name", *FIELDS, "status"]
    assert builtin_schema(DAMPER_FORCES).text.count("=" * 80) == 2
