"""Steps of finite differences stay between the bounds and are known exactly."""

import numpy as np
import pytest

from damper_estimator.numerics import ROUGH, SMOOTH, stepped


def test_the_slope_of_a_straight_line_is_exact():
    values = np.array([0.3, 7.7])
    changed, step = stepped(values, 1, 10.0, -100.0, 100.0, ROUGH)
    assert step == changed[1] - values[1] == pytest.approx(0.02)
    assert values.tolist() == [0.3, 7.7] and changed[0] == 0.3


@pytest.mark.parametrize(
    ("value", "lower", "upper", "expected"),
    [
        (0.0, -1.0, 1.0, 0.1),
        (1.0, -1.0, 1.0, -0.1),
        (0.95, -1.0, 1.0, -0.1),
        (1.0, 0.99, 1.0, -0.01),
        (0.992, 0.99, 1.0, 0.008),
        (0.998, 0.99, 1.0, -0.008),
    ],
)
def test_a_step_goes_up_unless_the_range_below_is_larger(value, lower, upper, expected):
    changed, step = stepped(np.array([value]), 0, 1.0, lower, upper, 0.1)
    assert step == pytest.approx(expected) and lower <= changed[0] <= upper + 1e-15


def test_the_step_for_smooth_forces_errs_by_its_square_root_of_precision():
    values = np.array([1.3])
    changed, step = stepped(values, 0, 1.3, -10.0, 10.0, SMOOTH)
    assert (np.exp(changed[0]) - np.exp(values[0])) / step == pytest.approx(np.exp(1.3), rel=1e-5)
