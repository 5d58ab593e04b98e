"""Samples that leave their course: found wherever they are, and in nothing that moves."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from damper_estimator.recordings import BagWriter, joint_states, open_bag
from damper_estimator.signals import measure, parse_signal_map
from damper_estimator.signals.spikes import displacement_spikes, force_spikes

START = 1_700_000_000 * 10**9
RATE = st.sampled_from([100, 250, 500, 1000, 3000])
SEED = st.integers(0, 10_000)


def motion(rate: int, seed: int, seconds: float = 6.0) -> tuple[np.ndarray, np.ndarray]:
    """Stamps that jitter, and waves up to 15 Hz with noise and quantisation of any usual size."""
    draw = np.random.default_rng(seed)
    time = np.arange(round(seconds * rate)) / rate
    waves = zip(10 ** draw.uniform(-3.5, -1.7, 6), draw.uniform(0.3, 15.0, 6), draw.uniform(0.0, 6.0, 6), strict=True)
    x = sum(size * np.sin(2.0 * np.pi * f * time + phase) for size, f, phase in waves)
    x += draw.normal(0.0, 10 ** draw.uniform(-6.0, -4.0), x.size)
    step = 10 ** draw.uniform(-6.0, -3.3)
    stamp = START + np.sort(np.round((time + draw.normal(0.0, 0.05 / rate, x.size)) * 1e9).astype(np.int64))
    return stamp, np.round(x / step) * step


@given(rate=RATE, seed=SEED)
def test_nothing_is_found_in_motion(rate, seed):
    stamp, x = motion(rate, seed)
    assert not displacement_spikes(stamp, x).any()
    assert not force_spikes(stamp, 1e5 * x).any()


@given(rate=RATE, seed=SEED, length=st.integers(1, 5), size=st.floats(0.05, 10.0), sign=st.sampled_from([-1.0, 1.0]))
def test_a_run_is_found_where_it_is_and_nothing_else(rate, seed, length, size, sign):
    assume(rate >= 500 or (rate >= 250 and length == 1))  # at lower rates a wheel moves as far within a few samples
    stamp, x = motion(rate, seed)
    at = 150 + seed % 200
    wild = x.copy()
    wild[at : at + length] += sign * size
    expected = np.zeros(x.size, bool)
    expected[at : at + length] = True
    np.testing.assert_array_equal(displacement_spikes(stamp, wild), expected)


@given(rate=st.sampled_from([250, 500, 1000, 3000]), seed=SEED, seconds=st.floats(0.02, 0.09), rail=st.floats(0.6, 5.0))
def test_a_dropout_to_a_rail_is_found_as_a_whole(rate, seed, seconds, rail):
    stamp, x = motion(rate, seed)
    length = round(seconds * rate)
    wild = x.copy()
    wild[300 : 300 + length] = rail
    expected = np.zeros(x.size, bool)
    expected[300 : 300 + length] = True
    np.testing.assert_array_equal(displacement_spikes(stamp, wild), expected)


def test_a_displacement_in_millimetres_has_no_spikes():
    stamp, x = motion(500, 1)
    assert not displacement_spikes(stamp, 1000.0 * x).any()


@given(rate=st.sampled_from([500, 1000]), seed=SEED, gap=st.integers(8, 60))
def test_bursts_are_found(rate, seed, gap):
    stamp, x = motion(rate, seed)
    at = 200 + gap * np.arange(3)
    wild = x.copy()
    wild[at] = 3.0
    np.testing.assert_array_equal(np.flatnonzero(displacement_spikes(stamp, wild)), at)


@given(seed=SEED, place=st.integers(100, 500))
def test_a_step_and_a_kink_are_no_spikes(seed, place):
    stamp, x = motion(1000, seed)
    time = (stamp - stamp[place]) / 1e9
    assert not displacement_spikes(stamp, x + 0.05 * (time > 0.0)).any(), "a new zero"
    assert not displacement_spikes(stamp, x + 0.5 * np.maximum(time, 0.0)).any(), "a wheel that hits something"


def test_an_end_stop_is_no_spike_of_the_force():
    stamp, x = motion(1000, 3)
    force = 1e4 * x / x.std()
    hit = force.copy()
    hit[2000] += np.ptp(force)
    assert not force_spikes(stamp, hit).any()
    hit[2000] += 5.0 * np.ptp(force)
    assert np.flatnonzero(force_spikes(stamp, hit)).tolist() == [2000]


def test_short_series_and_constants_have_none():
    for size in (0, 1, 2, 50, 500):
        stamp = np.arange(size) * 1_000_000
        assert not displacement_spikes(stamp, np.full(size, 0.3)).any()
        assert not force_spikes(stamp, np.zeros(size)).any()


@pytest.mark.parametrize("windows", [None, [{"from": 0.5, "to": 2.0}, {"from": 3.0, "to": 5.5}]])
def test_a_measurement_is_that_without_the_samples(windows, tmp_path):
    stamp, x = motion(500, 7)
    force = 1500.0 * np.gradient(x, (stamp - stamp[0]) / 1e9)
    wild_x, wild_force = x.copy(), force.copy()
    wild_x[[700, 1800]], wild_force[900] = 4.0, 9e5
    kept_x, kept_force = (np.delete(np.arange(x.size), places) for places in ([700, 1800], [900]))
    everything = np.arange(x.size)
    signal_map = parse_signal_map({"use": windows} if windows else {}, "test")

    def measured(name, x, force, of_x, of_force):
        with BagWriter(tmp_path / name) as bag:
            for topic, values, places in (
                ("displacement", {"position": x}, of_x),
                ("force", {"effort": force}, of_force),
            ):
                ((key, column),) = values.items()
                messages = joint_states(["fl"], stamp[places], **{key: column[places, None]})
                bag.write_messages(f"/suspension/{topic}", "sensor_msgs/msg/JointState", stamp[places], messages)
        with open_bag(tmp_path / name) as bag:
            return measure(bag, signal_map, "fl")

    spoiled = measured("wild.mcap", wild_x, wild_force, everything, everything)
    clean = measured("clean.mcap", x, force, kept_x, kept_force)
    assert set(spoiled.spikes) == {"displacement", "force"} and clean.spikes == {}
    assert spoiled.spikes["displacement"] == pytest.approx(((stamp[[700, 1800]] - stamp[0]) / 1e9).tolist())
    np.testing.assert_array_equal(spoiled.kinematics.block, clean.kinematics.block)
    np.testing.assert_array_equal(spoiled.force, clean.force)
    np.testing.assert_array_equal(spoiled.judged, clean.judged)
