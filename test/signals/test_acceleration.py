"""A measured acceleration is part of the measurement, filtered like the force."""

import numpy as np
import pytest

from damper_estimator.recordings import BagWriter, Stream, joint_states, open_bag
from damper_estimator.recordings.encode import accelerations
from damper_estimator.signals import load_signal_map, measure

KIND = "sensor_msgs/msg/JointState"


def bag(tmp_path, with_acceleration=True, hole=None):
    rate = 500.0
    time = np.arange(4000) / rate
    stamps = np.round(1e9 * (5.0 + time)).astype(np.int64)
    x = 0.01 * np.sin(4.0 * np.pi * time)[:, None]
    a = -0.01 * (4.0 * np.pi) ** 2 * np.sin(4.0 * np.pi * time)
    streams = [
        Stream("/suspension/displacement", KIND, stamps, joint_states(["d"], stamps, position=x)),
        Stream("/suspension/force", KIND, stamps, joint_states(["d"], stamps, effort=x)),
    ]
    if with_acceleration:
        keep = np.ones(time.size, bool) if hole is None else (time < hole[0]) | (time > hole[1])
        messages = accelerations(stamps[keep], a[keep])
        streams.append(Stream("/suspension/d/acceleration", "geometry_msgs/msg/AccelStamped", stamps[keep], messages))
    with BagWriter(tmp_path / "a.mcap") as writer:
        writer.write_streams(streams)
    with open_bag(tmp_path / "a.mcap") as opened:
        return measure(opened, load_signal_map(None), "d")


def test_without_an_accelerometer_there_is_none(tmp_path):
    assert bag(tmp_path, with_acceleration=False).acceleration is None


def test_it_passes_the_same_filter_as_the_displacement(tmp_path):
    measured = bag(tmp_path)
    late = measured.judged
    assert measured.acceleration[late] == pytest.approx(measured.kinematics.acceleration[late], abs=0.02)


def test_a_gap_is_nan_and_removes_no_force(tmp_path):
    measured = bag(tmp_path, hole=(3.0, 3.5))
    time = measured.kinematics.time
    assert np.isnan(measured.acceleration[(time > 3.05) & (time < 3.45)]).all()
    assert np.isfinite(measured.acceleration[time < 2.95]).all()
    assert measured.judged[(time > 3.05) & (time < 3.45)].all()


def test_a_part_keeps_it(tmp_path):
    measured = bag(tmp_path)
    assert measured.part(100, 300).acceleration == pytest.approx(measured.acceleration[100:300])
