"""A damper of a recording, filtered for comparison: bags written in ``tmp_path``, read by ``measure``."""

import numpy as np
import pytest

from damper_estimator.errors import InputError
from damper_estimator.recordings import BagWriter, floats, joint_states, open_bag, temperatures
from damper_estimator.signals import SignalMap, low_pass, measure, parse_signal_map

JOINT_STATE = "sensor_msgs/msg/JointState"
START = 1_700_000_000 * 10**9
RATE = 500
SECONDS = 6.0
EXACT = 1e-9
BETWEEN_SAMPLES = 2e-3  # of the rms: a signal up to 5 Hz taken as linear between samples at 500 Hz


def stamps(seconds=SECONDS, rate=RATE, first=0.0):
    return START + np.round((first + np.arange(round(seconds * rate)) / rate) * 1e9).astype(np.int64)


def wave(stamp, size=1.0):
    """A smooth signal of time, up to 5 Hz."""
    time = (stamp - START) * 1e-9
    return size * (np.sin(2 * np.pi * 1.1 * time) + 0.4 * np.sin(2 * np.pi * 5.0 * time + 1.0))


def push(stamp):
    return wave(stamp + 123_456_789, 800.0)


@pytest.fixture
def bag_of(tmp_path):
    """Opens a bag written from (topic, type, log, messages) entries."""
    opened = []

    def make(*entries, name="in.mcap"):
        with BagWriter(tmp_path / name) as writer:
            for entry in entries:
                writer.write_messages(*entry)
        opened.append(open_bag(tmp_path / name))
        return opened[-1]

    yield make
    for bag in opened:
        bag.close()


def moved(stamp, x, log=None, topic="/suspension/displacement", name="fl"):
    return (
        topic,
        JOINT_STATE,
        stamp if log is None else log,
        joint_states([name], stamp, position=np.reshape(x, (-1, 1))),
    )


def gauged(stamp, force, topic="/suspension/force", name="fl"):
    return topic, JOINT_STATE, stamp, joint_states([name], stamp, effort=np.reshape(force, (-1, 1)))


def mapped(**dampers):
    return parse_signal_map({"dampers": dampers}, "map.yaml")


def error_share(got, expected):
    return np.sqrt(np.mean((got - expected) ** 2) / np.mean(expected**2))


@pytest.fixture
def plain(bag_of):
    """Displacement and force on the same stamps, default map."""
    stamp = stamps()
    return measure(bag_of(moved(stamp, wave(stamp, 0.01)), gauged(stamp, push(stamp))), SignalMap(), "fl")


def test_force_and_displacement_pass_the_same_filter(bag_of):
    stamp = stamps()
    m = measure(bag_of(moved(stamp, wave(stamp, 0.01)), gauged(stamp, wave(stamp, 2e4 * 0.01))), SignalMap(), "fl")
    assert m.force == pytest.approx(2e4 * m.kinematics.displacement, abs=EXACT)
    assert m.raw_displacement == pytest.approx(wave(stamp, 0.01)) and m.gauge == pytest.approx(wave(stamp, 200.0))
    assert m.judged.sum() == stamp.size - 100 and not m.judged[:100].any()


def test_spring_and_preload_are_subtracted_from_the_gauge(bag_of, plain):
    stamp = stamps()
    gauge = push(stamp) + 28_000.0 * wave(stamp, 0.01) - 3000.0
    chain = mapped(fl={"force": {"spring_rate": 28_000.0, "preload": -3000.0}})
    m = measure(bag_of(moved(stamp, wave(stamp, 0.01)), gauged(stamp, gauge)), chain, "fl")
    assert m.force == pytest.approx(plain.force, abs=1e-6)


@pytest.mark.parametrize("late", [-0.0123, 0.0, 0.004, 0.0051])
def test_a_late_force_is_corrected_by_its_skew(late, bag_of, plain):
    stamp = stamps()
    measured = push(stamp - round(late * 1e9))  # F_measured(t) = F(t - skew)
    bag = bag_of(moved(stamp, wave(stamp, 0.01)), gauged(stamp, measured))
    m = measure(bag, mapped(fl={"force": {"skew": late}}), "fl")
    both = m.judged & plain.judged
    assert error_share(m.force[both], plain.force[both]) < BETWEEN_SAMPLES and both.sum() > 2850


def test_a_late_displacement_is_corrected_by_its_skew(bag_of, plain):
    stamp = stamps()
    bag = bag_of(moved(stamp + 7_000_000, wave(stamp, 0.01)), gauged(stamp, push(stamp)))
    m = measure(bag, mapped(fl={"displacement": {"skew": 0.007}}), "fl")
    assert np.array_equal(m.kinematics.stamp, stamp) and m.force == pytest.approx(plain.force, abs=EXACT)


def test_table_and_scale_convert_raw_numbers_to_si(bag_of):
    stamp = stamps()
    raw = wave(stamp, 40.0)
    table = {"raw": [-100.0, 0.0, 100.0], "value": [0.08, 0.0, -0.05]}
    chain = mapped(fl={"displacement": {"table": table}, "force": {"scale": -9.81, "offset": 12.0}})
    m = measure(bag_of(moved(stamp, raw), gauged(stamp, push(stamp))), chain, "fl")
    expected = np.where(raw < 0.0, -0.0008 * raw, -0.0005 * raw)
    assert m.raw_displacement == pytest.approx(expected, abs=EXACT)
    assert m.gauge == pytest.approx(-9.81 * push(stamp) + 12.0, abs=EXACT)


@pytest.mark.parametrize("rate", [173, 1000, 2500])
def test_the_force_can_have_another_rate(rate, bag_of, plain):
    stamp, gauge_stamp = stamps(), stamps(rate=rate, first=-0.0007)
    m = measure(bag_of(moved(stamp, wave(stamp, 0.01)), gauged(gauge_stamp, push(gauge_stamp))), SignalMap(), "fl")
    tolerance = BETWEEN_SAMPLES * max(1.0, (RATE / rate) ** 2)
    inside = m.judged & plain.judged
    assert error_share(m.force[inside], plain.force[inside]) < tolerance and inside.sum() > 2850


def test_a_gap_in_the_force_and_the_warm_up_after_it_are_not_judged(bag_of):
    stamp = stamps()
    time = (stamp - START) * 1e-9
    there = (time < 2.0) | (time >= 2.5)
    m = measure(bag_of(moved(stamp, wave(stamp, 0.01)), gauged(stamp[there], push(stamp[there]))), SignalMap(), "fl")
    assert np.array_equal(m.judged, (time >= 0.2) & ((time < 2.0) | (time >= 2.7)))
    assert m.counts.gaps == 0 and len(m.kinematics) == stamp.size


def test_a_gap_in_the_force_below_the_limit_is_bridged(bag_of, plain):
    stamp = stamps()
    there = np.ones(stamp.size, bool)
    there[1000:1005] = False
    m = measure(bag_of(moved(stamp, wave(stamp, 0.01)), gauged(stamp[there], push(stamp[there]))), SignalMap(), "fl")
    assert np.array_equal(m.judged, plain.judged) and error_share(m.force, plain.force) < BETWEEN_SAMPLES


def test_a_gap_in_the_displacement_restarts_filter_and_warm_up(bag_of):
    stamp = stamps()
    stamp[1500:] += 10**9
    m = measure(bag_of(moved(stamp, wave(stamp, 0.01)), gauged(stamp, push(stamp))), SignalMap(), "fl")
    assert m.counts.gaps == 1 and np.flatnonzero(m.kinematics.dt == 0.0).tolist() == [0, 1500]
    assert (
        m.kinematics.displacement[1500] == pytest.approx(wave(stamp, 0.01)[1500]) and m.kinematics.velocity[1500] == 0.0
    )
    assert not m.judged[1500:1600].any() and m.judged[1600:].all()
    dt = np.diff(stamp, prepend=stamp[0]) / 1e9
    dt[1500] = 0.0
    assert m.force == pytest.approx(low_pass(60.0, dt, push(stamp)), abs=EXACT)


def test_samples_are_ordered_by_stamp_and_what_a_node_would_drop_is_counted(bag_of, plain):
    stamp = stamps()
    order = np.arange(stamp.size)
    order[700], order[701] = 701, 700
    bag = bag_of(moved(stamp[order], wave(stamp[order], 0.01), log=stamp), gauged(stamp, push(stamp)))
    m = measure(bag, SignalMap(), "fl")
    assert m.counts.inversions == 1 and np.array_equal(m.kinematics.stamp, stamp)
    assert np.array_equal(m.kinematics.block, plain.kinematics.block, equal_nan=True)


def test_equal_stamps_and_nan_are_dropped_and_counted(bag_of):
    stamp = stamps()
    x = wave(stamp, 0.01)
    log = stamp.copy()
    stamp[10] = stamp[9]
    x[20] = np.nan
    force = push(stamp)
    force[30] = np.inf
    m = measure(bag_of(moved(stamp, x, log=log), gauged(log, force)), SignalMap(), "fl")
    assert (m.counts.duplicates, m.counts.non_finite, m.counts.samples) == (1, 1, stamp.size)
    assert len(m.kinematics) == stamp.size - 2 == m.raw_displacement.size == m.force.size
    assert np.isfinite(m.force).all() and m.raw_displacement[9] == x[9]


def test_windows_of_the_map_and_of_the_call_are_intersected(bag_of, plain):
    stamp = stamps()
    bag = bag_of(moved(stamp, wave(stamp, 0.01)), gauged(stamp, push(stamp)))
    windowed = parse_signal_map({"use": [{"from": 0.5, "to": 2.0}, {"from": 3.0}]}, "map.yaml")
    m = measure(bag, windowed, "fl", start=1.0, end=4.0)
    time = m.kinematics.time
    assert np.all(((time >= 1.0) & (time < 2.0)) | ((time >= 3.0) & (time < 4.0))) and time.size == 1000
    assert len(m.kinematics.stretches()) == 2 and m.judged.sum() == 800
    settled = np.isin(plain.kinematics.stamp, m.kinematics.stamp[m.judged])
    assert error_share(m.force[m.judged], plain.force[settled]) < 1e-6


def test_an_empty_window_is_refused(bag_of):
    stamp = stamps(1.0)
    bag = bag_of(moved(stamp, wave(stamp)), gauged(stamp, push(stamp)))
    with pytest.raises(InputError, match=r"in.mcap: no samples of damper 'fl' from 7 to inf s"):
        measure(bag, SignalMap(), "fl", start=7.0)


def test_stamps_that_never_change_are_refused_with_the_reason(bag_of):
    stamp = stamps(1.0)
    bag = bag_of(moved(np.zeros_like(stamp), wave(stamp)), gauged(stamp, push(stamp)))
    with pytest.raises(InputError, match="only one of .* displacement samples .* let the driver stamp every sample"):
        measure(bag, SignalMap(), "fl")


def test_default_topics_are_found_inside_a_namespace(bag_of, plain):
    stamp = stamps()
    inside = "/car_7/suspension"
    bag = bag_of(
        moved(stamp, wave(stamp, 0.01), topic=f"{inside}/displacement"),
        gauged(stamp, push(stamp), topic=f"{inside}/force"),
        (
            f"{inside}/fl/temperature",
            "sensor_msgs/msg/Temperature",
            stamp[::500],
            temperatures(stamp[::500], np.arange(6.0)),
        ),
    )
    m = measure(bag, SignalMap(), "fl")
    assert np.array_equal(m.force, plain.force) and m.kinematics.temperature[-1] == 5.0


def test_slow_channels_hold_their_last_value_by_stamp(bag_of):
    stamp = stamps()
    command_stamp = START + np.array([1, 3]) * 10**9
    bag = bag_of(
        moved(stamp, wave(stamp, 0.01)),
        gauged(stamp, push(stamp)),
        ("/suspension/fl/current", "std_msgs/msg/Float64", command_stamp, floats(np.array([0.5, 1.5]))),
    )
    m = measure(bag, SignalMap(), "fl")
    time = m.kinematics.time
    expected = np.where(time < 1.0, np.nan, np.where(time < 3.0, 0.5, 1.5))
    assert np.array_equal(m.kinematics.command, expected, equal_nan=True) and np.isnan(m.kinematics.temperature).all()


def test_a_name_is_looked_up_in_every_message(bag_of, plain):
    stamp = stamps()
    x = wave(stamp, 0.01)
    entries = []
    for i, time in enumerate(stamp):
        names, values = (["fl", "fr"], [x[i], 9.0]) if i % 2 else (["fr", "fl"], [9.0, x[i]])
        entries.append(
            (
                "/suspension/displacement",
                JOINT_STATE,
                [time],
                joint_states(names, np.array([time]), position=np.array([values])),
            )
        )
    lacking = np.array([stamp[-1] + 1_000_000])
    entries.append(
        ("/suspension/displacement", JOINT_STATE, lacking, joint_states(["fr"], lacking, position=np.array([[9.0]])))
    )
    m = measure(bag_of(*entries, gauged(stamp, push(stamp))), SignalMap(), "fl")
    assert np.array_equal(m.kinematics.block, plain.kinematics.block, equal_nan=True)


def test_a_part_keeps_its_forces_and_warms_up_again(plain):
    part = plain.part(1000, 2000)
    assert np.array_equal(part.force, plain.force[1000:2000]) and part.kinematics.dt[0] == 0.0
    assert not part.judged[:100].any() and part.judged[100:].all()


def test_a_missing_force_is_an_error_only_if_it_is_needed(bag_of):
    stamp = stamps(1.0)
    bag = bag_of(moved(stamp, wave(stamp)))
    assert measure(bag, SignalMap(), "fl", force_wanted=False).force is None
    with pytest.raises(InputError, match=r"in.mcap: has no measured force of damper 'fl'"):
        measure(bag, SignalMap(), "fl")


def test_a_force_of_another_time_is_refused(bag_of):
    stamp = stamps(1.0)
    bag = bag_of(moved(stamp, wave(stamp)), gauged(stamp + 10**12, push(stamp)))
    with pytest.raises(InputError, match="not recorded at the same time"):
        measure(bag, SignalMap(), "fl")


@pytest.mark.parametrize(
    ("channel", "reason"),
    [
        ({"displacement": {"topic": "/nowhere"}}, "/nowhere"),
        ({"force": {"topic": "/nowhere"}}, "/nowhere"),
        ({"displacement": {"field": "positions[fl]"}}, "positions"),
        ({"displacement": {"field": "position[rear]"}}, "rear"),
        ({"temperature": {}}, "temperature"),
    ],
)  # fmt: skip
def test_a_channel_of_the_map_that_the_bag_lacks_is_an_error(channel, reason, bag_of):
    stamp = stamps(1.0)
    bag = bag_of(moved(stamp, wave(stamp)), gauged(stamp, push(stamp)))
    with pytest.raises(InputError, match=r"in.mcap") as refusal:
        measure(bag, mapped(fl=channel), "fl")
    assert reason in str(refusal.value) and "\n" not in str(refusal.value)


def test_an_unknown_damper_is_answered_with_the_existing_ones(bag_of):
    stamp = stamps(1.0)
    bag = bag_of(moved(stamp, wave(stamp)), gauged(stamp, push(stamp)))
    with pytest.raises(InputError, match=r"has no damper 'rear'; it has fl"):
        measure(bag, SignalMap(), "rear")
