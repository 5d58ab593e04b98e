"""The overview reads little of a recording and still agrees with all of it."""

import numpy as np
import pytest
from fleet_bags import START, write_drive

from damper_estimator.fleet.recording_overview import read_overview
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
    overview = read_overview(str(path), "", str(tmp_path / "out"))
    assert (overview.begin_ns, overview.reason) == (START, "")
    assert overview.seconds == pytest.approx(seconds - 0.005, abs=1e-6)
    assert overview.temperature_c == {"left": pytest.approx(41.0), "right": pytest.approx(41.0)}


def test_a_displacement_that_ends_early_is_found(silent_at_the_end, tmp_path):
    overview = read_overview(str(silent_at_the_end), "", str(tmp_path / "out"))
    assert (overview.begin_ns, overview.temperature_c) == (START, {"left": None})
    assert overview.seconds == pytest.approx(9.995)
