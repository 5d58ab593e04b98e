"""Takes the pictures of docs/studio.md: ``PYTHONPATH=. python test/studio/pictures.py -o docs/images``."""

import argparse
import shutil
import tempfile
from pathlib import Path

from hand import Hand, hand, served

from damper_estimator.cli.main import main as command

BAGS = Path(__file__).parents[2] / "bags"
LARGE = (1920, 1080)


def pictures(url: str, out: Path) -> None:
    """One picture per state, light at 1280 x 720; the last states dark and large."""
    with hand(url) as own:
        shot(own, out, "empty")
        own.open(["hidden_fit.mcap"], ["before.yaml", "linear_viscous"], ("hidden_unseen.mcap",))
        own.until(lambda: own.told("regions"))
        own.page.locator(".region").first.click()
        own.until(lambda: own.seen()[1] - own.seen()[0] < 2.1)
        shot(own, out, "compare")
        own.page.locator("#tool").get_by_text("mark").click()
        own.until(lambda: own.figure("velocity")["layout"]["dragmode"] == "select")
        own.drag(".figure.velocity .nsewdrag", (0.35, 0.05), (0.65, 0.95))
        own.until(lambda: "samples marked" in own.told("marked-told"))
        shot(own, out, "marked")
        own.page.click("#unmark")
        learn(own, out)
    with hand(url, *LARGE, scheme="dark") as own:
        own.open(["hidden_fit.mcap"], ["before.yaml"], ("hidden_unseen.mcap",))
        own.tab("Model")
        shot(own, out, "model_dark_large")
    with hand(url) as own:
        own.choose("recordings", "cut.mcap")
        own.choose("models", "linear_viscous")
        own.page.click("#open")
        own.until(lambda: "cut off" in own.told("open-told"))
        shot(own, out, "error")


def learn(own: Hand, out: Path) -> None:
    """Diagnosis, evidence, the fall of the error, saving."""
    own.tab("What is missing")
    own.page.locator("#mode").get_by_text("parameters kept").click()
    own.page.click("#diagnose")
    own.until(lambda: "%" in own.told("job"))
    shot(own, out, "diagnosing")
    own.done("diagnosing")
    own.until(lambda: "oil compressibility" in own.told("findings"))
    shot(own, out, "diagnosis")
    own.page.locator(".finding").first.hover()
    own.until(lambda: "oil_spring" in own.told("looked-name"))
    own.page.locator("#looked").scroll_into_view_if_needed()
    shot(own, out, "evidence")
    own.page.locator(".finding button").first.click()
    own.done("identifying")
    own.tab("Steps")
    own.until(lambda: own.page.locator("#steps li").count() == 2)
    shot(own, out, "steps")
    own.tab("Model")
    shot(own, out, "model")
    own.tab("Save")
    shot(own, out, "save")


def shot(own: Hand, out: Path, name: str) -> None:
    """A picture when the page has come to rest."""
    own.page.wait_for_timeout(2500)
    own.page.screenshot(path=out / f"studio_{name}.png")


def main() -> None:
    """Opens the studio on the shipped recordings and walks through it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=Path("docs/images"))
    out = parser.parse_args().output
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "recordings"
        folder.mkdir()
        for name in ("hidden_base", "hidden_fit", "hidden_unseen", "passenger_dyno"):
            shutil.copy(BAGS / f"{name}.mcap", folder)
        command(["fit", str(folder / "hidden_base.mcap"), "-m", "viscous_curve", "-o", str(folder / "before.yaml")])
        (folder / "cut.mcap").write_bytes((folder / "hidden_fit.mcap").read_bytes()[:4000])
        with served(folder) as (_, url):
            pictures(url, out)


if __name__ == "__main__":
    main()
