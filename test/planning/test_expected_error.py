"""What is expected of a new motion: right on average where it was measured, and loud where the motion is."""

import numpy as np
import pytest

from damper_estimator.numerics import spectrum_of
from damper_estimator.planning.expected_error import Errors, _over_force

RATE = 200.0


@pytest.fixture
def rng():
    return np.random.default_rng(4)


@pytest.mark.parametrize(("constant", "share"), [(25.0, 0.0), (0.0, 0.02), (9.0, 0.01)])
def test_the_expected_error_is_right_on_average_over_the_recording(rng, constant, share):
    """However the error depends on the force: squares scatter by more than their mean."""
    force = 100.0 * rng.standard_normal(6000)
    squared = (constant + share * force**2) * rng.standard_normal(6000) ** 2
    found = _over_force(force, squared)
    assert found[0] + found[1] * np.mean(force**2) == pytest.approx(squared.mean(), rel=0.05)


def test_an_error_that_grows_with_the_force_is_found_to_grow(rng):
    force = 100.0 * rng.standard_normal(20000)
    constant, share = _over_force(force, 0.02 * force**2 * rng.standard_normal(20000) ** 2)
    assert share == pytest.approx(0.02, rel=0.15) and constant < 0.1 * share * np.mean(force**2)


def test_half_of_the_error_lies_where_a_step_drives_the_force(rng):
    errors = Errors(1.0, 1.0, 0.0, 1.0, 1e4, spectrum_of([rng.standard_normal(4000)], [RATE]))
    time = np.arange(1200) / RATE
    found = errors.spectrum_on(100.0 * np.sin(2.0 * np.pi * 10.0 * time), RATE)
    near = np.abs(found.frequency - 10.0) < 2.0
    share = found.density[near].sum() / found.density.sum()
    assert share == pytest.approx(0.5, abs=0.08)
    still = errors.spectrum_on(np.full(1200, 30.0), RATE)
    assert still is errors.spectrum
