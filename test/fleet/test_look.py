"""A first look reads little, and sees what the whole recording says."""

import numpy as np
import pytest
from fleet_bags import START, write_drive

from damper_estimator.fleet.look import take_look
from damper_estimator.recordings import BagWriter, Stream, joint_states

STATE = "sensor_msgs/msg/JointState"


@pytest.fixture()
def silent_at_the_end(tmp_path):
    """Displacement for ten seconds, then another topic alone until the recorder is stopped."""
    stamp = START + np.arange(2000) * 5_000_000
    rest = stamp[-1] + np.arange(40_000) * 1_000_000
    streams = [
        Stream("/suspension/displacement", STATE, stamp, joint_states(["left"], stamp, position=np.ones((2000, 1)))),
        Stream("/other", STATE, rest, joint_states(["noise"] * 20, rest, effort=np.ones((40_000, 20)))),
    ]
    path = tmp_path / "silent.mcap"
    with BagWriter(path) as bag:
        bag.write_streams(streams)
    return path


@pytest.mark.parametrize("seconds", [0.5, 60.0, 600.0])
def test_begin_length_and_temperature_are_those_of_the_whole_recording(tmp_path, seconds):
    path = write_drive(tmp_path / "bag.mcap", dampers=("left", "right"), warm=41.0, seconds=seconds)
    look = take_look(str(path), "", str(tmp_path / "out"))
    assert (look.begin_ns, look.reason) == (START, "")
    assert look.seconds == pytest.approx(seconds - 0.005, abs=1e-6)
    assert look.temperature_c == {"left": pytest.approx(41.0), "right": pytest.approx(41.0)}


def test_a_displacement_that_ends_early_is_found_all_the_same(silent_at_the_end, tmp_path):
    look = take_look(str(silent_at_the_end), "", str(tmp_path / "out"))
    assert (look.begin_ns, look.temperature_c) == (START, {"left": None})
    assert look.seconds == pytest.approx(9.995)
