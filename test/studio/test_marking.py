"""Marked regions: fitted on alone, diagnosed alone, left out and taken back, written as a table."""

import csv
import io

import numpy as np
import pytest
from browser import needs_browser, needs_playwright
from studio_page import open_page, served

from damper_estimator.errors import InputError
from damper_estimator.studio.drawn_rows import Mark
from damper_estimator.studio.marking import errors_in_words, marked_alone, parted, stretches, table
from damper_estimator.studio.view import View

PASSAGE = View(0, mark=Mark("time", (2.0, 4.0)))
BAND = View(0, mark=Mark("velocity", (-0.1, 0.1, 0.1, -0.1), (-3000.0, -3000.0, 3000.0, 3000.0)))


def finished(session):
    session.job.wait()
    assert session.job.state == "done", session.job.error


def test_a_passage_alone_has_its_samples_judged_and_no_others(session):
    shown = session.shown(session.model)
    part = marked_alone(shown, PASSAGE)
    time = part.kinematics.time[part.judged] - shown.traces[0].time[0]
    assert 2.0 <= time.min() < 2.01 and 3.99 < time.max() <= 4.0
    fit, unseen = parted(part)
    assert not (fit.judged & unseen.judged).any() and (fit.judged | unseen.judged).sum() == part.judged.sum()
    assert fit.judged.sum() == pytest.approx(0.6 * part.judged.sum(), abs=1.0)


def test_what_is_left_out_counts_no_longer_and_comes_back(session):
    before = session.shown(session.model).measures
    spans = stretches(session.shown(session.model), PASSAGE)
    assert len(spans) == 1 and spans[0][1:] == pytest.approx((2.0, 4.0), abs=0.01)
    session.leave_out(PASSAGE)
    finished(session)
    trace = session.shown(session.model).traces[0]
    time = trace.time - trace.time[0]
    assert not trace.judged[(time > 2.0) & (time < 4.0)].any() and trace.judged[time > 4.01].any()
    assert session.shown(session.model).measures.samples == before.samples - 1000
    kept = session.resume(session.writer.name)
    finished(session)
    assert kept.choice.left_out == session.stage.choice.left_out != ()
    assert session.shown(session.model).measures.samples == before.samples - 1000
    session.take_back()
    finished(session)
    assert session.shown(session.model).measures == before and session.stage.choice.left_out == ()


def test_not_everything_can_be_left_out(session):
    with pytest.raises(InputError, match="leave out less"):
        session.leave_out(View(0, mark=Mark("time", (-1.0, 100.0))))
    with pytest.raises(InputError, match="mark a region first"):
        session.leave_out(View())


def test_a_fit_on_a_band_of_velocities_is_best_there(session):
    def there():
        words = errors_in_words(session.shown(session.model), BAND, "it")
        return float(words.partition(" there ")[2].partition(" N")[0])

    session.refit()
    finished(session)
    everywhere = there()
    session.undo()
    session.refit_marked(BAND)
    finished(session)
    assert there() < everywhere
    assert "on the marked" in session.history.now.step.phenomenon


def test_the_table_holds_every_marked_sample(session):
    models = [session.shown(model) for model in session.models()]
    rows = list(csv.DictReader(io.StringIO(table(models, ["a, b", "c"], PASSAGE))))
    trace = models[0].traces[0]
    inside = (trace.time - trace.time[0] >= 2.0) & (trace.time - trace.time[0] <= 4.0)
    assert len(rows) == inside.sum()
    assert np.allclose([float(row["force_measured_n"]) for row in rows], trace.measured[inside], rtol=1e-8)
    assert np.allclose([float(row["force_of_a, b_n"]) for row in rows], trace.modelled[inside], rtol=1e-8)


@needs_browser
@needs_playwright
def test_in_the_browser(folder):
    with served(folder) as (_, url), open_page(url, 1400, 900) as user:
        page = user.page
        user.open(["hidden_fit.mcap"], ["before.yaml"], stop=10.0)
        assert page.locator("#marked-bar").is_hidden()
        page.locator("#tool").get_by_text("mark").click()
        user.until(lambda: user.figure("time")["layout"]["dragmode"] == "select")
        user.drag(".figure.time .nsewdrag", (0.2, 0.3), (0.5, 0.3))
        user.until(
            lambda: (
                "s of hidden_fit.mcap" in user.text_of("marked-summary") and "before" in user.text_of("marked-summary")
            )
        )
        with page.expect_download() as loaded:
            page.click("#export-marked")
        rows = list(csv.DictReader(open(loaded.value.path())))
        assert len(rows) > 1000 and 1.0 < float(rows[0]["time_s"]) < 3.0
        page.click("#fit-marked")
        user.done("identifying")
        user.tab("Steps")
        user.until(lambda: "refit on the marked" in user.text_of("steps"))
        page.click("#leave-out")
        user.done("judging")
        user.until(
            lambda: "there not judged" in user.text_of("marked-summary") and "1 stretch" in user.text_of("left-out")
        )
        page.reload()
        user.until(lambda: "1 stretch" in user.text_of("left-out"))
        page.click("#take-back")
        user.until(page.locator("#left-out").is_hidden)
        assert not user.faults and not user.foreign


@needs_browser
@needs_playwright
def test_a_marked_region_is_diagnosed_alone(folder):
    with served(folder) as (_, url), open_page(url, 1400, 900) as user:
        page = user.page
        user.open(["hidden_fit.mcap"], ["before.yaml"], stop=15.0)
        page.locator("#tool").get_by_text("mark").click()
        user.until(lambda: user.figure("time")["layout"]["dragmode"] == "select")
        user.drag(".figure.time .nsewdrag", (0.05, 0.3), (0.95, 0.3))
        user.until(page.locator("#diagnose-marked").is_visible)
        user.tab("What is missing")
        page.locator("#mode").get_by_text("parameters kept").click()
        page.click("#diagnose-marked")
        user.done("diagnosing")
        user.until(lambda: "of hidden_fit.mcap alone" in user.text_of("findings"))
        assert not user.faults
