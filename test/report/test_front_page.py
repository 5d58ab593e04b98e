"""The page of a Pareto front holds every point, the chosen one and what the groups want, and reaches for nothing."""

import json
import re

import numpy as np
import pytest

from damper_estimator.report.front_page import _log_axis, front_page
from damper_estimator.report.page import _plotly
from damper_estimator.report.wording import groups_in_words

GROUPS = ("LVLF", "LVHF", "HVHF")
OBJECTIVES = np.array([[0.1, 0.9, 0.8], [0.5, 0.5, 0.2], [0.9, 0.1, 0.7]])
REGIMES = {g: {"bouc_wen.alpha": {"mean": 100.0 * k, "stddev": 5.0}} for k, g in enumerate(GROUPS, 1)}


def page():
    return front_page("<b>mine</b>", GROUPS, OBJECTIVES, 1, REGIMES)


def figures():
    return json.loads(re.search(r'id="data">(.*?)</script>', page(), re.DOTALL)[1])["sections"][0]


def test_all_points_and_the_chosen_one_are_there():
    found = figures()
    assert list(found) == ["pair0", "pair1", "pair2"]
    for figure, (a, b) in zip(found.values(), [(0, 1), (0, 2), (1, 2)], strict=True):
        solutions, best, chosen = figure["data"]
        assert np.allclose([solutions["x"], solutions["y"]], OBJECTIVES[:, [a, b]].T)
        assert best["text"] == ["point 0", "point 2", "point 1"] and chosen["text"] == ["point 1"]


@pytest.mark.parametrize("span", [1.02, 1.3, 3.0, 40.0, 1e5])
def test_axes_have_ticks_at_round_numbers_whatever_they_span(span):
    axis = _log_axis("", np.array([0.37, 0.37 * span]))
    low, high = 10.0 ** np.array(axis["range"])
    assert low < 0.37 and high > 0.37 * span
    assert 3 <= len(axis["tickvals"]) <= 7 and low <= min(axis["tickvals"]) and max(axis["tickvals"]) <= high
    assert len(set(axis["ticktext"])) == len(axis["ticktext"])


def test_abbreviations_are_explained():
    assert "LVLF: low velocity and low frequency" in page()
    assert groups_in_words(("road", "HV")) == "HV: high velocity"


def test_the_headline_and_the_table_say_it_in_numbers():
    text = page()
    assert "Point 1 became the model" in text and "LVLF 0.5, LVHF 0.5, HVHF 0.2" in text
    assert "200 ± 5" in text


def test_names_are_escaped_and_nothing_comes_from_a_network():
    text = page().replace(_plotly(), "")
    assert "<b>mine</b>" not in text and "&lt;b&gt;mine" in text
    assert not re.search(r'(src|href)="(?!data:)', text)
