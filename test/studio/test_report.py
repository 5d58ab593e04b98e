"""The report of the whole story, from every state of a session."""

import json
import re

import pytest
from browser import BROWSER, needs_browser, needs_playwright
from studio_page import FLAGS

from damper_estimator.errors import InputError
from damper_estimator.studio.drawn_rows import Mark
from damper_estimator.studio.saving import save
from damper_estimator.studio.view import View


def finished(session):
    session.job.wait()
    assert session.job.state == "done", session.job.error


def test_from_any_state(session, folder):
    assert "0 steps, without a diagnosis" in save(session, "report", "first.html", False)
    first = (folder / "first.html").read_text()
    assert "No diagnosis was made" in first and "hidden_fit.mcap" in first
    session.leave_out(View(0, mark=Mark("time", (1.0, 2.0))))
    finished(session)
    session.refit()
    finished(session)
    assert "one step" in save(session, "report", "second.html", False)
    second = (folder / "second.html").read_text()
    assert "were left out" in second and "as given" in second and "refit" in second
    data = json.loads(re.search(r'id="data">(.*?)</script>', second, re.S).group(1))
    figures = data["sections"][0]
    scales = {(figures[f"map{i}"]["data"][0]["zmin"], figures[f"map{i}"]["data"][0]["zmax"]) for i in (0, 1)}
    assert len(scales) == 1
    with pytest.raises(InputError):
        save(session, "report", "../third.html", False)


@needs_browser
@needs_playwright
def test_the_page_stands_alone_under_a_strict_policy_and_on_a_phone(session, folder):
    from playwright.sync_api import sync_playwright

    session.refit()
    finished(session)
    save(session, "report", "report.html", False)
    content = (folder / "report.html").read_text()
    policy = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"
    faults, foreign = [], []
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=BROWSER, args=FLAGS)
        page = browser.new_page(viewport={"width": 390, "height": 800})
        page.on("console", lambda said: faults.append(said.text) if said.type == "error" else None)
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.on("request", lambda sent: foreign.append(sent.url) if sent.url != "http://page.test/" else None)
        headers = {"Content-Security-Policy": policy, "Content-Type": "text/html; charset=utf-8"}
        page.route("http://page.test/", lambda way: way.fulfill(body=content, headers=headers))
        page.goto("http://page.test/")
        page.wait_for_selector(".js-plotly-plot .scatterlayer .trace")
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        with page.expect_download() as loaded:
            page.locator(".files summary").first.click()
            page.locator("[data-save=csv]").first.click()
        assert open(loaded.value.path()).readline().startswith("trace,")
        browser.close()
    assert not faults and not [url for url in foreign if not url.startswith(("data:", "blob:"))]
