"""A gauge at its limit is detected for any quantum and noise; samples that it affects through the filters do not
count.
"""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from damper_estimator.recordings import BagWriter, joint_states, open_bag
from damper_estimator.signals import SignalMap, low_pass, low_pass_zero_phase, measure
from damper_estimator.signals.clipping import clipped, touched

JOINT_STATE = "sensor_msgs/msg/JointState"
TIME = np.arange(10000) / 500.0


def wave(seed):
    draw = np.random.default_rng(seed)
    waves = np.sin(2 * np.pi * np.linspace(0.5, 9.0, 12) * TIME[:, None] + draw.uniform(0, 6, 12))
    return 300.0 * waves.sum(axis=1) + 3.0 * draw.standard_normal(TIME.size)


@example(seed=720, share=0.5, quantum=3.0)  # four equal samples at a sharp peak, by chance
@given(seed=st.integers(0, 1000), share=st.floats(0.3, 0.6), quantum=st.sampled_from([0.0, 0.5, 3.0, 20.0]))
def test_a_limit_is_found_and_an_unclipped_signal_has_none(seed, share, quantum):
    force = wave(seed)
    force = np.round(force / quantum) * quantum if quantum else force
    assert not clipped(force).any()
    limit = force[np.argmin(np.abs(force - share * force.max()))]  # a possible value of the gauge
    assert np.array_equal(clipped(np.minimum(force, limit)), force >= limit)


@pytest.mark.parametrize("held", [2, 5, 10])
def test_a_gauge_whose_values_are_repeated_is_not_clipped(held):
    assert not clipped(np.repeat(wave(0)[::held], held)).any()
    cut = np.minimum(np.repeat(wave(0)[::held], held), 600.0)
    assert np.array_equal(clipped(cut), cut == 600.0)


def test_constant_friction_is_not_clipped():
    assert not clipped(200.0 * np.clip(20.0 * np.sin(2 * np.pi * TIME), -1.0, 1.0)).any()


def test_a_clipped_sample_changes_little_beyond_its_reach():
    """The error that clipping makes, through both filters, outside and inside the marked samples."""
    force = wave(3)
    cut = np.minimum(force, 700.0)
    dt = np.diff(TIME, prepend=TIME[0])
    error = low_pass_zero_phase(30.0, dt, low_pass(60.0, dt, force - cut))
    stamp = np.round(TIME * 1e9).astype(np.int64)
    marked = touched(stamp, stamp[clipped(cut)], 60.0, 30.0)
    assert 0.1 < marked.mean() < 0.95
    assert np.abs(error[~marked]).max() < 0.03 * np.abs(error).max()


def test_clipped_stretches_are_not_judged(tmp_path):
    stamp = np.round(TIME * 1e9).astype(np.int64)
    force = np.minimum(wave(1), 700.0)
    with BagWriter(tmp_path / "in.mcap") as bag:
        x = joint_states(["fl"], stamp, position=1e-5 * wave(2)[:, None])
        bag.write_messages("/suspension/displacement", JOINT_STATE, stamp, x)
        bag.write_messages("/suspension/force", JOINT_STATE, stamp, joint_states(["fl"], stamp, effort=force[:, None]))
    with open_bag(tmp_path / "in.mcap") as bag:
        m = measure(bag, SignalMap(), "fl")
    spoiled = touched(stamp, stamp[force == 700.0], m.cutoff, m.band)
    assert np.array_equal(m.judged, m.kinematics.warm() & ~spoiled)
    assert np.array_equal(m.part(5000, 10000).judged, m.judged[5000:] & (TIME[5000:] >= TIME[5000] + 0.2 - 1e-9))


def test_values_at_the_gauges_stamps_are_filtered_like_the_gauge(tmp_path):
    stamp = np.round(TIME * 1e9).astype(np.int64)
    with BagWriter(tmp_path / "in.mcap") as bag:
        x = joint_states(["fl"], stamp, position=1e-5 * wave(2)[:, None])
        bag.write_messages("/suspension/displacement", JOINT_STATE, stamp, x)
        gauge_stamp = stamp[::3] + 500_000
        bag.write_messages(
            "/suspension/force", JOINT_STATE, gauge_stamp, joint_states(["fl"], gauge_stamp, effort=wave(1)[::3, None])
        )
    with open_bag(tmp_path / "in.mcap") as bag:
        m = measure(bag, SignalMap(), "fl")
    assert np.array_equal(m.as_gauge(m.gauge), m.force)
