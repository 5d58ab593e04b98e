"""The page of a Pareto front holds every point, the chosen one and what the groups want, and reaches for nothing."""

import json
import re

import numpy as np

from damper_estimator.report.front_page import front_page
from damper_estimator.report.page import _plotly

GROUPS = ("LVLF", "LVHF", "HVHF")
OBJECTIVES = np.array([[0.1, 0.9, 0.8], [0.5, 0.5, 0.2], [0.9, 0.1, 0.7]])
REGIMES = {g: {"bouc_wen.alpha": {"mean": 100.0 * k, "stddev": 5.0}} for k, g in enumerate(GROUPS, 1)}


def page():
    return front_page("<b>mine</b>", GROUPS, OBJECTIVES, 1, REGIMES)


def test_all_points_and_the_chosen_one_are_there():
    data = json.loads(re.search(r'id="data">(.*?)</script>', page(), re.DOTALL)[1])[0]
    assert np.array_equal(np.array(data["objectives"]).T, OBJECTIVES)
    assert data["picked"] == 1 and data["corners"] == [0, 2, 1]
    assert data["pairs"] == [[0, 1], [0, 2], [1, 2]]


def test_the_headline_and_the_table_say_it_in_numbers():
    text = page()
    assert "Point 1 became the model" in text and "LVLF 0.5, LVHF 0.5, HVHF 0.2" in text
    assert "200 ± 5" in text


def test_names_are_escaped_and_nothing_comes_from_a_network():
    text = page().replace(_plotly(), "")
    assert "<b>mine</b>" not in text and "&lt;b&gt;mine" in text
    assert not re.search(r'(src|href)="(?!data:)', text)
