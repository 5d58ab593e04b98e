"""What is fitted to, what is judged on, and how much each sample counts."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from damper_estimator.diagnosis.diagnosis_data import (
    BLOCK,
    data_of,
    ends_without_noise,
    force_rows,
    ranges_of,
    targets,
    unweighted,
    weights,
)
from damper_estimator.diagnosis.recorded_force import recorded_force_model, rows_with_force
from damper_estimator.effects.discovery import find_effect
from damper_estimator.errors import InputError
from damper_estimator.identification.rows import split
from damper_estimator.model import parse_model
from damper_estimator.model.element import new_element
from damper_estimator.signals.layout import ROWS


def test_given_recordings_are_judged_on_as_a_whole(user_model, base, soft):
    data = data_of(user_model, [base], list(soft))
    assert [rows.measurement.recording for rows in data.unseen] == [m.recording for m in soft]
    assert len(data.fit[0].measurement.kinematics) == len(base.kinematics)


def test_blocks_last_a_second_and_belong_to_one_recording(user_model, base):
    data = data_of(user_model, [base], [base, base])
    first, second = split(data.unseen, data.blocks)
    assert second.min() == first.max() + 1
    counts = np.bincount(first)[1:-1]
    assert counts[counts > 0] == pytest.approx(BLOCK * data.unseen[0].rate, rel=0.2)


def test_weights_are_one_on_average_and_fall_where_the_curve_is_steep(user_model, base):
    weight = weights(user_model, base)
    assert weight[base.judged].mean() == pytest.approx(1.0)
    assert (weight > 0.0).all()
    flat = weights(user_model.with_vector(np.array([1e-9 * slot.value for slot in user_model.slots])), base)
    assert np.ptp(flat) < 0.1 * np.ptp(weight)


def test_the_zero_and_a_straight_drift_are_left_out_unless_they_are_asked_for(user_model, base):
    time = base.kinematics.time - base.kinematics.time[0]
    shifted = replace(base, force=base.force + 30.0 + 0.4 * time)
    plain, drifting = (data_of(user_model, [measurement], [measurement]) for measurement in (base, shifted))
    moved = weights(user_model, shifted) / weights(user_model, base)
    assert np.ptp(moved) < 0.1  # a little more force is a little more of what no form gets right
    residuals = [force_rows(user_model, either.unseen) - targets(either.unseen) for either in (plain, drifting)]
    assert np.sqrt(np.mean((residuals[1] - residuals[0]) ** 2)) < 0.05 * np.sqrt(np.mean(residuals[0] ** 2)) + 0.5
    whole = drifting.with_zero
    left = force_rows(user_model, whole.unseen) - targets(whole.unseen)
    assert unweighted(whole.unseen, left) > unweighted(drifting.unseen, residuals[1]) + 10.0
    assert whole.ranges.with_mean and not drifting.ranges.with_mean


def test_an_error_in_newton_is_told_without_the_weights(user_model, base):
    rows = data_of(user_model, [base], [base]).unseen
    root = np.sqrt(np.concatenate([part.weight[part.picks] for part in rows]))
    assert unweighted(rows, 7.0 * root) == pytest.approx(7.0)


def test_a_frozen_model_gives_the_force_that_it_recorded(user_model, base):
    rows = data_of(user_model, [base], [base]).fit
    frozen = rows_with_force(user_model, rows)
    np.testing.assert_array_equal(force_rows(recorded_force_model(user_model), frozen), force_rows(user_model, rows))


def test_the_oil_of_a_frozen_model_carries_what_acts_through_it(user_model, base):
    frozen = recorded_force_model(user_model)
    oil, mount = (new_element(find_effect(name), frozen.effects) for name in ("oil_spring", "rubber_mount"))
    assert [e.effect.beside_oil for e in frozen.with_missing(oil).effects] == [False, True]
    assert len(frozen.with_missing(mount).effects) == 1
    (rows,) = rows_with_force(user_model, data_of(user_model, [base], [base]).fit[:1])
    block = rows.measurement.kinematics.block
    gas = user_model.contributions(block[:ROWS])["gas_spring"]
    np.testing.assert_array_equal(block[ROWS + 1], gas)


@given(constant=st.floats(-3000.0, 3000.0), gas=st.floats(0.0, 3000.0))
def test_the_force_at_rest_is_that_of_the_model_with_and_without_what_acts_beside_the_oil(base, constant, gas):
    curve = {"velocity": [-0.5, 0.0, 0.5], "force": [constant - 900.0, constant, constant + 1200.0]}
    gas_spring = {"static_force": gas, "volume": 5e-3}
    effects = [{"viscous_curve": curve}, {"gas_spring": gas_spring}, {"dahl": {}}, {"force_lag": {}}]
    ranges = ranges_of([base], parse_model({"name": "user", "source": "test", "effects": effects}, "test"))
    assert ranges.oil_at_rest == pytest.approx(constant, abs=1e-6)
    assert ranges.at_rest == pytest.approx(constant - gas, abs=0.01 * gas + 1e-6)
    assert (ranges_of([base]).at_rest, ranges_of([base]).oil_at_rest) == (0.0, 0.0)


def test_a_recording_without_force_is_refused(user_model, base):
    with pytest.raises(InputError, match="no measured force"):
        data_of(user_model, [replace(base, force=None)], [])


@pytest.mark.parametrize("seed", range(5))
def test_the_noise_of_an_ammeter_is_no_change_of_the_current(seed):
    rng = np.random.default_rng(seed)
    noise = 0.005 * rng.standard_normal(20_000)
    low, high = ends_without_noise(0.3 + noise)
    assert high - low < 0.01 and low == pytest.approx(0.3, abs=0.01)
    steps = np.repeat(rng.uniform(0.0, 1.5, 40), 500)
    assert ends_without_noise(steps + noise) == pytest.approx((steps.min(), steps.max()), abs=0.01)
    slow = 1.0 + np.sin(np.linspace(0.0, 100.0, 20_000))
    assert ends_without_noise(slow) == pytest.approx((0.0, 2.0), abs=1e-3)
    assert ends_without_noise(steps) == (steps.min(), steps.max())
    assert ends_without_noise(np.full(4, np.nan)) is None
