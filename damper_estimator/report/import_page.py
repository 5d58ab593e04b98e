"""The page of ``import --guess``: what each column is taken for, what is in doubt, and what the file looks like so."""

from collections.abc import Sequence

from damper_estimator.recordings import Guess, Part, velocity_of
from damper_estimator.report.decimation import min_max_rows
from damper_estimator.report.page import render
from damper_estimator.report.plots import Figure, axis, line, shared_arrays

_MOST = 6000  # points of a line


def import_page(guess: Guess, parts: Sequence[Part]) -> str:
    """The whole page as HTML; it is self-contained and needs no network.

    Args:
        parts: as read by the guessed map; none where it cannot be read.
    """
    count = len(guess.doubts)
    doubts = f"{count} doubt{'s' if count > 1 else ''} to decide" if count else "nothing is in doubt"
    dampers = list(parts[0].dampers) if parts else ["damper"]
    sections = [
        {"damper": damper, "headline": f"in {guess.path.name}: {doubts}", "rows": column_rows(guess), "guess": guess}
        for damper in dampers
    ]
    figures = [import_figures(parts, damper) if parts else {} for damper in dampers]
    title = f"guessed columns of {guess.path.name}"
    return render("import.html", title, sections, ["page.css"], "plots.js", shared_arrays(figures))


def column_rows(guess: Guess) -> list[tuple[str, str, str, str]]:
    """Title, what it is taken for, unit and reason of every column."""
    rows = []
    for column in guess.columns:
        what = f"{column.damper} {column.quantity}" if column.damper else column.quantity
        turned = ", turned round" if column.scale < 0 else ""
        unit = str(guess.time.get("unit", "")) if column.quantity == "time" else column.unit
        rows.append((str(column.title or f"column {column.column}"), (what or "left out") + turned, unit, column.why))
    return rows


def import_figures(parts: Sequence[Part], damper: str) -> dict[str, Figure]:
    """Displacement and force over time, force over velocity and over displacement, of all parts."""
    time: list[Figure] = []
    speed: list[Figure] = []
    place: list[Figure] = []
    for i, part in enumerate(parts[:5]):
        channels, seconds = part.dampers[damper], (part.stamps - part.stamps[0]) * 1e-9
        name, colour = f"part {part.number}" if len(parts) > 1 else "", f"@model{i % 5}"
        x = channels["displacement"]
        rows = min_max_rows([x, channels.get("force", x)], _MOST)
        time.append(line(seconds[rows], 1e3 * x[rows], name, colour, hovertemplate="%{y:.4g} mm", yaxis="y2"))
        if "force" not in channels:
            continue
        force, velocity = channels["force"], velocity_of(x, seconds)
        time.append(line(seconds[rows], force[rows], name, colour, showlegend=False))
        few = slice(0, 20 * _MOST)
        speed.append(line(velocity[few], force[few], name, colour, 1.0))
        place.append(line(1e3 * x[few], force[few], name, colour, 1.0))
    legend = {"showlegend": len(parts) > 1}
    over_time = {
        "xaxis": axis("time in s", anchor="y2"),
        "yaxis": axis("force in N", domain=[0.52, 1.0]),
        "yaxis2": axis("x in mm", domain=[0.0, 0.46]),
    }
    return {
        "time": {"data": time, "layout": over_time | legend, "height": 380},
        "velocity": {"data": speed, "layout": {"xaxis": axis("velocity in m/s"), "yaxis": axis("force in N")}},
        "place": {"data": place, "layout": {"xaxis": axis("displacement in mm"), "yaxis": axis("force in N")}},
    }
