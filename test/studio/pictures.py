"""Takes the pictures of docs/studio.md, one per state of the page: ``python test/studio/pictures.py -o docs/images``.

``--all`` takes every state on a small and a large screen, light and dark, to look at after a change of the page.
"""

import argparse
import re
import shutil
import sys
import tempfile
from itertools import product
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np
from studio_page import StudioPage, open_page, served

from damper_estimator.cli.main import main as command

BAGS = Path(__file__).resolve().parents[2] / "bags"
SMALL, LARGE = (1280, 720), (1920, 1080)
SHOWN_LARGE = ("compare", "model")  # of which the documents show the dark picture of a large screen as well


class Camera:
    """Takes pictures of one kind of screen; final."""

    def __init__(self, out: Path, size: tuple[int, int], scheme: str, wanted: tuple[str, ...] = ()) -> None:
        self.size, self.scheme = size, scheme
        self._out, self._wanted = out, wanted
        self._kind = ("_dark" if scheme == "dark" else "") + ("_large" if size == LARGE else "")

    def shot(self, user: StudioPage, name: str) -> None:
        """A picture when the page has come to rest; none of a state that is not wanted."""
        if not self._wanted or name in self._wanted:
            user.page.wait_for_timeout(1500)
            user.page.screenshot(path=self._out / f"studio_{name}{self._kind}.png")


def walk(url: str, camera: Camera) -> None:
    """The whole way, and what can go wrong."""
    with open_page(url, *camera.size, camera.scheme) as user:
        camera.shot(user, "empty")
        user.choose("bench-file", "run.csv")
        user.until(lambda: user.page.locator(".bench-velocity .scatterlayer .trace").count() > 0)
        camera.shot(user, "import")
        user.page.locator("#bench-file .dash-dropdown-clear").click()
        user.open(["hidden_fit.mcap"], ["before.yaml", "linear_viscous"], ("hidden_unseen.mcap",))
        user.until(lambda: user.text_of("regions"))
        camera.shot(user, "opened")
        compare(user, camera)
        learn(user, camera)
        change(user, camera)
    with open_page(url, *camera.size, camera.scheme) as user:
        user.open(["passenger_dyno.mcap"], ["viscous_curve"])
        user.until(lambda: user.text_of("regions"))
        user.tab("Tests")
        user.page.click("#characterize")
        user.done("characterizing")
        user.until(lambda: user.page.locator(".test-result").count() == 1)
        camera.shot(user, "tests")
    with open_page(url, *camera.size, camera.scheme) as user:
        user.open(["four_corners_road.mcap"], ["linear_viscous"])
        user.page.click("#overview")
        user.done("comparing all")
        user.until(lambda: user.page.locator(".corner").count() == 4)
        camera.shot(user, "overview")
    with open_page(url, *camera.size, camera.scheme) as user:
        user.choose("recordings", "cut.mcap")
        user.choose("models", "linear_viscous")
        user.page.click("#open")
        user.until(lambda: "cut off" in user.text_of("open-message"))
        camera.shot(user, "error")


def compare(user: StudioPage, camera: Camera) -> None:
    """The worst region, a band of velocities marked, the map of the error and the quality of the data."""
    user.page.locator(".region").first.click()
    user.until(lambda: user.seen()[1] - user.seen()[0] < 2.1)
    camera.shot(user, "compare")
    user.page.locator("#tool").get_by_text("mark").click()
    user.until(lambda: user.figure("velocity")["layout"]["dragmode"] == "select")
    user.drag(".figure.velocity .nsewdrag", (0.35, 0.05), (0.65, 0.95))
    user.until(lambda: "rms error" in user.text_of("marked-summary"))
    camera.shot(user, "marked")
    user.page.click("#unmark")
    user.page.locator("#quality").scroll_into_view_if_needed()
    camera.shot(user, "map")


def learn(user: StudioPage, camera: Camera) -> None:
    """The diagnosis while it runs, what it found, and what an effect would explain."""
    user.tab("What is missing")
    user.page.locator("#mode").get_by_text("parameters kept").click()
    user.page.click("#diagnose")
    user.until(lambda: re.match("diagnosing: [2-9][0-9] %", user.text_of("job")))
    camera.shot(user, "diagnosing")
    user.done("diagnosing")
    user.until(lambda: "oil compressibility" in user.text_of("findings"))
    user.page.mouse.move(5, 300)
    camera.shot(user, "diagnosis")
    user.page.locator("#curves").evaluate("figure => figure.scrollIntoView({ block: 'center' })")
    camera.shot(user, "curves")
    user.page.locator("#candidates li").first.hover()
    user.until(lambda: user.text_of("equation"))
    camera.shot(user, "evidence")


def change(user: StudioPage, camera: Camera) -> None:
    """The error falls, sliders, saving; a value that is out of bounds and a file that is there."""
    user.page.locator(".finding button").first.click()
    user.done("identifying")
    user.tab("Steps")
    user.until(lambda: user.page.locator("#steps li").count() == 2)
    camera.shot(user, "steps")
    user.tab("Model")
    camera.shot(user, "model")
    value = user.page.locator("#parameters input.dash-input-element").first
    value.fill("1e12")
    value.press("Enter")
    user.until(lambda: "is outside" in user.text_of("change-message"))
    camera.shot(user, "refused")
    user.tab("Save")
    user.page.fill("#name", "before.yaml")
    user.page.keyboard.press("Enter")
    user.page.click("#save")
    user.until(lambda: "exists already" in user.text_of("save-message"))
    camera.shot(user, "save")


def bench_file() -> str:
    """A file as a logger writes it, with a target and a counter next to what was measured."""
    t = np.arange(0.0, 4.0, 2e-3)
    x = 25.0 * np.sin(8.2 * t) + 6.0 * np.sin(25.8 * t)
    v = 1e-3 * np.gradient(x, t)
    force = np.where(v > 0.0, 2.4, 1.1) * v + 0.06 * np.tanh(v / 0.02) - 0.18
    head = "Sample,Time [s],Position Setpoint [mm],Position Actual [mm],Load Cell [kN],Oil Temp [degC]\n"
    rows = zip(range(t.size), t, np.roll(x, -2), x, force, 31.0 + 0.4 * t, strict=True)
    return head + "\n".join(",".join(f"{cell:.6g}" for cell in row) for row in rows) + "\n"


def main() -> None:
    """Opens the studio on the shipped recordings and walks through it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=Path("docs/images"))
    parser.add_argument("--all", action="store_true", help="every state on every kind of screen")
    arguments = parser.parse_args()
    out = arguments.output
    out.mkdir(parents=True, exist_ok=True)
    kinds = [Camera(out, SMALL, "light"), Camera(out, LARGE, "dark", SHOWN_LARGE)]
    if arguments.all:
        kinds = [Camera(out, size, scheme) for size, scheme in product((SMALL, LARGE), ("light", "dark"))]
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "recordings"
        folder.mkdir()
        for name in ("hidden_base", "hidden_fit", "hidden_unseen", "passenger_dyno", "four_corners_road"):
            shutil.copy(BAGS / f"{name}.mcap", folder)
        command(["fit", str(folder / "hidden_base.mcap"), "-m", "viscous_curve", "-o", str(folder / "before.yaml")])
        (folder / "run.csv").write_text(bench_file())
        (folder / "cut.mcap").write_bytes((folder / "hidden_fit.mcap").read_bytes()[:4000])
        with served(folder) as (_, url):
            for camera in kinds:
                walk(url, camera)


if __name__ == "__main__":
    main()
