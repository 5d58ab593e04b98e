"""Ranks with ties, and order statistics from counts alone."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import rankdata, spearmanr

from damper_estimator.numerics import order_statistics, rank_correlation


@settings(deadline=None)
@given(
    pairs=st.lists(
        st.tuples(st.integers(-3, 3) | st.floats(-1e6, 1e6), st.integers(0, 4) | st.floats(-1e6, 1e6)), min_size=3
    ).filter(lambda pairs: all(len({pair[i] for pair in pairs}) > 1 for i in (0, 1)))
)
def test_rank_correlation_is_that_of_scipy_also_among_equal_values(pairs):
    a, b = np.array(pairs, float).T
    assert rank_correlation(a, b) == pytest.approx(spearmanr(a, b).statistic, abs=1e-12)


def test_a_monotonic_curve_correlates_fully():
    values = np.random.default_rng(1).standard_normal(50)
    assert rank_correlation(values, np.exp(3.0 * values)) == pytest.approx(1.0)
    assert rank_correlation(values, -(values**3)) == pytest.approx(-1.0)


def test_equal_values_share_their_rank():
    """A command that steps once, and an error that grows with time all the while before the step."""
    error = np.arange(30.0)
    command = np.ones(30)
    command[[3, 4]] = 1.2
    ranks = np.corrcoef(rankdata(error), rankdata(command))[0, 1]
    assert rank_correlation(error, command) == pytest.approx(ranks)
    assert rank_correlation(error, command) < 0.0


def test_order_does_not_matter():
    random = np.random.default_rng(2)
    a, b = random.integers(0, 4, 60).astype(float), random.integers(0, 4, 60).astype(float)
    shuffled = random.permutation(60)
    assert rank_correlation(a, b) == pytest.approx(rank_correlation(a[shuffled], b[shuffled]))


def test_a_constant_correlates_with_nothing():
    assert np.isnan(rank_correlation(np.arange(5.0), np.ones(5)))
    assert np.isnan(rank_correlation(np.ones(1), np.ones(1)))


def test_order_statistics_are_exact():
    random = np.random.default_rng(3)
    values = np.concatenate([random.standard_normal(500), [0.0, 0.0, 1e-300, -1e300, 5.0, 5.0]])
    ordered = np.sort(values)
    found = order_statistics(
        lambda edges: np.searchsorted(ordered, edges), ordered[0], ordered[-1], range(ordered.size)
    )
    assert found == ordered.tolist()
