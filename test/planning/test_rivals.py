"""What is compared: explanations that can be simulated, and others that are nearly as probable as a tie."""

from dataclasses import replace

import pytest

from damper_estimator.diagnosis import explanations
from damper_estimator.planning.plan import _near
from damper_estimator.planning.rivals import simulable

TIED = ("gas_spring", "spring_rate_error")


@pytest.fixture(scope="module")
def found(fitted, old):
    return explanations(fitted, old.measurements["damper"], TIED)


def useless(found, phenomenon):
    """The explanations, those of one phenomenon with ten times the residual."""
    return replace(found, fitted=tuple(
        replace(one, residual=10.0 * one.residual) if one.phenomenon == phenomenon else one for one in found.fitted
    ))  # fmt: skip


def test_explanations_that_explain_are_kept(found):
    assert simulable(found) == found


def test_the_prediction_is_said_to_mean_nothing_where_only_one_fit_is_left(found):
    left = simulable(useless(found, "spring_rate_error"))
    assert len(left.fitted) == len(found.fitted)
    assert "mean nothing" in left.untestable["spring_rate_error"]


def test_one_lost_explanation_of_three_is_named(found):
    other = replace(found.fitted[0], phenomenon="end_stop", effect="end_stop")
    left = simulable(useless(replace(found, fitted=(*found.fitted, other)), "spring_rate_error"))
    assert {one.phenomenon for one in left.fitted} == {"gas_spring", "end_stop"}
    assert "does not carry over" in left.untestable["spring_rate_error"]


def test_phenomena_that_are_nearly_tied_count_as_rivals():
    probable = {"a": 0.5, "b": 0.3, "c": 0.02, "d": 0.04, "e": 0.08, "f": 0.06}
    assert _near(("a", "b"), probable) == ["e", "f"]
    assert not _near((), probable)


def test_a_constant_that_the_free_zero_hides_has_a_value_all_the_same(fitted, old):
    """Nothing holds it where the zero is free; simulated with a value at its bound it would obey no limit of a rig."""
    (measurement,) = old.measurements["damper"]
    force = measurement.force + 40.0
    shifted = [replace(measurement, force=force)]
    found = explanations(fitted, shifted, ("force_offset", "gas_spring"))
    offset = next(one for one in found.fitted if one.phenomenon == "force_offset")
    assert abs(offset.model.effects[-1].parameters["offset"]) < 200.0
