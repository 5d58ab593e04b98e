"""Error measures: hand computations and laws."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from damper_estimator.validation import measures

EXACT = 1e-12
FORCES = arrays(float, 30, elements=st.floats(-1e3, 1e3).map(lambda v: round(v, 3)))
VELOCITY, DT = np.sin(np.arange(1.0, 31.0)), np.linspace(0.001, 0.003, 30)


def test_measures_equal_a_hand_computation():
    m = measures(
        np.array([1.0, -1.0, 3.0]), np.array([2.0, -1.0, 1.0]), np.array([1.0, -1.0, 2.0]), np.array([0.1, 0.2, 0.1])
    )
    assert m.samples == 3
    assert m.rmse_n == pytest.approx(np.sqrt(5 / 3), EXACT)
    assert m.force_rms_n == pytest.approx(np.sqrt(11 / 3), EXACT)
    assert m.nrmse == pytest.approx(np.sqrt(5 / 11), EXACT)
    assert m.esr == pytest.approx((14 / 9) / (8 / 3), EXACT)
    assert m.fit_percent == pytest.approx(100 * (1 - np.sqrt(5 / 8)), EXACT)
    assert m.correlation == pytest.approx(np.corrcoef([1, -1, 3], [2, -1, 1])[0, 1], EXACT)
    assert (m.peak_error_n, m.bias_n) == (2.0, pytest.approx(-1 / 3, EXACT))
    assert m.energy_error == pytest.approx((0.1 - 0.4) / (0.1 + 0.2 + 0.6), EXACT)


@given(FORCES)
def test_equal_signals_have_no_error(force):
    m = measures(force, force, VELOCITY, DT)
    assert (m.rmse_n, m.peak_error_n, m.bias_n) == (0.0, 0.0, 0.0)
    if np.ptp(force) > 1e-2:
        assert (m.nrmse, m.esr, m.fit_percent, m.energy_error) == (0.0, 0.0, 100.0, 0.0)
        assert m.correlation == pytest.approx(1.0, abs=EXACT)


@given(FORCES, FORCES, st.floats(0.1, 10.0))
def test_scaling_both_forces_scales_newtons_and_leaves_ratios(measured, modelled, factor):
    one, other = (
        measures(measured, modelled, VELOCITY, DT),
        measures(factor * measured, factor * modelled, VELOCITY, DT),
    )
    for name in ("rmse_n", "force_rms_n", "peak_error_n", "bias_n"):
        assert getattr(other, name) == pytest.approx(factor * getattr(one, name), rel=1e-9, abs=1e-9)
    if np.ptp(measured) > 1.0:
        for name in ("nrmse", "esr", "correlation", "energy_error", "fit_percent"):
            assert getattr(other, name) == pytest.approx(getattr(one, name), rel=1e-9, abs=1e-6, nan_ok=True)


@given(FORCES, FORCES, st.floats(-500.0, 500.0))
def test_an_offset_of_the_model_changes_bias_and_neither_esr_nor_correlation(measured, modelled, offset):
    one, other = measures(measured, modelled, VELOCITY, DT), measures(measured, modelled + offset, VELOCITY, DT)
    assert other.bias_n == pytest.approx(one.bias_n + offset, abs=1e-8)
    if np.ptp(measured) > 1.0 and np.ptp(modelled) > 1.0:
        assert other.esr == pytest.approx(one.esr, rel=1e-6, abs=1e-9)
        assert other.correlation == pytest.approx(one.correlation, abs=1e-6)


def test_a_model_that_dissipates_too_much_has_a_positive_energy_error():
    force = 1000.0 * VELOCITY
    assert measures(force, 1.2 * force, VELOCITY, DT).energy_error == pytest.approx(0.2, EXACT)
    assert measures(force, 0.7 * force, VELOCITY, DT).energy_error == pytest.approx(-0.3, EXACT)


def test_uneven_steps_weigh_the_energy():
    force, model = np.array([1.0, 1.0]), np.array([2.0, 1.0])
    assert measures(force, model, np.ones(2), np.array([0.3, 0.1])).energy_error == pytest.approx(0.75, EXACT)


def test_quotients_without_a_denominator_are_not_numbers():
    m = measures(np.zeros(3), np.ones(3), np.zeros(3), np.ones(3))
    assert np.isnan([m.nrmse, m.esr, m.correlation, m.energy_error]).all() and m.rmse_n == 1.0
