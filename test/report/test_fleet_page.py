"""The fleet's page: one file that needs no network, sorted and filtered by itself."""

import json
import re

import pytest

from damper_estimator.report import fleet_page as module
from damper_estimator.report.fleet_page import fleet_page
from damper_estimator.report.page import _plotly

TEXT = ("recording", "vehicle", "damper", "status", "reason", "report", "verdict")


def row(vehicle="car 1", damper="left", number=0, error=0.05, **more):
    fields = dict.fromkeys((*TEXT, *module._MEASURES, "begin", "temperature_c", "missing", "data_findings", "spoiled"))
    return fields | {
        "recording": f"/f/{vehicle}/{number}.mcap", "vehicle": vehicle, "damper": damper, "status": "done",
        "reason": "", "report": f"tasks/{number}-ab/{damper}.compare.html", "begin": 1_700_000_000_000_000_000 + number,
        "temperature_c": 20.0, "nrmse": error, "rmse_n": 10.0,
    } | more  # fmt: skip


def data_of(page):
    return json.loads(re.search(r'id="data">(.*?)</script>', page, re.DOTALL).group(1))


def rows():
    several = [row(number=k, error=0.05 + 0.001 * (k % 5)) for k in range(20)]
    return [
        *several,
        row(number=20, error=0.4),
        row(number=21, status="failed", reason="cut <off>", nrmse=None, rmse_n=None, report=None),
    ]


TREND = {"vehicle": "car 1", "damper": "left", "since_ns": 0, "low_ns": 0, "high_ns": 86400 * 10**9, "growth": 2.0,
         "p": 0.0001, "recordings": 22}  # fmt: skip


def test_nothing_is_fetched_and_nothing_foreign_is_taken_as_html():
    page = fleet_page({"compare": [row(vehicle="<b>&"), *rows()]}, [], 1, "the rule")
    assert not re.search(r"https?://", page.replace(_plotly(), ""))
    assert "<b>&" not in page and "cut <off>" not in page


def test_outliers_and_failures_are_marked_and_linked():
    table = data_of(fleet_page({"compare": rows()}, [], 1, "the rule"))["verbs"]["compare"]
    assert [k for k, far in enumerate(table["far"]) if far] == [20]
    assert table["link"][20] == "tasks/20-ab/left.compare.html" and table["link"][21] == ""
    assert table["reason"][21] == "cut <off>" and table["measures"]["nrmse"][21] is None


def test_faulty_channels_are_counted_and_shown_with_their_recording():
    sentences = ["gaps: 2 gaps; cut them", "unit: the displacement spans 90 m; scale it"]
    found = [row(number=1), row(number=2, data_findings=sentences, spoiled=sentences[1])]
    page = fleet_page({"compare": found, "fit": found}, [], 0, "the rule")
    table = data_of(page)["verbs"]["compare"]
    assert table["data"] == [[], sentences] and table["spoiled"] == [False, True]
    assert "1 recording with a faulty channel is left out" in page
    assert "faulty" not in fleet_page({"fit": rows()}, [], 0, "")


def test_a_faulty_channel_does_not_count():
    spoiled = row(number=30, nrmse=800.0, spoiled="unit: in mm")
    page = fleet_page({"compare": [*rows(), spoiled]}, [], 1, "the rule")
    table = data_of(page)["verbs"]["compare"]
    assert not table["far"][-1] and table["far"].index(True) == 20
    without = fleet_page({"compare": rows()}, [], 1, "the rule")
    assert re.search(r"error is [\d.]+ %", page).group() == re.search(r"error is [\d.]+ %", without).group()


def test_drifts_and_missing_phenomena_are_reported():
    diagnosed = [row(number=k, verdict="missing", missing=["gas_spring"], nrmse=None) for k in range(3)]
    page = fleet_page({"compare": rows(), "diagnose": diagnosed}, [TREND], 1, "the rule")
    assert "1 of 1 dampers drift away" in page and "1970-01-01 to 1970-01-02" in page and "the rule" in page
    assert "Most often missing: gas spring, 3 times." in page and "1 tasks failed" in page


def test_too_many_rows_are_an_even_choice_with_all_that_stand_out(monkeypatch):
    monkeypatch.setattr(module, "MOST", 10)
    page = fleet_page({"compare": rows()}, [], 1, "the rule")
    table = data_of(page)["verbs"]["compare"]
    assert len(table["link"]) <= 10 and table["recording"][-2:] == ["20", "21"] and "compare: " in page


@pytest.mark.parametrize("verbs", [{}, {"replay": [row(nrmse=None, residual_rms_n=3.0)]}, {"compare": []}])
def test_whatever_there_is_makes_a_page(verbs):
    assert "<main" in fleet_page(verbs, [], 0, "the rule")
