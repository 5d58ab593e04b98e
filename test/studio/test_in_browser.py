"""The studio in a real browser: the whole way on a shipped recording with a hidden effect, and what can go wrong."""

import json
import signal
from pathlib import Path

import pytest
from browser import needs_browser, needs_playwright
from hand import hand, served

from damper_estimator.cli.main import main

pytestmark = [needs_browser, needs_playwright]
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
    with served(folder) as (_, url), hand(url) as own:
        page = own.page
        assert "Choose a recording and a model" in own.text_of("guide")
        own.open(["hidden_fit.mcap"], ["before.yaml", "linear_viscous"], ("hidden_unseen.mcap",), SECONDS)
        own.until(lambda: own.text_of("regions"))
        assert page.locator("#measures tbody tr").count() == 2
        before = own.rms()
        assert float(before) < float(own.rms(1))

        page.locator(".region").first.click()
        own.until(lambda: own.seen()[1] - own.seen()[0] == pytest.approx(2.0))

        own.tab("What is missing")
        page.locator("#mode").get_by_text("parameters kept").click()
        page.click("#diagnose")
        own.until(lambda: "%" in own.text_of("job"))
        own.done("diagnosing")
        own.until(lambda: "oil compressibility" in own.text_of("findings"))
        page.locator(".finding").first.hover()
        own.until(lambda: "oil_spring" in own.text_of("looked-name") and "F" in own.text_of("equation"))

        page.locator(".finding button").first.click()
        own.done("identifying")
        own.until(lambda: own.rms() != before)
        after = own.rms()
        assert float(after) < 0.4 * float(before)
        own.tab("Steps")
        own.until(lambda: page.locator("#steps li").count() == 2)
        errors = [unseen(text) for text in page.locator("#steps li").all_inner_texts()]
        assert errors[1] < 0.4 * errors[0]

        page.click("#undo")
        own.until(lambda: own.rms() == before)
        own.until(page.locator("#redo").is_enabled)
        page.keyboard.press("Control+y")
        own.until(lambda: own.rms() == after)

        own.tab("Save")
        page.fill("#name", "found.yaml")
        page.keyboard.press("Enter")
        own.until(lambda: "saved found.yaml: step 1: add oil compressibility" in own.text_of("save-message"))
        written = (folder / "found.yaml").read_bytes()
        page.click("#save")
        own.until(lambda: "exists already" in own.text_of("save-message"))
        assert page.locator("#replace").is_visible() and (folder / "found.yaml").read_bytes() == written
        assert not own.faults and not own.foreign
    assert on_command_line(folder, "hidden_unseen.mcap", "found.yaml") == pytest.approx(errors[1], rel=1e-3)
    assert on_command_line(folder, "hidden_unseen.mcap", "before.yaml") == pytest.approx(errors[0], rel=1e-3)


def test_figures_are_linked_and_parameters_move_the_curves(folder):
    with served(folder) as (_, url), hand(url, scheme="dark") as own:
        page = own.page
        own.open(["hidden_fit.mcap"], ["before.yaml"], stop=SECONDS)
        assert page.evaluate("document.documentElement.className") == "dark"
        own.until(lambda: own.text_of("regions"))
        page.locator("#tool").get_by_text("mark").click()
        own.until(lambda: own.figure("velocity")["layout"]["dragmode"] == "select")
        own.drag(".figure.velocity .nsewdrag", (0.3, 0.1), (0.6, 0.9))
        own.until(lambda: "rms error" in own.text_of("marked-summary"))
        for name in ("time", "velocity", "displacement", "acceleration"):
            own.until(lambda name=name: "marked" in [trace["name"] for trace in own.figure(name)["data"]])
        page.click("#unmark")
        own.until(lambda: own.text_of("marked-summary") == "")

        page.locator("#tool").get_by_text("zoom").click()
        own.until(lambda: own.figure("time")["layout"]["dragmode"] == "zoom")
        own.drag(".figure.time .nsewdrag", (0.4, 0.3), (0.6, 0.3))
        own.until(lambda: own.seen()[1] - own.seen()[0] < 0.5 * SECONDS)
        page.click("#all")
        own.until(lambda: own.seen()[1] - own.seen()[0] > 0.9 * SECONDS)

        own.tab("Model")
        before = page.locator("#parameters input.dash-input-element").nth(2).input_value()
        page.locator("#parameters [role=slider]").nth(2).focus()
        for _ in range(5):
            page.keyboard.press("ArrowRight")
        own.until(lambda: page.locator("#measures tbody tr").count() == 2)
        assert page.locator("#parameters input.dash-input-element").nth(2).input_value() != before
        own.tab("Steps")
        own.until(lambda: page.locator("#steps li").count() == 2)
        page.locator("#theme-button").click()
        own.until(lambda: page.evaluate("document.documentElement.className") == "")
        assert not own.faults and not own.foreign


def test_what_cannot_be_read_is_reported_and_leaves_the_page_usable(folder):
    (folder / "cut.mcap").write_bytes((folder / "hidden_fit.mcap").read_bytes()[:4000])
    (folder / "wrong.yaml").write_text("dampers: {passenger_front: {force: {topic: /nowhere}}}\n")
    (folder / "odd.yaml").write_text("name: odd\neffects:\n- no_such_effect\n")
    with served(folder) as (_, url), hand(url) as own:
        page = own.page
        page.click("#open")
        own.until(lambda: "choose a model" in own.text_of("open-message"))
        own.choose("recordings", "cut.mcap")
        own.choose("models", "odd.yaml")
        page.click("#open")
        own.until(lambda: "cut.mcap: cut off" in own.text_of("open-message"))
        own.choose("recordings", "cut.mcap", "hidden_fit.mcap")
        page.click("#open")
        own.until(lambda: "odd.yaml: unknown effect" in own.text_of("open-message"))
        own.choose("models", "odd.yaml", "before.yaml")
        own.choose("map", "wrong.yaml")
        page.click("#open")
        own.until(lambda: "correct the signal map" in own.text_of("open-message"))
        page.reload()
        own.open(["hidden_fit.mcap"], ["before.yaml"], stop=SECONDS)
        assert float(own.rms()) > 0.0 and not own.faults


def test_a_page_that_goes_takes_its_work_along_and_a_killed_server_loses_nothing_saved(folder):
    with served(folder) as (process, url), hand(url) as own:
        own.open(["hidden_fit.mcap"], ["before.yaml"], stop=SECONDS)
        own.tab("Save")
        own.page.fill("#name", "kept.yaml")
        own.page.keyboard.press("Enter")
        own.until(lambda: own.text_of("save-message").startswith("saved kept.yaml"))
        own.tab("What is missing")
        own.page.click("#diagnose")
        own.until(lambda: "%" in own.text_of("job"))
        workers = own.workers(process)
        assert workers
        own.page.goto("about:blank")
        own.until(lambda: not own.workers(process))
        process.send_signal(signal.SIGKILL)
        process.wait()
    assert on_command_line(folder, "hidden_unseen.mcap", "kept.yaml") > 0.0
    assert not list(folder.glob(".*.part"))


def test_a_folder_without_recordings_says_what_to_do(tmp_path):
    with served(tmp_path, "--token") as (_, url), hand(url) as own:
        assert "drop it on this page" in own.text_of("guide")
        assert not own.faults


def test_a_model_that_was_never_identified_offers_refit_and_a_moving_slider_greys_what_is_stale(folder):
    with served(folder) as (_, url), hand(url) as own:
        page = own.page
        own.open(["hidden_fit.mcap"], ["linear_viscous"], stop=SECONDS)
        own.until(lambda: "was never identified" in own.text_of("verdict"))
        own.until(lambda: page.get_attribute("#studio", "data-stale") == "no")
        before = own.rms()
        page.locator("#verdict").get_by_role("button", name="Refit").click()
        own.done("identifying")
        own.until(lambda: own.rms() != before)
        own.tab("Where it fails")
        own.until(lambda: "was never identified" not in own.text_of("verdict"))
        own.tab("Model")
        slider = page.locator("#parameters [role=slider]").first
        box = slider.bounding_box()
        middle = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        page.mouse.move(*middle)
        page.mouse.down()
        page.mouse.move(middle[0] + 30, middle[1], steps=4)
        page.wait_for_timeout(300)  # the curves follow ten times a second
        page.mouse.move(middle[0] + 34, middle[1], steps=4)
        own.until(lambda: page.get_attribute("#studio", "data-stale") == "yes")
        assert float(page.evaluate("getComputedStyle(document.querySelector('#measures')).opacity")) < 0.5
        page.mouse.up()
        own.until(lambda: page.get_attribute("#studio", "data-stale") == "no")
        assert not own.faults
