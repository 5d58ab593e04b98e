"""Every kind of page at 390 px: nothing is wider than the screen; it works under a strict policy, without a network."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from browser import BROWSER, needs_browser, needs_playwright
from test_fleet_page import TREND
from test_fleet_page import row as fleet_row
from test_page_in_browser import comparison

import damper_estimator as de
from damper_estimator.control import ConstantCommand
from damper_estimator.model import load_model
from damper_estimator.report import (
    comparison_page,
    damper_section,
    diagnosis_page,
    diagnosis_section,
    improvement_page,
    improvement_section,
)
from damper_estimator.report.comfort_page import comfort_page
from damper_estimator.report.fleet_page import fleet_page
from damper_estimator.report.front_page import front_page
from damper_estimator.report.ride_page import ride_page
from damper_estimator.vehicle import CORNER_CASES, LIMITS, Surface, compare_commands, load_car, single_curve
from damper_estimator.vehicle.comfort import AXLES, comfort_run
from damper_estimator.workflows import characterize, guess_files

BAGS = Path(__file__).resolve().parents[2] / "bags"
POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"
AMPLITUDES = (0.001, 0.02)


def of_a_comparison() -> str:
    return comparison_page([damper_section([comparison(name)], 2) for name in ("left", "right")], "a comparison")


def of_a_front() -> str:
    regimes = {group: {"bouc_wen.alpha": {"mean": 1.0, "stddev": 0.1}} for group in ("LVLF", "HVHF")}
    return front_page("mine", ("LVLF", "HVHF"), np.array([[0.31, 0.35], [0.33, 0.32]]), 1, regimes)


def of_a_ride() -> str:
    commands = {"passive": ConstantCommand(LIMITS[0]), "table": ConstantCommand(LIMITS[1]),
                "model": ConstantCommand(0.5 * sum(LIMITS))}  # fmt: skip
    trials = compare_commands(CORNER_CASES["semi_active"], Surface("bump", 8.0), commands, 4.0, seed=1)
    return ride_page({"front_left": {"bump, 29 km/h": trials}}, "skyhook")


def of_comfort() -> str:
    car, model = load_car("compact_car"), load_model("linear_viscous")
    stiffer = model.with_values({model.slots[0].address: 2.0 * model.slots[0].value})
    runs = [[comfort_run(car, dict.fromkeys(AXLES, rider), amplitude, seconds=10.0) for amplitude in AMPLITUDES]
            for rider in (stiffer, single_curve(model))]  # fmt: skip
    return comfort_page("compact", ("stiffer", "softer"), *runs)


def of_a_fleet() -> str:
    rows = [fleet_row("car 1", number=number, error=0.05 + 0.001 * (number % 4)) for number in range(12)]
    found = [fleet_row(number=number, verdict="missing", missing=["friction"]) for number in range(4)]
    return fleet_page({"compare": rows, "diagnose": found}, [TREND], 2, "the rule")


def of_characteristics() -> str:
    return characterize(de.read(BAGS / "passenger_dyno.mcap")).page()


def of_a_plan() -> str:
    return de.plan(de.read(BAGS / "passenger_road.mcap"), "viscous_curve", parameters=True, minutes=0.5).page()


def of_an_import(folder: Path) -> str:
    time = np.arange(3000) / 300.0
    x, v = 20.0 * np.sin(9.4 * time), 0.188 * np.cos(9.4 * time)
    rows = [f"{t:.5f},{a:.5f},{b:.3f}" for t, a, b in zip(time, x, 1500.0 * v, strict=True)]
    (folder / "bench.csv").write_text("\n".join(["time_s,disp_mm,force_N", *rows]))
    (guessed,) = guess_files([folder / "bench.csv"], folder / "bench.mcap")
    return guessed.page.read_text(encoding="utf-8")


MADE = {
    "comparison": of_a_comparison, "front": of_a_front, "ride": of_a_ride, "comfort": of_comfort, "fleet": of_a_fleet,
    "characteristics": of_characteristics, "plan": of_a_plan,
}  # fmt: skip


@pytest.fixture(params=[*MADE, "diagnosis", "improvement", "import"])
def page(request, tmp_path) -> str:
    if request.param == "import":
        return of_an_import(tmp_path)
    if request.param == "diagnosis":
        return diagnosis_page([diagnosis_section("left", request.getfixturevalue("found"))], "title")
    if request.param == "improvement":
        return improvement_page([improvement_section("left", request.getfixturevalue("improved"))], "title")
    return MADE[request.param]()


def figures_of(content: str) -> dict:
    return json.loads(re.search(r'id="data">(.*?)</script>', content, re.DOTALL)[1])["sections"][0]


def headline_of(content: str) -> str:
    return re.search(r'class="headline">(.*?)</p>', content, re.DOTALL)[1]


@needs_browser
@needs_playwright
def test_it_fits_and_stands_alone(page):
    from playwright.sync_api import sync_playwright

    faults: list[str] = []
    foreign: list[str] = []
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=BROWSER, args=["--no-sandbox", "--disable-gpu"])
        phone = browser.new_page(viewport={"width": 390, "height": 800})
        phone.set_default_timeout(300_000)
        phone.on("console", lambda said: faults.append(said.text) if said.type == "error" else None)
        phone.on("pageerror", lambda error: faults.append(str(error)))
        phone.on(
            "request", lambda sent: foreign.append(sent.url) if not sent.url.startswith(("data:", "blob:")) else None
        )
        headers = {"Content-Security-Policy": POLICY, "Content-Type": "text/html; charset=utf-8"}
        phone.route("http://page.test/", lambda way: way.fulfill(body=page, headers=headers))
        phone.goto("http://page.test/")
        phone.wait_for_selector(".js-plotly-plot .main-svg")
        assert phone.evaluate("document.documentElement.scrollWidth") <= 390
        phone.evaluate("document.querySelectorAll('details').forEach((part) => { part.open = true; })")
        phone.wait_for_timeout(500)
        assert phone.evaluate("document.documentElement.scrollWidth") <= 390
        browser.close()
    assert not faults and foreign == ["http://page.test/"]


def test_traces_that_are_compared_share_their_scale():
    figures = figures_of(of_a_ride())
    ranges = [figures[f"trace_{way}"]["layout"]["yaxis"]["range"] for way in ("table", "model")]
    assert ranges[0] == ranges[1]
    figures = figures_of(of_comfort())
    assert len({tuple(figures[f"{axle}_{size}"]["layout"]["yaxis"]["range"]) for axle in AXLES for size in
                ("small", "large")}) == 1  # fmt: skip


def test_ride_and_comfort_begin_with_what_is_felt_and_explain_the_current():
    ride = of_a_ride()
    assert re.search(r"the body shakes .* with the damper left at one current", headline_of(ride))
    assert "cannot push where it should pull" in ride
    assert re.search(r"on small bumps \(1 mm\) the body moves \d+ % (more|less)", headline_of(of_comfort()))
