"""The live line of a vehicle: slow channels are held, and estimates of the same message are published together."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from damper_estimator.effects.discovery import find_effect
from damper_estimator.model import make_element
from damper_estimator.model.damper_model import DamperModel
from damper_estimator.runtime import Arrivals, DamperEstimator, SampleAndHold, VehicleLine, deployed, group_equal_keys

MODEL = DamperModel("viscous", "", (make_element(find_effect("linear_viscous")),))


def arrivals(rank, value):
    rank = np.asarray(rank, np.int64)
    return Arrivals(rank, rank * 1_000_000, np.asarray(value, float))


@given(
    st.lists(st.tuples(st.booleans(), st.floats(-9, 9)), min_size=1, max_size=40),
    st.lists(st.integers(0, 40), max_size=4)
)  # fmt: skip
def test_a_held_channel_is_the_last_received_value_for_any_division_into_blocks(messages, cuts):
    """Each message is either a value of the channel or a query of it."""
    expected, counts, last, count = [], [], np.nan, 0
    for is_value, value in messages:
        if is_value:
            last, count = value, count + 1
        else:
            expected.append(last)
            counts.append(count)
    channel, got, heard = SampleAndHold(), [], []
    edges = sorted({0, len(messages), *(cut for cut in cuts if cut < len(messages))})
    for first, end in zip(edges, edges[1:], strict=False):
        slow = [i for i in range(first, end) if messages[i][0]]
        asked = np.array([i for i in range(first, end) if not messages[i][0]], np.int64)
        held = channel.at(asked, arrivals(slow, [messages[i][1] for i in slow]) if slow else None)
        got += np.broadcast_to(held.value, asked.shape).tolist()
        heard += np.broadcast_to(held.received, asked.shape).tolist()
    assert np.array_equal(got, expected, equal_nan=True) and heard == counts


def test_slow_channels_reach_the_estimates():
    line = VehicleLine({"one": DamperEstimator(deployed(MODEL, 60.0, 0.1))})
    moved = arrivals([0, 2, 4, 6], [0.0, 0.001, 0.002, 0.003])
    _, estimates = line.block({"one": moved}, {"one": {"temperature": arrivals([1, 5], [20.0, 30.0])}})
    assert np.array_equal(estimates["one"].kinematics.temperature, [np.nan, 20.0, 20.0, 30.0], equal_nan=True)
    assert np.isnan(estimates["one"].kinematics.command).all()
    _, estimates = line.block({"one": arrivals([8], [0.004])}, {})
    assert estimates["one"].kinematics.temperature.tolist() == [30.0]


def test_dampers_of_one_message_are_answered_together_in_the_order_of_the_line():
    line = VehicleLine({name: DamperEstimator(deployed(MODEL, 60.0, 0.1)) for name in ("b", "a")})
    messages, _ = line.block(
        {"a": arrivals([0, 1, 2], [0.0, np.nan, 0.1]), "b": arrivals([0, 1, 3], [0.0, 0.1, 0.2])}, {}
    )
    found = {(m.names, rank) for m in messages for rank in m.rank.tolist()}
    assert found == {(("b", "a"), 0), (("b",), 1), (("a",), 2), (("b",), 3)}
    assert all(values.shape == (m.rank.size, len(m.names)) for m in messages for values in m.fields.values())


def test_a_block_without_displacement_gives_no_message():
    line = VehicleLine({"a": DamperEstimator(deployed(MODEL, 60.0, 0.1))})
    assert line.block({}, {"a": {"command": arrivals([0], [1.0])}}) == ([], {})
    assert line.block({"a": arrivals([1], [np.nan])}, {})[0] == []


@given(st.lists(st.sets(st.integers(0, 20)), min_size=1, max_size=4))
def test_grouping_keys_loses_and_invents_nothing(sets):
    keys = {str(i): np.array(sorted(keys_of_one), np.int64) for i, keys_of_one in enumerate(sets)}
    seen = {name: [] for name in keys}
    for shared, rows in group_equal_keys(keys):
        for name, row in rows.items():
            assert np.array_equal(keys[name][row], shared)
            seen[name] += shared.tolist()
    assert {name: sorted(shared) for name, shared in seen.items()} == {
        name: all_keys.tolist() for name, all_keys in keys.items()
    }
