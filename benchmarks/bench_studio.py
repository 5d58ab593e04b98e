"""The studio on an hour at 1 kHz with four dampers: seconds to the first picture, redraws, memory of the server.

The recording is created once (some minutes) and kept in out/. Redraws are measured from the zoom in a real browser to
the updated figures; without a browser only the server is measured.
"""

import argparse
import contextlib
import sys
from pathlib import Path
from time import perf_counter, process_time

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "test"))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "test" / "studio"))

from browser import BROWSER
from hour_bag import write_hour
from studio_page import StudioPage, open_page, served

from damper_estimator.report.theme import themed
from damper_estimator.studio.folder import Folder
from damper_estimator.studio.linked_figures import Scene, cloud_figure, time_figure
from damper_estimator.studio.session import Session
from damper_estimator.studio.stage import Choice
from damper_estimator.studio.view import MOTIONS, View

MODEL = "linear_viscous"


def memory(pid: int | str) -> float:
    """Peak memory of a process, GB."""
    text = Path(f"/proc/{pid}/status").read_text()
    return int(text.split("VmHWM:")[1].split()[0]) / 1e6


def present_memory(pid: int) -> float:
    """Present memory of a process and all below it, GB; pages that they share are divided among them."""
    total, waiting = 0.0, [pid]
    while waiting:
        process = Path(f"/proc/{waiting.pop()}")
        with contextlib.suppress(OSError):  # it may end at any moment
            total += int((process / "smaps_rollup").read_text().split("Pss:")[1].split()[0]) / 1e6
            waiting += [int(child) for task in (process / "task").iterdir() for child in
                        (task / "children").read_text().split()]  # fmt: skip
    return total


def server_alone(folder: Path, name: str) -> None:
    """Opening and drawing without a browser; with processor time, for machines with other load."""
    session = Session(Folder(folder))
    began, worked = perf_counter(), process_time()
    session.open(Choice((name,)), [MODEL])
    session.job.wait()
    assert session.job.state == "done", session.job.error
    drawn(session, View())
    print(f"server: first picture {perf_counter() - began:.1f} s, processor {process_time() - worked:.1f} s")
    draw = np.random.default_rng(0)
    clock, processor = [], []
    for _ in range(30):
        width = float(10.0 ** draw.uniform(-0.5, 3.5))
        start = float(draw.uniform(0.0, max(3600.0 - width, 1.0)))
        began, worked = perf_counter(), process_time()
        drawn(session, View(0, start, start + width))
        clock.append(perf_counter() - began)
        processor.append(process_time() - worked)
    durations = [f"{1e3 * np.median(v):.0f} ms median, {1e3 * np.max(v):.0f} ms maximum" for v in (clock, processor)]
    print(f"server: redraw of all four figures {durations[0]}; processor {durations[1]}")
    began, worked = perf_counter(), process_time()
    session.comparison(session.shown(session.model))
    print(f"server: regions and map {perf_counter() - began:.1f} s, processor {process_time() - worked:.1f} s")
    print(f"server: memory at most {memory('self'):.2f} GB")


def drawn(session: Session, view: View) -> dict:
    """The figures for the page."""
    scene = Scene([session.shown(session.model)], [MODEL], view)
    clouds = {motion: cloud_figure(scene, motion) for motion in MOTIONS}
    return {name: themed(figure, "light") for name, figure in ({"time": time_figure(scene)} | clouds).items()}


def in_browser(folder: Path, name: str) -> None:
    """The same in a browser."""
    with served(folder) as (process, url), open_page(url) as user:
        user.choose("recordings", name)
        user.choose("models", MODEL)
        began = perf_counter()
        user.page.click("#open")
        user.page.wait_for_selector(".figure.time .main-svg .scatterlayer .trace")
        print(f"browser: first picture {perf_counter() - began:.1f} s")
        user.until(lambda: user.text_of("regions"))
        print(f"browser: regions, map and quality {perf_counter() - began:.1f} s")
        took = [redraw(user, start, start + width) for start, width in ((100, 1800), (500, 300), (2000, 20), (3000, 2))]
        for what, i in (("the figure that is zoomed", 0), ("all four figures", 1)):
            print(f"browser: redraw of {what} {', '.join(f'{1e3 * seconds[i]:.0f}' for seconds in took)} ms")
        print(f"browser: memory of the server at most {memory(process.pid):.2f} GB")
        began, most = perf_counter(), 0.0
        user.page.click("#overview")
        while user.page.locator(".corner").count() < 4:
            most = max(most, present_memory(process.pid))
            user.page.wait_for_timeout(100)
        print(f"browser: all four dampers {perf_counter() - began:.1f} s, memory at most {most:.2f} GB with the worker")


def redraw(user: StudioPage, start: float, stop: float) -> tuple[float, float]:
    """Seconds from a zoom until the figure over time, and the last of all, show the server's data for it."""
    zoom = """([start, stop]) => new Promise((done) => {
        const figures = [...document.querySelectorAll("#left .js-plotly-plot")].filter((own) => own.data.length);
        const began = performance.now();
        const before = figures.map((figure) => figure.data[0].x), took = {};
        figures.forEach((figure, i) => figure.on("plotly_afterplot", () => {
            // First the browser redraws its present data; the server's data have other points.
            if (figure.data[0].x !== before[i]) took[i] ??= (performance.now() - began) / 1000;
            if (Object.keys(took).length === figures.length) done([took[0], Math.max(...Object.values(took))]);
        }));
        Plotly.relayout(figures[0], { "xaxis.range[0]": start, "xaxis.range[1]": stop });
    })"""
    return tuple(user.page.evaluate(zoom, [start, stop]))


def main() -> None:
    """Creates the recording if it is missing, then measures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=Path("out/studio"), help="folder of the recording")
    folder = parser.parse_args().output
    folder.mkdir(parents=True, exist_ok=True)
    if not (folder / "hour.mcap").exists():
        write_hour(folder / "hour.mcap")
    if BROWSER is not None:
        in_browser(folder, "hour.mcap")
    server_alone(folder, "hour.mcap")


if __name__ == "__main__":
    main()
