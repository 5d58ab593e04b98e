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
from hand import Hand, hand, served

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

    def shot(self, own: Hand, name: str) -> None:
        """A picture when the page has come to rest; none of a state that is not wanted."""
        if not self._wanted or name in self._wanted:
            own.page.wait_for_timeout(1500)
            own.page.screenshot(path=self._out / f"studio_{name}{self._kind}.png")


def walk(url: str, camera: Camera) -> None:
    """The whole way, and what can go wrong."""
    with hand(url, *camera.size, camera.scheme) as own:
        camera.shot(own, "empty")
        own.choose("bench-file", "run.csv")
        own.until(lambda: own.page.locator(".bench-velocity .scatterlayer .trace").count() > 0)
        camera.shot(own, "import")
        own.page.locator("#bench-file .dash-dropdown-clear").click()
        own.open(["hidden_fit.mcap"], ["before.yaml", "linear_viscous"], ("hidden_unseen.mcap",))
        own.until(lambda: own.text_of("regions"))
        camera.shot(own, "opened")
        compare(own, camera)
        learn(own, camera)
        change(own, camera)
    with hand(url, *camera.size, camera.scheme) as own:
        own.open(["four_corners_road.mcap"], ["linear_viscous"])
        own.page.click("#overview")
        own.done("comparing all")
        own.until(lambda: own.page.locator(".corner").count() == 4)
        camera.shot(own, "overview")
    with hand(url, *camera.size, camera.scheme) as own:
        own.choose("recordings", "cut.mcap")
        own.choose("models", "linear_viscous")
        own.page.click("#open")
        own.until(lambda: "cut off" in own.text_of("open-message"))
        camera.shot(own, "error")


def compare(own: Hand, camera: Camera) -> None:
    """The worst region, a band of velocities marked, the map of the error and the quality of the data."""
    own.page.locator(".region").first.click()
    own.until(lambda: own.seen()[1] - own.seen()[0] < 2.1)
    camera.shot(own, "compare")
    own.page.locator("#tool").get_by_text("mark").click()
    own.until(lambda: own.figure("velocity")["layout"]["dragmode"] == "select")
    own.drag(".figure.velocity .nsewdrag", (0.35, 0.05), (0.65, 0.95))
    own.until(lambda: "rms error" in own.text_of("marked-summary"))
    camera.shot(own, "marked")
    own.page.click("#unmark")
    own.page.locator("#quality").scroll_into_view_if_needed()
    camera.shot(own, "map")


def learn(own: Hand, camera: Camera) -> None:
    """The diagnosis while it goes on, what it found, and what an effect would explain."""
    own.tab("What is missing")
    own.page.locator("#mode").get_by_text("parameters kept").click()
    own.page.click("#diagnose")
    own.until(lambda: re.match("diagnosing: [2-9][0-9] %", own.text_of("job")))
    camera.shot(own, "diagnosing")
    own.done("diagnosing")
    own.until(lambda: "oil compressibility" in own.text_of("findings"))
    own.page.mouse.move(5, 300)
    camera.shot(own, "diagnosis")
    own.page.locator("#candidates li").first.hover()
    own.until(lambda: own.text_of("equation"))
    camera.shot(own, "evidence")


def change(own: Hand, camera: Camera) -> None:
    """The error falls, sliders, saving; a value that is out of bounds and a file that is there."""
    own.page.locator(".finding button").first.click()
    own.done("identifying")
    own.tab("Steps")
    own.until(lambda: own.page.locator("#steps li").count() == 2)
    camera.shot(own, "steps")
    own.tab("Model")
    camera.shot(own, "model")
    value = own.page.locator("#parameters input.dash-input-element").first
    value.fill("1e12")
    value.press("Enter")
    own.until(lambda: "is outside" in own.text_of("change-message"))
    camera.shot(own, "refused")
    own.tab("Save")
    own.page.fill("#name", "before.yaml")
    own.page.keyboard.press("Enter")
    own.page.click("#save")
    own.until(lambda: "exists already" in own.text_of("save-message"))
    camera.shot(own, "save")


def bench_file() -> str:
    """A file as a logger writes it, with a target and a counter beside what was measured."""
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
