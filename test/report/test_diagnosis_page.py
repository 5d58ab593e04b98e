"""The pages of a diagnosis and an improvement: what they say, what they draw, and that they need nothing else."""

import base64
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from damper_estimator.diagnosis import EvaluationSummary, Moved, Structure
from damper_estimator.identification import FittedParameter
from damper_estimator.report import diagnosis_page, diagnosis_section, improvement_page, improvement_section
from damper_estimator.report.diagnosis_wording import parameter_rows, with_error
from damper_estimator.report.page import _plotly
from damper_estimator.report.plots import FOUND, shared_arrays
from damper_estimator.report.verdict_figures import atlas_figure, ranked, ranking_figure, waterfall_figure
from damper_estimator.validation import DataFinding

LARGEST = 5_000_000  # characters of the page of one damper, the library included


def page_of(found, damper="front_left"):
    return diagnosis_page([diagnosis_section(damper, found)], "title")


def words(page):
    """What can be read without scripts."""
    return re.sub(r"<(script|style).*?</\1>", "", page, flags=re.S)


def data_of(page):
    return json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.S).group(1))


def figure(page, name, section=0):
    """A figure with its arrays put back."""
    data = data_of(page)

    def back(value):
        if isinstance(value, dict) and "array" in value and isinstance(value["array"], int):
            packed = data["arrays"][value["array"]]
            return np.frombuffer(base64.b64decode(packed["bdata"]), dtype=f"<{packed['dtype']}")
        if isinstance(value, dict):
            return {key: back(item) for key, item in value.items()}
        return [back(item) for item in value] if isinstance(value, list) else value

    return back(data["sections"][section][name])


def test_the_verdict_and_all_that_was_found_stand_in_words(found):
    tied = replace(
        found.findings[0], tied_with=("hysteresis",), test_to_separate="Drive slowly.", remark="They disagree."
    )
    text = words(page_of(replace(found, findings=(tied,))))
    for word in (found.sentence, tied.evidence, "Drive slowly.", "They disagree.", "hysteresis", tied.effect):
        assert word.replace("'", "&#39;") in text
    for row in found.ranking:
        assert row.reason.replace("'", "&#39;") in text
    for name, reason in found.untestable.items():
        assert name in text and reason in text


def test_the_pages_need_no_network_and_stay_small(found, improved):
    pages = [page_of(found), improvement_page([improvement_section("front_left", improved)], "title")]
    for page in pages:
        assert not re.search(r"https?://", page.replace(_plotly(), ""))
        assert not re.search(r"<(?:script|link|img|iframe)[^>]+(?:src|href)=[\"'](?!data:)", page)
        assert len(page) < LARGEST


def test_long_recordings_stay_small(found, measured):
    long = [measured(seed, seconds=300.0) for seed in (5, 6)]
    assert len(page_of(replace(found, unseen=tuple(long)))) < LARGEST


def test_names_from_files_cannot_become_markup(found):
    evil = "</script><b>&"
    finding = DataFinding("gaps", evil, evil, f"/data/{evil}.mcap", 0.1)
    page = page_of(replace(found, sentence=evil, data=(finding,)), evil).replace(_plotly(), "")
    assert evil not in page and "&lt;/script&gt;" in page


def test_mistakes_of_the_recordings_are_printed_once_with_their_remedy(found):
    one = DataFinding("gaps", "12 gaps", "check the logger", "/data/a.mcap", 0.1)
    text = words(page_of(replace(found, data=(one, replace(one, recording="/data/b.mcap")))))
    assert text.count("12 gaps") == 1 and "check the logger" in text and "a.mcap, b.mcap" in text


def test_before_and_after_are_mapped_on_one_scale(found):
    maps = figure(page_of(found), "maps")
    assert [trace["coloraxis"] for trace in maps["data"]] == ["coloraxis", "coloraxis"]
    before, after = (np.array(trace["z"], float) for trace in maps["data"])
    assert np.array_equal(np.isnan(before), np.isnan(after)) and np.nanmean(after) < 0.2 * np.nanmean(before)
    assert np.nanquantile(before, 0.9) <= maps["layout"]["coloraxis"]["cmax"] <= np.nanmax(before)
    assert maps["layout"]["coloraxis"]["cmin"] == 0.0


def test_the_worst_passage_shows_every_sample_of_it(found):
    passage = figure(page_of(found), "passage")
    start, end = passage["layout"]["xaxis"]["range"]
    names = [trace["name"] for trace in passage["data"]]
    assert names[:3] == ["measured", "model as given", "improved model"]
    time = passage["data"][0]["x"]
    seconds = found.unseen[0].kinematics.time
    seconds = seconds - seconds[0]
    inside = (seconds >= start) & (seconds <= end)
    assert np.count_nonzero((time >= start - 1e-4) & (time <= end + 1e-4)) == np.count_nonzero(inside)


def test_a_phenomenon_has_one_row_and_tied_ones_follow_what_was_found(found):
    others = [row.phenomenon for row in found.ranking if row.phenomenon != found.findings[0].phenomenon and row.kept]
    tied = replace(found.findings[0], tied_with=(others[-1],))
    names = [row.phenomenon for row in ranked(found.ranking, [tied])]
    assert names[:2] == [tied.phenomenon, others[-1]]
    assert len(names) == len(set(names)) == len({tied.phenomenon, *others})


def test_the_ranking_shows_both_ways_of_judging_with_their_whiskers(found):
    first_row = replace(
        found.ranking[0], kept=EvaluationSummary(5.0, 0.8, 0.7, 0.9), refitted=EvaluationSummary(6.0, 0.6, 0.55, 0.7)
    )
    other = replace(
        found.ranking[1], phenomenon="gas_spring", kept=EvaluationSummary(50.0, -3.0, -4.0, -1.0), refitted=None
    )
    drawn = ranking_figure([first_row, replace(other, reason="it is absurd")], found.findings, {})
    kept, refitted = drawn["data"]
    assert kept["x"][0] == 80.0 and kept["error_x"]["array"][0] == 10.0 and kept["error_x"]["arrayminus"][0] == 10.0
    assert refitted["x"] == [60.0] and kept["marker"]["symbol"] != refitted["marker"]["symbol"]
    low, _ = drawn["layout"]["xaxis"]["range"]
    assert kept["x"][1] >= low and kept["marker"]["color"][0] != kept["marker"]["color"][1]
    assert "it is absurd" in kept["text"][1] and "-300 %" in kept["text"][1]


def test_tied_explanations_are_bracketed(found):
    first_row = found.ranking[0]
    other = next(judged for judged in found.ranking if judged.kept and judged.phenomenon != first_row.phenomenon)
    alone = ranking_figure([first_row, other], found.findings, {})
    tied = replace(found.findings[0], tied_with=(other.phenomenon,))
    drawn = ranking_figure([first_row, other], [tied], {})
    assert not alone["layout"]["shapes"] and len(drawn["layout"]["shapes"]) == 1


def test_parameters_that_changed_are_drawn_and_listed(found):
    moved = (Moved("linear_viscous.rebound", "N s/m", 1500.0, 1200.0, 12.0),)
    changed = replace(found, verdict="parameters_changed", findings=(), elements=(), moved=moved)
    page = page_of(changed)
    assert figure(page, "moved")["data"][0]["x"] == [-20.0]
    text = words(page)
    assert "1\u2009500" in text and "1\u2009200" in text and "± 12" in text
    assert figure(page, "errors")["data"][0]["y"] == ["model as given", "re-identified"]


def test_what_stays_unexplained_has_its_picture(found):
    mean = np.array([[1.0, np.nan], [3.0, -40.0]])
    axes = ("displacement (m)", "velocity (m/s)")
    edges = np.array([-0.01, 0.0, 0.01]), np.array([-1.0, 0.0, 1.0])
    odd = Structure(axes, *edges, mean, "the model is 40 N too low somewhere")
    page = page_of(replace(found, verdict="unexplained", findings=(), elements=(), structure=odd, improved=found.model))
    drawn = figure(page, "structure")
    assert (
        drawn["data"][0]["x"] == [-10.0, 0.0, 10.0]
        and drawn["layout"]["xaxis"]["title"]["text"] == "displacement in mm"
    )
    assert drawn["data"][0]["z"] == [[1.0, None], [3.0, -40.0]]
    assert drawn["layout"]["coloraxis"]["cmin"] == -drawn["layout"]["coloraxis"]["cmax"] == -40.0
    assert "too low somewhere" in words(page) and len(figure(page, "maps")["data"]) == 1


def test_corrections_are_printed_for_the_signal_map(found):
    signals = replace(found.signals, force=replace(found.signals.force, offset=-35.0), spring_rate=1200.0)
    text = words(page_of(replace(found, signals=signals)))
    assert "force.offset" in text and "-35" in text and "force.spring_rate" in text and "1200" in text
    assert "force.skew" not in text


def test_the_waterfall_falls_from_the_first_error_to_the_last(improved):
    (bars,) = waterfall_figure(improved)["data"]
    errors = [step.rmse_unseen_n for step in improved.steps]
    base, width = np.array(bars["base"]), np.array(bars["x"])
    assert base[0] == base[-1] == 0.0
    assert base[0] + width[0] == pytest.approx(errors[0], rel=1e-3) and width[-1] == pytest.approx(errors[-1], rel=1e-3)
    for k in range(1, len(errors)):
        ends = sorted([base[k], base[k] + width[k]])
        assert ends == pytest.approx(sorted(errors[k - 1 : k + 1]), rel=2e-3, abs=1e-3)


def test_what_a_bar_reaches_is_written_behind_its_end_and_covers_the_lines(improved):
    drawn = waterfall_figure(improved)
    (bars,) = drawn["data"]
    words = [words for words in drawn["layout"]["annotations"] if words["xref"] == "x"]
    assert [word["y"] for word in words] == bars["y"] and all(word["bgcolor"] for word in words)
    ends = np.array(bars["base"]) + np.array(bars["x"])
    assert [word["x"] for word in words] == pytest.approx(list(ends), rel=2e-3, abs=1e-2)
    assert max(ends) < 0.8 * drawn["layout"]["xaxis"]["range"][1]


def test_the_names_of_the_atlas_leave_half_of_a_phone_to_the_bars(found):
    (bars,) = atlas_figure(found.atlas, found.findings)["data"]
    assert max(len(line) for name in bars["y"] for line in name.split("<br>")) <= 28


def test_every_step_is_listed_with_what_was_tried_before_it(improved):
    page = improvement_page([improvement_section("front_left", improved)], "title")
    text = words(page)
    assert "add friction" in text and "take out bouc_wen" in text and "nothing more is justified" in text
    assert improved.sentence in text
    sections = data_of(page)["sections"][0]
    assert [name for name in sections if name.startswith("tried")] == ["tried1", "tried3"]
    # Only what stayed is explained: the effect that was taken out is not.
    assert [name for name in sections if name.startswith("explained")] == ["explained0"]


def test_a_search_that_served_two_steps_is_shown_once(improved):
    start, add, _ = improved.steps
    twice = replace(improved, steps=(start, add, replace(add, effect="oil_spring", phenomenon="oil_compressibility")))
    page = improvement_page([improvement_section("front_left", twice)], "title")
    assert [name for name in data_of(page)["sections"][0] if name.startswith("tried")] == ["tried1", "tried3"]


def test_a_bound_is_flagged_instead_of_an_error():
    rows = parameter_rows(
        [FittedParameter("a.b", 3.0, float("nan"), "1", True), FittedParameter("a.c", 2.0, 0.1, "N", False)]
    )
    assert [row["at_bound"] for row in rows] == [True, False] and [row["unit"] for row in rows] == ["", "N"]
    assert [row["error"] for row in rows] == ["", "± 0.10"]


def test_a_value_that_its_error_exceeds_or_leaves_open_is_undetermined():
    rows = parameter_rows(
        [FittedParameter("a.b", 102.0, 6e4, "N", False), FittedParameter("a.c", 2.0, float("nan"), "N", False)]
    )
    assert [(row["value"], row["error"]) for row in rows] == [
        ("102", "± 60\u2009000, undetermined"),
        ("2.000", "undetermined"),
    ]


@given(st.floats(-1e7, 1e7), st.floats(1e-3, 1e6))
def test_values_are_rounded_to_what_their_error_leaves(value, error):
    text, plus_minus = with_error(value, error)
    assert plus_minus.startswith("± ") and plus_minus.endswith(", undetermined") == (error > abs(value))
    plus_minus = plus_minus.removesuffix(", undetermined")
    assert float(text.replace("\u2009", "")) == pytest.approx(
        value, abs=max(0.06 * error, 6e-3 * abs(value) * (abs(value) < 1e-4))
    )
    assert float(plus_minus[2:].replace("\u2009", "")) == pytest.approx(error, rel=0.06)


@given(st.lists(st.sampled_from(["AAAA", "BBBB", "CCCC"]), max_size=6))
def test_equal_arrays_are_stored_once_and_all_can_be_put_back(names):
    traces = [{"x": {"dtype": "f4", "bdata": name}, "name": name} for name in names]
    stored = shared_arrays([{"figure": {"data": traces}}])
    assert len(stored["arrays"]) == len(set(names))
    for trace, name in zip(stored["sections"][0]["figure"]["data"], names, strict=True):
        assert stored["arrays"][trace["x"]["array"]]["bdata"] == trace["name"] == name


def test_the_atlas_shows_what_explains_most_first_and_paints_what_was_found(found):
    drawn = atlas_figure(found.atlas, found.findings)
    (bars,) = drawn["data"]
    assert bars["x"] == sorted(bars["x"], reverse=True) and len(bars["y"]) == len(set(bars["y"])) <= 8
    shown = {row.shows for row in found.atlas if found.findings[0].phenomenon in row.phenomena}
    painted = {name for name, colour in zip(bars["y"], bars["marker"]["color"], strict=True) if colour == FOUND}
    assert painted and shown & set(bars["y"]) <= painted


def test_a_pair_is_one_bar_and_each_says_that_it_acts_against_the_other(found):
    first = found.findings[0]
    two = replace(first, phenomenon="inertia", effect="inertia", partner=first.phenomenon)
    with_partner = replace(found, findings=(replace(first, partner="inertia"), two))
    assert len(diagnosis_section("x", with_partner).figures["errors"]["data"][0]["y"]) == 2
