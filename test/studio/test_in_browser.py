"""The studio in a real browser: the whole way on a shipped recording with a hidden effect, and what can go wrong."""

import json
import signal
from pathlib import Path

import pytest
from browser import needs_browser, needs_playwright
from studio_page import open_page, served

from damper_estimator.cli.main import main
from damper_estimator.studio.page_layout import TABS

pytestmark = [needs_browser, needs_playwright]
BEYOND = """width => [...document.querySelectorAll("#right button, #right input")].filter((part) =>
    part.checkVisibility({contentVisibilityAuto: true}) && part.getBoundingClientRect().right > width + 1)
    .map((part) => part.outerHTML)"""
SECONDS = 6.0  # of each recording: enough to tell the hidden effect


def on_command_line(folder: Path, bag: str, model: str) -> float:
    """``rmse_n`` of ``compare``."""
    reported = folder / "expected.json"
    words = ["compare", str(folder / bag), "-m", str(folder / model), "--to", str(SECONDS), "--json", str(reported)]
    assert main(words) == 0
    return json.loads(reported.read_text())["dampers"]["passenger_front"]["rmse_n"]


def unseen(text: str) -> float:
    """The error in ``add oil compressibility 9.34 N unseen``."""
    return float(text.rpartition(" N unseen")[0].rpartition(" ")[2])


def test_the_whole_way(folder):
    with served(folder) as (_, url), open_page(url) as user:
        page = user.page
        assert "Choose a recording and a model" in user.text_of("guide")
        user.open(["hidden_fit.mcap"], ["before.yaml", "linear_viscous"], ("hidden_unseen.mcap",), SECONDS)
        user.until(lambda: user.text_of("regions"))
        assert page.locator("#measures tbody tr").count() == 2
        before = user.rms()
        assert float(before) < float(user.rms(1))

        page.locator(".region").first.click()
        user.until(lambda: user.seen()[1] - user.seen()[0] == pytest.approx(2.0))

        user.tab("What is missing")
        page.locator("#mode").get_by_text("parameters kept").click()
        page.click("#diagnose")
        user.until(lambda: "%" in user.text_of("job"))
        user.done("diagnosing")
        user.until(lambda: "oil compressibility" in user.text_of("findings"))
        page.locator(".finding").first.hover()
        user.until(lambda: "oil_spring" in user.text_of("looked-name") and "F" in user.text_of("equation"))

        page.locator(".finding button").first.click()
        user.done("identifying")
        user.until(lambda: user.rms() != before)
        after = user.rms()
        assert float(after) < 0.4 * float(before)
        user.tab("Steps")
        user.until(lambda: page.locator("#steps li").count() == 2)
        errors = [unseen(text) for text in page.locator("#steps li").all_inner_texts()]
        assert errors[1] < 0.4 * errors[0]

        page.click("#undo")
        user.until(lambda: user.rms() == before)
        user.until(page.locator("#redo").is_enabled)
        page.keyboard.press("Control+y")
        user.until(lambda: user.rms() == after)

        user.tab("Save")
        page.fill("#name", "found.yaml")
        page.keyboard.press("Enter")
        user.until(lambda: "saved found.yaml: step 1: add oil compressibility" in user.text_of("save-message"))
        written = (folder / "found.yaml").read_bytes()
        page.click("#save")
        user.until(lambda: "exists already" in user.text_of("save-message"))
        assert page.locator("#replace").is_visible() and (folder / "found.yaml").read_bytes() == written
        assert not user.faults and not user.foreign
    assert on_command_line(folder, "hidden_unseen.mcap", "found.yaml") == pytest.approx(errors[1], rel=1e-3)
    assert on_command_line(folder, "hidden_unseen.mcap", "before.yaml") == pytest.approx(errors[0], rel=1e-3)


def test_figures_are_linked_and_parameters_move_the_curves(folder):
    with served(folder) as (_, url), open_page(url, scheme="dark") as user:
        page = user.page
        user.open(["hidden_fit.mcap"], ["before.yaml"], stop=SECONDS)
        assert page.evaluate("document.documentElement.className") == "dark"
        user.until(lambda: user.text_of("regions"))
        page.locator("#tool").get_by_text("mark").click()
        user.until(lambda: user.figure("velocity")["layout"]["dragmode"] == "select")
        user.drag(".figure.velocity .nsewdrag", (0.3, 0.1), (0.6, 0.9))
        user.until(lambda: "rms error" in user.text_of("marked-summary"))
        for name in ("time", "velocity", "displacement", "acceleration"):
            user.until(lambda name=name: "marked" in [trace["name"] for trace in user.figure(name)["data"]])
        page.click("#unmark")
        user.until(lambda: user.text_of("marked-summary") == "")

        page.locator("#tool").get_by_text("zoom").click()
        user.until(lambda: user.figure("time")["layout"]["dragmode"] == "zoom")
        user.drag(".figure.time .nsewdrag", (0.4, 0.3), (0.6, 0.3))
        user.until(lambda: user.seen()[1] - user.seen()[0] < 0.5 * SECONDS)
        page.click("#all")
        user.until(lambda: user.seen()[1] - user.seen()[0] > 0.9 * SECONDS)

        user.tab("Model")
        before = page.locator("#parameters input.dash-input-element").nth(2).input_value()
        page.locator("#parameters [role=slider]").nth(2).focus()
        for _ in range(5):
            page.keyboard.press("ArrowRight")
        user.until(lambda: page.locator("#measures tbody tr").count() == 2)
        assert page.locator("#parameters input.dash-input-element").nth(2).input_value() != before
        user.tab("Steps")
        user.until(lambda: page.locator("#steps li").count() == 2)
        page.locator("#theme-button").click()
        user.until(lambda: page.evaluate("document.documentElement.className") == "")
        assert not user.faults and not user.foreign


def test_what_cannot_be_read_is_reported_and_leaves_the_page_usable(folder):
    (folder / "cut.mcap").write_bytes((folder / "hidden_fit.mcap").read_bytes()[:4000])
    (folder / "wrong.yaml").write_text("dampers: {passenger_front: {force: {topic: /nowhere}}}\n")
    (folder / "odd.yaml").write_text("name: odd\neffects:\n- no_such_effect\n")
    with served(folder) as (_, url), open_page(url) as user:
        page = user.page
        page.click("#open")
        user.until(lambda: "choose a model" in user.text_of("open-message"))
        user.choose("recordings", "cut.mcap")
        user.choose("models", "odd.yaml")
        page.click("#open")
        user.until(lambda: "cut.mcap: cut off" in user.text_of("open-message"))
        user.choose("recordings", "cut.mcap", "hidden_fit.mcap")
        page.click("#open")
        user.until(lambda: "odd.yaml: unknown effect" in user.text_of("open-message"))
        user.choose("models", "odd.yaml", "before.yaml")
        user.choose("map", "wrong.yaml")
        page.click("#open")
        user.until(lambda: "correct the signal map" in user.text_of("open-message"))
        page.reload()
        user.open(["hidden_fit.mcap"], ["before.yaml"], stop=SECONDS)
        assert float(user.rms()) > 0.0 and not user.faults


def test_a_page_that_goes_takes_its_work_along_and_a_killed_server_loses_nothing_saved(folder):
    with served(folder) as (process, url), open_page(url) as user:
        user.open(["hidden_fit.mcap"], ["before.yaml"], stop=SECONDS)
        user.tab("Save")
        user.page.fill("#name", "kept.yaml")
        user.page.keyboard.press("Enter")
        user.until(lambda: user.text_of("save-message").startswith("saved kept.yaml"))
        user.tab("What is missing")
        user.page.click("#diagnose")
        user.until(lambda: "%" in user.text_of("job"))
        workers = user.workers(process)
        assert workers
        user.page.goto("about:blank")
        user.until(lambda: not user.workers(process))
        process.send_signal(signal.SIGKILL)
        process.wait()
    assert on_command_line(folder, "hidden_unseen.mcap", "kept.yaml") > 0.0
    assert not list(folder.glob(".*.part"))


def test_a_folder_without_recordings_says_what_to_do(tmp_path):
    with served(tmp_path, "--token") as (_, url), open_page(url) as user:
        assert "drop it on this page" in user.text_of("guide")
        assert not user.faults


def test_a_model_that_was_never_identified_offers_refit_and_a_moving_slider_greys_what_is_stale(folder):
    with served(folder) as (_, url), open_page(url) as user:
        page = user.page
        user.open(["hidden_fit.mcap"], ["linear_viscous"], stop=SECONDS)
        user.until(lambda: "was never identified" in user.text_of("verdict"))
        user.until(lambda: page.get_attribute("#studio", "data-stale") == "no")
        before = user.rms()
        page.locator("#verdict").get_by_role("button", name="Refit").click()
        user.done("identifying")
        user.until(lambda: user.rms() != before)
        user.tab("Where it fails")
        user.until(lambda: "was never identified" not in user.text_of("verdict"))
        user.tab("Model")
        slider = page.locator("#parameters [role=slider]").first
        box = slider.bounding_box()
        middle = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        page.mouse.move(*middle)
        page.mouse.down()
        page.mouse.move(middle[0] + 30, middle[1], steps=4)
        page.wait_for_timeout(300)  # the curves follow ten times a second
        page.mouse.move(middle[0] + 34, middle[1], steps=4)
        user.until(lambda: page.get_attribute("#studio", "data-stale") == "yes")
        assert float(page.evaluate("getComputedStyle(document.querySelector('#measures')).opacity")) < 0.5
        page.mouse.up()
        user.until(lambda: page.get_attribute("#studio", "data-stale") == "no")
        assert not user.faults


@pytest.mark.parametrize("width", [820, 1024])
def test_every_panel_fits_a_narrow_screen(folder, width):
    with served(folder) as (_, url), open_page(url, width, 900) as user:
        widest = "document.documentElement.scrollWidth"
        assert user.page.evaluate(widest) <= width
        user.open(["hidden_fit.mcap"], ["linear_viscous"])
        user.until(lambda: user.text_of("regions"))
        for name in TABS.values():
            user.tab(name)
            user.page.wait_for_timeout(300)
            assert user.page.evaluate(widest) <= width, name
            beyond = user.page.evaluate(BEYOND, width)
            assert not beyond, name
        assert not user.faults
