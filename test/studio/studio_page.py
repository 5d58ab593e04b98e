"""Starts the studio on a folder, opens its page in the system's Chromium and operates it as a user does."""

import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from time import monotonic

from browser import BROWSER

BAGS = Path(__file__).resolve().parents[2] / "bags"
FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-component-update"]
PATIENCE = 240.0  # s, for works: a slow machine compiles kernels again
ACTION = 60.0  # s, for what the page does by itself


@contextmanager
def served(folder: Path, *options: str) -> Iterator[tuple[subprocess.Popen, str]]:
    """The process and address of a studio on a folder, started as users do."""
    words = [sys.executable, "-m", "damper_estimator", "studio", str(folder), "--port", "0", "--no-browser", *options]
    with subprocess.Popen(words, stderr=subprocess.PIPE, text=True) as process:
        try:
            reported = process.stderr.readline()
            found = re.search(r"http://\S+", reported)
            assert found, reported + process.stderr.read()
            yield process, found.group(0)
        finally:
            process.terminate()


class StudioPage:
    """Works with one page; final."""

    def __init__(self, page, url: str) -> None:
        self.page = page
        self.faults: list[str] = []
        self.foreign: list[str] = []
        allowed = (url.partition("?")[0], "data:", "blob:")
        page.set_default_timeout(1000.0 * ACTION)
        page.on("pageerror", lambda error: self.faults.append(str(error)))
        page.on("console", lambda said: self.faults.append(said.text) if said.type == "error" else None)
        page.on("request", lambda sent: None if sent.url.startswith(allowed) else self.foreign.append(sent.url))
        page.goto(url)
        page.wait_for_selector("#recordings")

    def choose(self, dropdown: str, *names: str) -> None:
        """Chooses in a dropdown, as with the mouse."""
        self.page.click(f"#{dropdown}")
        for name in names:
            self.page.locator(".dash-dropdown-content").get_by_text(name, exact=True).click()
        self.page.keyboard.press("Escape")

    def open(
        self, recordings: list[str], models: list[str], unseen: tuple[str, ...] = (), stop: float | None = None
    ) -> None:
        """Opens recordings and models, and waits for the first picture."""
        self.choose("recordings", *recordings)
        if unseen:
            self.choose("unseen", *unseen)
        self.choose("models", *models)
        if stop is not None:
            self.page.fill("#stop", str(stop))
            self.page.keyboard.press("Enter")
        self.page.click("#open")
        self.done("opening")
        self.page.wait_for_selector(".figure.time .main-svg .scatterlayer .trace")

    def done(self, work: str, how: str = "done") -> None:
        """Waits for the end of a work."""
        self.until(lambda: self.text_of("job").startswith(f"{work}: {how}"))

    def until(self, reached: Callable[[], bool]) -> None:
        """Waits for something on the page."""
        end = monotonic() + PATIENCE
        while not reached():
            assert monotonic() < end, f"waited in vain; the page says: {self.text_of('studio')[:600]}"
            self.page.wait_for_timeout(100)

    def tab(self, name: str) -> None:
        """Turns to a panel."""
        self.page.locator("#tab").get_by_text(name, exact=True).click()

    def rms(self, row: int = 0) -> str:
        """The rms error that the table of agreement shows."""
        return self.page.locator("#measures tbody tr").nth(row).locator("td").first.inner_text()

    def seen(self) -> tuple[float, float]:
        """From and to of the time on view, s."""
        return tuple(self.page.evaluate("document.querySelector('.figure.time .js-plotly-plot').layout.xaxis.range"))

    def figure(self, name: str) -> dict:
        """What a linked figure draws: its traces' names and its layout."""
        return self.page.evaluate(
            "name => { const fig = document.querySelector(`.figure.${name} .js-plotly-plot`);"
            " return {data: fig.data.map((trace) => ({name: trace.name})), layout: {dragmode: fig.layout.dragmode}}; }",
            name,
        )

    def drag(self, place: str, start: tuple[float, float], end: tuple[float, float]) -> None:
        """Drags the mouse between two points of an element, given as shares of its width and height."""
        target = self.page.locator(place).first
        target.evaluate("element => element.scrollIntoView({block: 'center'})")
        box = target.bounding_box()
        corners = [(box["x"] + x * box["width"], box["y"] + y * box["height"]) for x, y in (start, end)]
        self.page.mouse.move(*corners[0])
        self.page.mouse.down()
        self.page.mouse.move(*corners[1], steps=8)
        self.page.mouse.up()

    def workers(self, server: subprocess.Popen) -> list[int]:
        """Processes that work for the server: leaders of separate sessions below its fork server."""
        rows = subprocess.run(["ps", "-eo", "pid=,ppid=,sid="], capture_output=True, text=True).stdout.splitlines()
        parents = {int(pid): (int(parent), int(sid)) for pid, parent, sid in map(str.split, rows)}
        below = {pid for pid, (parent, _) in parents.items() if parent == server.pid}
        return [pid for pid, (parent, sid) in parents.items() if parent in below and sid == pid]

    def text_of(self, place: str) -> str:
        """The words at a place."""
        return self.page.locator(f"#{place}").inner_text()


@contextmanager
def open_page(url: str, width: int = 1280, height: int = 720, scheme: str = "light") -> Iterator[StudioPage]:
    """A page of a fresh browser."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=BROWSER, args=FLAGS)
        try:
            context = browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme)
            yield StudioPage(context.new_page(), url)
        finally:
            browser.close()
