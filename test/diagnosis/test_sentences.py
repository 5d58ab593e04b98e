"""The verdict in one sentence."""

from dataclasses import replace

import numpy as np
import pytest

from damper_estimator.diagnosis import AtlasRow
from damper_estimator.diagnosis.misfit import UsualError
from damper_estimator.diagnosis.sentences import sentence_of, unexplained_sentence


def test_an_unexplained_error_is_said_to_depend_on_what_a_form_free_test_shows():
    row = AtlasRow("position", ("position_dependence",), "velocity and position", 0.6, 0.5, 0.7)
    text = unexplained_sentence([row], None, 100.0, 100.0, 10.0, 60.0)
    assert "60 %" in text and "velocity and position" in text and "position dependence" in text
    assert "reaches 60 N" in text and "reaches" not in unexplained_sentence([row], None, 100.0, 100.0, 10.0, 99.5)
    unsure = replace(row, low=0.1)
    assert "no dependence on what was measured" in unexplained_sentence(
        [unsure], None, 100.0, 100.0, 10.0, float("nan")
    )


def test_zeros_that_differ_are_set_apart_from_what_is_unexplained():
    text = unexplained_sentence([], None, 65.0, 15.0, 5.0, 36.0)
    assert "15 N that is left of 65 N without each recording's zero and drift, 3 times the noise" in text
    assert "reaches" not in text  # what is left is less already
    assert "zero" not in unexplained_sentence([], None, 65.0, 64.0, 5.0, 36.0)


@pytest.mark.parametrize(
    ("share", "share_now", "words"),
    [
        (0.04, 0.02, "is smaller than when the model was identified (12 N, 4 %)"),
        (0.04, 0.041, "is as large as when"),
        (0.04, 0.05, "larger, but not by more than errors usually differ"),
        (0.02, 0.06, "larger, by what the model has always got wrong"),
        (
            0.008,
            0.028,
            "is larger, though still below 3 % of the force, than when the model was identified (12 N, 0.8 %)",
        ),
        (np.nan, 0.06, "is what the model has always got wrong"),
    ],
)
def test_a_usual_error_is_compared_as_a_share_of_the_force(share, share_now, words):
    """In newtons it may be larger where the force is."""
    then = UsualError(12.0, share, share_now)
    text = sentence_of("nothing_missing", [], None, (45.0, 45.0), 45.0, 5.0, then)
    assert words in text and "45 N" in text and "nan" not in text


def test_an_unknown_noise_floor_is_not_stated():
    for floor in (np.nan, 2.0):
        text = sentence_of("nothing_missing", [], None, (3.0, 3.0), 3.0, floor)
        assert ("noise floor" in text) == np.isfinite(floor) and "nan" not in text
        assert "nan" not in unexplained_sentence([], None, 65.0, 64.0, floor, 36.0)
