"""The numbers that a diagnosis decides by."""

import pytest

from damper_estimator.diagnosis.thresholds import documented, limits, using


def test_every_threshold_says_what_it_decides_and_why():
    for row in documented():
        assert row["unit"] and row["decides"] and row["reason"]


def test_others_hold_within_a_context_and_no_longer():
    usual = limits().gain
    with using(gain=2.0 * usual) as changed:
        assert limits() is changed and limits().gain == 2.0 * usual
    assert limits().gain == usual


def test_a_name_that_is_none_is_refused():
    with pytest.raises(TypeError), using(gane=1.0):
        pass
