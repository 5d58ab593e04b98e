"""Samples in memory are processed like samples of a bag, and impossible values are refused in one line."""

import numpy as np
import pytest
from drives import RATE, START, samples

from damper_estimator.errors import InputError
from damper_estimator.files import plain
from damper_estimator.signals import DamperSignals, SignalMap, default_signals
from damper_estimator.workflows import Recording, compare, read, replay

TIME, X, FORCE, TEMPERATURE = samples()
STAMPED = START / 1e9 + TIME


def sparse(values):
    """A slow channel: NaN except once a second."""
    slow = np.full(values.size, np.nan)
    slow[::RATE] = values[::RATE]
    return slow


def arrays(**more):
    given = {"force": FORCE, "temperature": sparse(TEMPERATURE), "damper": "front_left"} | more
    return Recording.from_arrays(TIME, X, **given)


def test_samples_of_a_bag_give_the_same_bits_as_the_bag(drive):
    bag, memory = read(drive()), arrays()
    (expected,), (found,) = bag.measurements["front_left"], memory.measurements["front_left"]
    assert np.array_equal(found.kinematics.block, expected.kinematics.block, equal_nan=True)
    assert np.array_equal(found.force, expected.force) and np.array_equal(found.judged, expected.judged)
    record, other = (plain(compare(recording, "linear_viscous").to_dict()["dampers"]) for recording in (bag, memory))
    assert record == other


def test_gaps_commands_and_a_signal_map_work_as_for_a_bag(drive, tmp_path):
    kept = (TIME < 2.0) | (TIME > 2.5)
    current = np.where(TIME < 3.0, 0.5, 1.5)
    memory = Recording.from_arrays(TIME[kept], X[kept], force=FORCE[kept], command=current[kept], damper="front_left")
    (found,) = memory.measurements["front_left"]
    assert found.counts.gaps == 1 and np.count_nonzero(found.kinematics.dt == 0.0) == 2
    (expected,) = read(memory.save(tmp_path / "saved.mcap")).measurements["front_left"]
    assert np.array_equal(found.kinematics.block, expected.kinematics.block, equal_nan=True)
    assert np.array_equal(found.force, expected.force)
    sprung = SignalMap(dampers={"front_left": _sprung(default_signals("front_left"))})
    (less,) = arrays(signals=sprung).measurements["front_left"]
    (whole,) = arrays().measurements["front_left"]
    assert np.allclose(less.force, whole.force - 1000.0 * whole.kinematics.displacement + 20.0)


def _sprung(signals: DamperSignals) -> DamperSignals:
    from dataclasses import replace

    return replace(signals, spring_rate=1000.0, preload=-20.0)


def test_replay_of_arrays_is_replay_of_the_bag_bit_for_bit(drive):
    bag, memory = (replay(recording, "linear_viscous") for recording in (read(drive()), arrays()))
    for name in ("force", "status", "residual"):
        assert np.array_equal(getattr(bag, name), getattr(memory, name)), name


def test_several_dampers_are_a_mapping_by_name():
    other = samples(seed=1)
    both = Recording.from_arrays(
        TIME, {"left": X, "right": other[1]}, force={"left": FORCE, "right": other[2]}, temperature={"left": 30.0}
    )
    assert both.dampers == ("left", "right")
    assert np.all(both.measurements["left"][0].kinematics.temperature == 30.0)
    assert np.isnan(both.measurements["right"][0].kinematics.temperature).all()
    (alone,) = Recording.from_arrays(TIME, X, force=FORCE, damper="left").measurements["left"]
    assert np.array_equal(both.measurements["left"][0].force, alone.force)


REFUSED = {
    "time has shape": {"time": np.zeros((3, 2))},
    "time does not rise at sample 4": {"time": np.where(np.arange(TIME.size) == 4, 0.0, TIME)},
    "in ms": {"time": 1000.0 * TIME},
    "time: 1 of 1200 values are not finite": {"time": np.where(np.arange(TIME.size) == 7, np.nan, TIME)},
    r"displacement of damper: has shape \(1199,\), but time has 1200": {"displacement": X[1:]},
    "displacement of damper: 2 of 1200 values are not finite": {
        "displacement": np.where(np.arange(1200) < 2, np.nan, X)
    },
    "in mm": {"displacement": 1000.0 * X},
    "contains no numbers": {"displacement": ["a"] * 1200},
    r"force of damper: has shape \(\)": {"force": 3.0},
    "force of damper: 1200 of 1200 values are not finite": {"force": np.full(1200, np.inf)},
    "force of damper: reaches 1e": {"force": np.full(1200, 1e9)},
    "in K": {"temperature": 303.0},
    "in bar": {"pressure": 25.0},
    "command of damper: 1200 of 1200": {"command": np.full(1200, np.nan)},
    "force given by damper, but displacement is one array": {"force": {"left": FORCE}},
    "but force is not": {"displacement": {"left": X}, "force": FORCE},
    "force of right, which has no displacement": {"displacement": {"left": X}, "force": {"right": FORCE}},
    "names no damper": {"displacement": {}, "force": None},
}


@pytest.mark.parametrize("words", REFUSED)
def test_impossible_values_are_refused_in_one_line(words):
    given = {"time": TIME, "displacement": X, "force": FORCE} | REFUSED[words]
    with pytest.raises(InputError, match=words) as refused:
        Recording.from_arrays(given.pop("time"), given.pop("displacement"), **given)
    assert str(refused.value).startswith("arrays: ") and "\n" not in str(refused.value)


class Frame(dict):
    """The part of a data frame that ``from_dataframe`` uses, without pandas."""

    @property
    def columns(self):
        return list(self)

    @property
    def index(self):
        return TIME


@pytest.mark.parametrize("frame", [Frame(time=TIME, displacement=X, force=FORCE), Frame(displacement=X, force=FORCE)])
def test_a_data_frame_is_its_columns(frame):
    (found,) = Recording.from_dataframe(frame).measurements["damper"]
    (expected,) = Recording.from_arrays(TIME, X, force=FORCE).measurements["damper"]
    assert np.array_equal(found.force, expected.force)


def test_columns_can_be_renamed_and_missing_ones_are_refused():
    frame = Frame(t=TIME, x=X, load=FORCE)
    columns = {"displacement": "x", "force": "load"}
    (found,) = Recording.from_dataframe(frame, time="t", columns=columns).measurements["damper"]
    assert found.force is not None
    for given, words in (
        ({}, "has no column displacement"),
        ({"columns": {"displacement": "y"}}, "has no column y; it has t, x, load"),
        ({"columns": {"speed": "x"}}, "unknown roles speed"),
        ({"time": "s", "columns": columns}, "has no column s"),
    ):
        with pytest.raises(InputError, match=words):
            Recording.from_dataframe(frame, **given)
