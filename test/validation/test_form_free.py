"""The regression without a form."""

import numpy as np

from damper_estimator.validation.form_free import _solved


def test_a_column_that_is_not_driven_has_no_weight():
    """What a filter leaves of a column that was driven before the first judged sample."""
    rng = np.random.default_rng(2)
    rows = rng.standard_normal((500, 3)) * [1.0, 1e-290, 1e-3]
    force = rows @ [50.0, 0.0, 2e4] + rng.standard_normal(500)
    weights = _solved(rows, force, np.full(3, -np.inf))
    np.testing.assert_allclose(weights[[0, 2]], [50.0, 2e4], rtol=0.02)
    assert abs(weights[1]) < 1.0


def test_columns_that_are_all_zero_have_no_weight():
    assert not _solved(np.zeros((50, 2)), np.ones(50), np.full(2, -np.inf)).any()
