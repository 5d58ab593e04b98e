"""The curves of what a model lacks: what is drawn of them, and what is said instead."""

from dataclasses import replace

import numpy as np
import pytest

from damper_estimator.diagnosis import AtlasCurve, Template
from damper_estimator.report import (
    curves_figure,
    diagnosis_page,
    diagnosis_section,
    improvement_page,
    improvement_section,
    plotly_figure,
)
from damper_estimator.report.curve_figures import curve_figure, curve_title, left_out, template_words

AT = (-0.5, 0.0, 0.5)
MASS = AtlasCurve(
    "acceleration", AT, (2.1, 1.9, 2.0), (1.9, 1.7, 1.8), (2.3, 2.1, 2.2), 0.9, True,
    (Template("mass", (2.0, 2.0, 2.0), 2.0, 0.89), Template("shift", (1.0, 3.0, 1.0), -0.0012, 0.6)),
)  # fmt: skip
SPRING = AtlasCurve(
    "displacement", (-0.02, 0.0, 0.02), (-40.0, 0.0, float("nan")), (-45.0, -5.0, float("nan")),
    (-35.0, 5.0, float("nan")), 0.06, True,
)  # fmt: skip
NOTHING = AtlasCurve("velocity", AT, (1.0, 0.0, -1.0), (-3.0, -3.0, -3.0), (3.0, 3.0, 3.0), 0.2, False)


def test_a_curve_is_drawn_over_its_band_in_the_units_of_its_axes():
    drawn = curve_figure(SPRING, "A")
    low, high, found = drawn["data"]
    assert found["x"] == low["x"] == [-20.0, 0.0] and found["y"] == [-40.0, 0.0]
    assert (low["y"], high["y"]) == ([-45.0, -5.0], [-35.0, 5.0]) and high["fill"] == "tonexty"
    titles = [drawn["layout"][f"{side}axis"]["title"]["text"] for side in "xy"]
    assert titles == ["displacement in mm", "change of the force in N"]
    lowest, highest = drawn["layout"]["yaxis"]["range"]
    assert lowest < -45.0 and highest > 5.0


@pytest.mark.parametrize(
    "name, text",
    [
        ("velocity", "change of the force in N"),
        ("position", "change in % of the force"),
        ("temperature", "change in N/K"),
        ("command", "change in N/V"),
        ("acceleration", "force per acceleration in kg"),
        ("history", "difference of the force in N"),
        ("memory", "change of the force in N"),
    ],
)
def test_every_curve_names_its_unit(name, text):
    assert curve_figure(replace(NOTHING, name=name), "V")["layout"]["yaxis"]["title"]["text"] == text


def test_a_curve_of_memory_is_drawn_over_its_own_variable_and_says_beside_what_it_counts():
    way = replace(SPRING, name="memory", at=(0.0, 0.001, 0.01))
    drawn = curve_figure(way, "A")
    assert drawn["layout"]["xaxis"]["title"]["text"] == "travel since the last reversal in mm"
    assert drawn["data"][-1]["x"] == [0.0, 1.0]
    assert curve_figure(replace(MASS, name="history"), "A")["layout"]["xaxis"]["title"]["text"] == "velocity in m/s"
    assert curve_title(way).endswith("explains 6 % beyond the others") and curve_title(SPRING).endswith("explains 6 %")
    assert left_out([replace(NOTHING, name="memory")]).endswith("travel since the last reversal.")


def test_templates_are_dashed_named_in_words_and_the_best_comes_first():
    lines = [trace for trace in curve_figure(MASS, "A")["data"] if "dash" in trace["line"]]
    assert [line["name"] for line in lines] == ["a mass of 2 kg: 89 %", "a force that is 1.2 ms early: 60 %"]
    assert len({line["line"]["color"] for line in lines}) == len({line["line"]["dash"] for line in lines}) == 2
    assert "in series" in template_words(Template("series", (), float("nan"), 0.1))
    assert "opens at 0.3 m/s" in template_words(Template("valve", (), 0.3, 0.1))


def test_a_wide_band_does_not_flatten_the_curve():
    wide = replace(MASS, low=(-500.0, 1.7, 1.8), high=(500.0, 2.1, 2.2))
    lowest, highest = curve_figure(wide, "A")["layout"]["yaxis"]["range"]
    assert -2.0 < lowest and highest < 6.0


def test_only_curves_that_say_something_are_drawn_and_a_sentence_names_the_others():
    together = plotly_figure(curves_figure([NOTHING, SPRING, MASS], "A"))
    titles = [words.text for words in together.layout.annotations]
    assert len(titles) == 2 and "90 %" in titles[0] and "6 %" in titles[1]
    domains = [together.layout.yaxis.domain, together.layout.yaxis2.domain]
    assert 1.0 > domains[0][1] > domains[0][0] > domains[1][1] > domains[1][0] > 0.0
    assert left_out([NOTHING, SPRING, MASS]).endswith("a change of the curve over velocity.")
    assert left_out([SPRING, MASS]) == ""
    assert not curves_figure([NOTHING], "A")["data"]


def test_the_page_shows_the_curves_next_to_the_evidence(found):
    section = diagnosis_section("left", replace(found, curves=(NOTHING, SPRING, MASS)))
    assert {"curve_acceleration", "curve_displacement"} <= set(section.figures)
    assert "curve_velocity" not in section.figures
    page = diagnosis_page([section], "title")
    assert "curve by curve" in page and 'data-name="curve_acceleration"' in page and "next to nothing" in page
    assert "curve by curve" not in diagnosis_page([diagnosis_section("left", replace(found, curves=()))], "title")


def test_the_page_of_improve_shows_what_is_left_and_what_was_missing_at_first(improved):
    final, first = (replace(improved.final, curves=(SPRING, NOTHING)), replace(improved.first, curves=(MASS,)))
    section = improvement_section("left", replace(improved, final=final, first=first))
    assert {"curve_displacement", "first_curve_acceleration"} <= set(section.figures)
    assert not {"curve_acceleration", "curve_velocity", "first_curve_displacement"} & set(section.figures)
    page = improvement_page([section], "title")
    left, _, before = page.partition("the improved model lacks")[2].partition("the model as given lacked")
    assert 'data-name="curve_displacement"' in left and "next to nothing" in left
    assert 'data-name="first_curve_acceleration"' in before


def test_the_page_of_improve_shows_the_curves_once_where_nothing_was_added(improved):
    final = replace(improved.final, curves=(SPRING,))
    section = improvement_section("left", replace(improved, final=final, first=final))
    assert "curve_displacement" in section.figures and not any(name.startswith("first") for name in section.figures)
    assert "the model as given lacked" not in improvement_page([section], "title")


def test_the_record_of_improve_has_the_curves_of_what_is_left(improved):
    final = replace(improved.final, curves=(SPRING,))
    assert replace(improved, final=final).record()["atlas_curves"] == [SPRING.record()]


def test_friction_shows_in_the_curve_over_velocity(found):
    curve = next(one for one in found.curves if one.name == "velocity")
    assert curve.is_notable and curve.explains > 0.5
    assert 40.0 < np.interp(0.1, curve.at, curve.value) < 80.0
