"""The bound of the error: that of ten hours, from the largest errors of quarters of a second."""

import numpy as np
import pytest
from scipy.stats import genextreme

from damper_estimator.identification.error_bound import BLOCK, DRIVING, SIGMAS, force_stddev

BLOCKS = round(DRIVING / BLOCK)


@pytest.mark.parametrize("shape", [0.0, 0.15, 0.4])
def test_the_bound_is_that_of_the_distribution_of_the_errors(shape):
    law = genextreme(shape, loc=80.0, scale=30.0)
    bounds = [SIGMAS * force_stddev(law.rvs(400, random_state=seed)) for seed in range(200)]
    assert np.median(bounds) == pytest.approx(law.isf(1.0 / BLOCKS), rel=0.05)


@pytest.mark.parametrize("shape", [0.0, 0.15, 0.4])
def test_a_minute_or_two_of_errors_bound_most_hours(shape):
    """The largest of the same minutes, in contrast, is exceeded in most hours."""
    law, hour = genextreme(shape, loc=80.0, scale=30.0), round(3600.0 / BLOCK)
    random = np.random.default_rng(1)
    recorded = law.rvs((200, 360), random_state=random)
    largest = np.array([law.rvs(hour, random_state=random).max() for _ in recorded])
    bounds = np.array([SIGMAS * force_stddev(each) for each in recorded])
    assert np.mean(largest > bounds) < 0.5 and np.mean(largest > recorded.max(axis=1)) > 0.8
    assert np.median(bounds / recorded.max(axis=1)) < 2.0  # it is no idle bound


@pytest.mark.parametrize("count", [1, 2, 3, 5, 12])
def test_equal_or_few_errors_give_a_finite_bound_that_is_not_below_them(count):
    assert SIGMAS * force_stddev(np.full(count, 40.0)) == pytest.approx(40.0)
    errors = np.random.default_rng(count).uniform(10.0, 50.0, count)
    assert np.isfinite(force_stddev(errors)) and SIGMAS * force_stddev(errors) >= errors.max()
    assert force_stddev(np.zeros(count)) == 0.0


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("wild", [np.inf, np.nan])
def test_a_model_that_runs_away_is_bounded_by_nothing(wild):
    assert np.isnan(force_stddev(np.array([3.0, wild, 5.0] * 10)))


def test_the_bound_has_the_unit_of_the_force_and_no_order():
    errors = np.random.default_rng(2).gumbel(50.0, 20.0, 300).clip(0.0)
    bound = force_stddev(errors)
    assert force_stddev(errors[::-1]) == bound
    assert force_stddev(7.5 * errors) == pytest.approx(7.5 * bound)


def test_glitches_of_the_gauge_are_not_the_models_errors():
    errors = np.random.default_rng(3).gumbel(50.0, 20.0, 4000).clip(0.0)
    with_glitches = errors.copy()
    with_glitches[[100, 2000]] = 5e3
    assert force_stddev(with_glitches) < 1.5 * force_stddev(errors)
