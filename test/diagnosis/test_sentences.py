"""The verdict in one sentence."""

from dataclasses import replace

from damper_estimator.diagnosis import AtlasRow
from damper_estimator.diagnosis.sentences import unexplained_sentence


def test_an_unexplained_error_is_said_to_depend_on_what_a_form_free_test_shows():
    row = AtlasRow("position", ("position_dependence",), "velocity and position", 0.6, 0.5, 0.7)
    text = unexplained_sentence([row], None, 100.0, 100.0, 10.0, 60.0)
    assert "60 %" in text and "velocity and position" in text and "position dependence" in text
    assert "reaches 60 N" in text and "reaches" not in unexplained_sentence([row], None, 100.0, 100.0, 10.0, 99.5)
    unsure = replace(row, low=0.1)
    assert "nothing that was measured" in unexplained_sentence([unsure], None, 100.0, 100.0, 10.0, float("nan"))


def test_zeros_that_differ_are_set_apart_from_what_is_unexplained():
    text = unexplained_sentence([], None, 65.0, 15.0, 5.0, 36.0)
    assert "15 N that is left of 65 N without each recording's zero and drift, 3 times the noise" in text
    assert "reaches" not in text  # what is left is less already
    assert "zero" not in unexplained_sentence([], None, 65.0, 64.0, 5.0, 36.0)
