"""Standard errors and intervals hold what they promise, whatever the memory of the noise."""

import numpy as np
import pytest
from series import autoregressive

from damper_estimator.numerics import (
    block_draws,
    block_variance,
    directions,
    long_run_variance,
    score_covariance,
    spectrum_of,
    standard_errors,
)

RATE = 100.0
TRIALS = 300


@pytest.mark.parametrize("memory", [0.0, 0.5, 0.9])
def test_the_long_run_variance_is_that_of_the_closed_form(memory):
    series = autoregressive(np.random.default_rng(1), 20000, memory, (20,))
    exact = 1.0 / (1.0 - memory) ** 2
    # The taper over a second takes 7 % from a memory of a tenth of it.
    assert np.mean([long_run_variance(residual, RATE) for residual in series]) == pytest.approx(exact, rel=0.1)
    blocks = np.arange(20000) // 200
    assert np.mean([block_variance(residual, blocks) for residual in series]) == pytest.approx(exact, rel=0.12)


def test_fitted_parameters_take_degrees_of_freedom_from_blocks():
    random, blocks, hats = np.random.default_rng(3), np.arange(1200) // 100, np.zeros((1200, 3))
    hats[np.arange(1200), np.arange(1200) // 400] = 1.0
    found = []
    for _ in range(TRIALS):
        noise = random.standard_normal(1200)
        found.append(block_variance(noise - hats @ np.linalg.lstsq(hats, noise, rcond=None)[0], blocks, 3))
    assert np.mean(found) == pytest.approx(1.0, rel=0.08)


@pytest.mark.parametrize("memory", [0.0, 0.7, 0.9])
def test_standard_errors_are_the_scatter_of_the_estimates(memory):
    random = np.random.default_rng(2)
    time = np.arange(3000) / RATE
    columns = np.stack(
        [np.ones_like(time), np.sin(2.0 * np.pi * 0.4 * time), autoregressive(random, 3000, 0.95)], axis=1
    )
    parts = np.split(columns, [1000])
    inverse, misses = np.linalg.pinv(columns), []
    for noise in autoregressive(random, 3000, memory, (TRIALS,)):
        fitted = inverse @ noise
        errors = standard_errors(parts, np.split(noise - columns @ fitted, [1000]), [RATE, RATE])
        misses.append(fitted / errors)
    misses = np.abs(misses)
    # 68 and 95 % of normal misses; with 300 trials these shares scatter by 2.7 and 1.3 %.
    assert np.mean(misses < 1.0, axis=0) == pytest.approx(0.68, abs=0.09)
    assert np.mean(misses < 1.96, axis=0) == pytest.approx(0.95, abs=0.05)


def test_white_noise_has_the_textbook_covariance():
    random = np.random.default_rng(4)
    columns = random.standard_normal((40000, 3)) @ [[1.0, 0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 10.0]]
    noise = 2.0 * random.standard_normal(40000)
    expected = 2.0 * np.sqrt(np.diag(np.linalg.inv(columns.T @ columns)))
    np.testing.assert_allclose(standard_errors([columns], [noise], [RATE]), expected, rtol=0.05)


def test_what_the_data_do_not_tell_has_no_standard_error():
    random = np.random.default_rng(5)
    one, other = random.standard_normal((2, 500))
    columns = np.stack([one, other, one, np.zeros(500)], axis=1)
    errors = standard_errors([columns], [random.standard_normal(500)], [RATE])
    assert np.isnan(errors).tolist() == [True, False, True, True]


def test_fewer_rows_than_parameters_determine_nothing():
    found = directions(np.ones((1, 2)), lambda weights: (np.eye(weights.shape[1]), 10.0))
    assert found.undetermined.all()
    assert directions(np.zeros((5, 0)), lambda weights: (weights, 1.0)).spread.size == 0


def test_recordings_of_one_sample_count_nothing():
    scores = np.ones((1, 2))
    total, effective = score_covariance([np.ones(1)], [scores], [RATE])
    assert not total.any() and effective == 0.0


def test_the_bootstraps_interval_covers_the_mean():
    random, covered = np.random.default_rng(6), 0
    draws = block_draws(60, 400)
    assert (draws.sum(axis=1) == 60).all() and draws.mean() == 1.0
    for series in autoregressive(random, 6000, 0.9, (TRIALS,)):
        sums = series.reshape(60, 100).sum(axis=1)
        low, high = np.percentile(draws @ sums, [5.0, 95.0])
        covered += low <= 0.0 <= high
    # 90 % promised; the scatter of 300 trials is 1.7 %.
    assert covered / TRIALS == pytest.approx(0.9, abs=0.06)


def test_the_same_draws_come_back():
    assert np.array_equal(block_draws(9), block_draws(9))
    assert not np.array_equal(block_draws(9), block_draws(9, seed=1))


@pytest.mark.parametrize("memory", [0.0, 0.9])
def test_a_spectrum_carries_the_covariance_to_another_recording(memory):
    """The spectrum of two recordings, at another rate and for other scores."""
    random = np.random.default_rng(6)
    slow = [autoregressive(random, size, memory) for size in (30000, 12000)]
    spectrum = spectrum_of(slow, [RATE, RATE])
    scores = np.stack([np.sin(2.0 * np.pi * f * np.arange(8000) / RATE) for f in (0.0, 3.0, 30.0)], axis=1)[:, 1:]
    expected, _ = score_covariance([autoregressive(random, 8000, memory)], [scores], [RATE])
    unit = expected / np.mean(np.square(np.concatenate(slow)))
    assert np.diag(spectrum.score_covariance(scores, RATE)) == pytest.approx(np.diag(unit), rel=0.35)
    assert np.mean(spectrum.density) == pytest.approx(1.0, rel=0.1)
