"""Messages and recordings for several tests of this folder."""

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

from damper_estimator.recordings.definitions import builtin_store


@pytest.fixture(scope="session")
def store() -> Typestore:
    return builtin_store()


@pytest.fixture(scope="session")
def jazzy() -> Typestore:
    """The type store of another program, without this project's types."""
    return get_typestore(Stores.ROS2_JAZZY)


@pytest.fixture(scope="session")
def joint_state(store):
    """Serialises one JointState with rosbags."""

    def make(stamp=0, names=(), position=(), velocity=(), effort=(), frame="", little_endian=True) -> bytes:
        types = store.types
        seconds, nanoseconds = divmod(stamp, 10**9)
        header = types["std_msgs/msg/Header"](types["builtin_interfaces/msg/Time"](seconds, nanoseconds), frame)
        arrays = (np.array(values, float) for values in (position, velocity, effort))
        message = types["sensor_msgs/msg/JointState"](header, list(names), *arrays)
        return bytes(store.serialize_cdr(message, "sensor_msgs/msg/JointState", little_endian=little_endian))

    return make
