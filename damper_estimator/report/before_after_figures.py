"""Figures of forces and errors over the unseen recordings, before and after, and of what a found effect explains."""

import numpy as np

from damper_estimator.diagnosis import Structure
from damper_estimator.report.before_after import BeforeAfter, Explained, Recording
from damper_estimator.report.decimation import min_max_rows
from damper_estimator.report.plots import AFTER, BEFORE, FOUND, GREY, INK, Figure, axis, line, note, points, short

_MOST_AROUND = 1200  # rows of the recording besides the worst passage
_CLOUD = 1000
_COLUMNS, _ROWS = 32, 20
_LEAST_IN_CELL = 5
_BRIGHTEST = 0.995  # share of the map's cells that the colours distinguish
_LEFT, _RIGHT = [0.0, 0.485], [0.515, 1.0]
_TITLE = {"yref": "paper", "yanchor": "bottom", "font": {"size": 13}}


def passage_figure(shown: BeforeAfter) -> Figure:
    """Measured and modelled force over time, the residual below; opens at the worst passage, holds all of it."""
    worst = shown.worst
    rows = _rows(worst)
    time, breaks = _with_breaks(worst, rows)

    def column(values: np.ndarray) -> np.ndarray:
        return np.insert(np.where(worst.judged, values, np.nan)[rows], breaks, np.nan)

    data = [line(time, column(worst.raw), "measured", INK, 2.2)]
    if shown.corrected:
        data.append(line(time, column(worst.measured), "measured, corrected", GREY, 2.2))
    same = shown.corrected and np.array_equal(worst.before, worst.after)
    data.append(line(time, column(worst.before), "model" if same else "model as given", AFTER if same else BEFORE))
    below = [
        line(time, column(worst.error_before), "error of the model as given", BEFORE, yaxis="y2", showlegend=False)
    ]
    if shown.changed:
        data += [] if same else [line(time, column(worst.after), "improved model", AFTER)]
        below.append(
            line(
                time,
                column(worst.error_after),
                "error with the corrections" if same else "error, improved",
                AFTER,
                yaxis="y2",
                showlegend=False,
            )
        )
    layout = {
        "xaxis": axis("time in s", anchor="y2", range=list(worst.worst)),
        "yaxis": axis("force in N", domain=[0.36, 1.0], fixedrange=True),
        "yaxis2": axis("error in N", domain=[0.0, 0.29], fixedrange=True),
        "hovermode": "x",
        "showlegend": True,
    }
    return {"data": data + below, "layout": layout}


def _rows(recording: Recording) -> np.ndarray:
    forces = [recording.raw, np.nan_to_num(recording.error_before), np.nan_to_num(recording.error_after)]
    return np.union1d(recording.passage_rows(), min_max_rows(forces, _MOST_AROUND))


def _with_breaks(recording: Recording, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Time at the rows with one more where a stretch ends, and where those are to be put in."""
    step = np.diff(recording.time)
    ends = np.flatnonzero(step > 20.0 * np.median(step)) if step.size else np.zeros(0, int)
    places = np.searchsorted(rows, ends + 1)
    return np.insert(recording.time[rows], places, (recording.time[ends] + recording.time[ends + 1]) / 2.0), places


def loops_figure(shown: BeforeAfter) -> Figure:
    """Force over velocity and over displacement in the worst passage."""
    worst = shown.worst
    rows = worst.passage_rows()
    places = (worst.velocity[rows], 1e3 * worst.displacement[rows])
    data = []
    for index, place in enumerate(places):
        on = {"showlegend": not index, "hoverinfo": "skip"} | ({"xaxis": "x2", "yaxis": "y2"} if index else {})
        data.append(line(place, worst.measured[rows], "measured", INK, 2.2, **on))
        data.append(line(place, worst.before[rows], "model as given", BEFORE, **on))
        if shown.changed:
            data.append(line(place, worst.after[rows], "improved model", AFTER, **on))
    layout = {
        "xaxis": axis("velocity in m/s", domain=_LEFT),
        "xaxis2": axis("displacement in mm", domain=_RIGHT, anchor="y2"),
        "yaxis": axis("force in N"),
        "yaxis2": axis(matches="y", showticklabels=False, anchor="x2"),
        "showlegend": True,
    }
    return {"data": data, "layout": layout}


def cloud_figure(shown: BeforeAfter, over: str) -> Figure:
    """Force over velocity or displacement in all unseen recordings: model as given at the left, improved at the right.

    Args:
        over: ``velocity`` or ``displacement``.
    """
    scale, title = (1.0, "velocity in m/s") if over == "velocity" else (1e3, "displacement in mm")
    pieces = [_cloud_rows(recording, _CLOUD // len(shown.recordings)) for recording in shown.recordings]

    def gathered(name: str) -> np.ndarray:
        return np.concatenate(
            [getattr(recording, name)[rows] for recording, rows in zip(shown.recordings, pieces, strict=True)]
        )

    place = scale * gathered(over)
    data = [
        points(place, gathered("raw"), "measured", GREY, 3.5),
        points(place, gathered("before"), "model as given", BEFORE, 2.5),
    ]
    right = {"xaxis": "x2", "yaxis": "y2"}
    if shown.changed:
        data.append(points(place, gathered("measured"), "measured", GREY, 3.5, showlegend=False, **right))
        data.append(points(place, gathered("after"), "improved model", AFTER, 2.5, **right))
    return {"data": data, "layout": _side_by_side(shown.changed, title, "force in N") | {"showlegend": True}}


def _side_by_side(both: bool, x: str, y: str) -> Figure:
    if not both:
        return {"xaxis": axis(x), "yaxis": axis(y)}
    narrow = x.replace(" in ", "<br>in ")  # both fit a phone
    return {
        "xaxis": axis(narrow, domain=_LEFT),
        "yaxis": axis(y),
        "xaxis2": axis(narrow, domain=_RIGHT, anchor="y2", matches="x"),
        "yaxis2": axis(matches="y", anchor="x2", showticklabels=False),
    }


def _cloud_rows(recording: Recording, most: int) -> np.ndarray:
    """Evenly spread rows and those of the extremes, judged ones."""
    judged = np.flatnonzero(recording.judged)
    even = judged[:: max(1, 2 * judged.size // max(most, 1))]
    forces = [recording.raw[judged], recording.error_before[judged], recording.error_after[judged]]
    return np.union1d(even, judged[min_max_rows(forces, max(most // 2, 12))])


def error_maps(shown: BeforeAfter) -> Figure:
    """RMS error over velocity and displacement before and after, on one scale; empty where little was measured."""
    joined = {
        name: np.concatenate([getattr(recording, name)[recording.judged] for recording in shown.recordings])
        for name in ("velocity", "displacement", "error_before", "error_after")
    }
    speed = float(np.quantile(np.abs(joined["velocity"]), 0.998)) or 1.0
    low, high = (1e3 * float(np.quantile(joined["displacement"], q)) for q in (0.001, 0.999))
    edges = [np.linspace(-speed, speed, _COLUMNS + 1), np.linspace(low, max(high, low + 1e-3), _ROWS + 1)]
    place = (joined["velocity"], 1e3 * joined["displacement"])
    maps = [_rms_map(place, joined[name], edges) for name in ("error_before", "error_after")][: 1 + shown.changed]
    seen = maps[0][np.isfinite(maps[0])]
    top = float(np.quantile(seen, _BRIGHTEST)) if seen.size else 1.0
    middles = [short((edge[1:] + edge[:-1]) / 2.0) for edge in edges]
    data = [
        {
            "type": "heatmap",
            "x": middles[0],
            "y": middles[1],
            "z": [short(row, 3) for row in rms],
            "coloraxis": "coloraxis",
            "hovertemplate": "%{x:.3g} m/s, %{y:.3g} mm: %{z:.3g} N<extra></extra>",
        }
        | ({"xaxis": "x2", "yaxis": "y2"} if index else {})
        for index, rms in enumerate(maps)
    ]
    titles = zip((0.0, 0.515), ("model as given", "improved model"), maps, strict=False)
    layout = _side_by_side(shown.changed, "velocity in m/s", "displacement in mm") | {
        "coloraxis": _colours("rms error in N", 0.0, top),
        "annotations": [note(text, x, 1.0, xanchor="left", **_TITLE) for x, text, _ in titles],
    }
    return {"data": data, "layout": layout}


def _rms_map(place: tuple[np.ndarray, np.ndarray], error: np.ndarray, edges: list[np.ndarray]) -> np.ndarray:
    count = np.histogram2d(*place, bins=edges)[0].T
    square = np.histogram2d(*place, bins=edges, weights=error**2)[0].T
    return np.where(count >= _LEAST_IN_CELL, np.sqrt(square / np.maximum(count, 1.0)), np.nan)


def _colours(title: str, low: float, high: float, scale: str = "Cividis") -> Figure:
    bar = {"title": {"text": title, "side": "right"}, "thickness": 12, "outlinewidth": 0}
    return {"colorscale": scale, "cmin": low, "cmax": high, "colorbar": bar}


def explained_figure(shown: BeforeAfter, found: Explained, name: str) -> Figure:
    """What was missing and what the effect accounts for: over time in the worst passage, over velocity in all of it."""
    worst = shown.worst
    passage = worst.passage_rows()
    cloud = _cloud_rows(worst, _CLOUD)
    cloud = cloud[np.isfinite(found.missing[cloud])]
    on = {"xaxis": "x2", "yaxis": "y2", "showlegend": False}
    data = [
        line(worst.time[passage], found.missing[passage], "missing without it", GREY, 2.4),
        line(worst.time[passage], found.part[passage], name, FOUND, 1.6),
        points(worst.velocity[cloud], found.missing[cloud], "missing without it", GREY, 3.5, **on),
        points(worst.velocity[cloud], found.part[cloud], name, FOUND, 2.5, **on),
    ]
    layout = {
        "xaxis": axis("time in s", domain=[0.0, 0.56]),
        "yaxis": axis("force in N"),
        "xaxis2": axis("velocity in m/s", domain=[0.6, 1.0], anchor="y2"),
        "yaxis2": axis(matches="y", anchor="x2", showticklabels=False),
        "showlegend": True,
    }
    return {"data": data, "layout": layout}


def contribution_figure(contributions: dict[str, float], found: set[str]) -> Figure:
    """RMS of each effect's share of the improved model's force, the found ones marked."""
    names = list(contributions)
    bars = {
        "type": "bar",
        "orientation": "h",
        "y": [f"<b>{name}</b>" if name.partition("#")[0] in found else name for name in names],
        "x": short(np.array(list(contributions.values())), 3),
        "marker": {"color": [FOUND if name.partition("#")[0] in found else AFTER for name in names]},
        "hovertemplate": "%{y}: %{x:.3g} N rms<extra></extra>",
    }
    layout = {
        "xaxis": axis("rms of its share of the force in N", nticks=6),
        "yaxis": axis(autorange="reversed"),
        "showlegend": False,
        "bargap": 0.35,
    }
    return {"data": [bars], "layout": layout, "height": 80 + 28 * len(names), "plain": True}


def structure_figure(found: Structure) -> Figure:
    """Mean of what is left over the two quantities that tell most about it."""
    top = float(np.nanmax(np.abs(found.mean_n))) if np.isfinite(found.mean_n).any() else 1.0
    x, y = (_shown_axis(name) for name in found.axes)
    heat = {
        "type": "heatmap",
        "x": short(x[1] * found.x),
        "y": short(y[1] * found.y),
        "z": [short(row, 3) for row in found.mean_n],
        "coloraxis": "coloraxis",
        "hovertemplate": "%{x:.3g}, %{y:.3g}: %{z:.3g} N<extra></extra>",
    }
    layout = {
        "xaxis": axis(x[0]),
        "yaxis": axis(y[0]),
        "coloraxis": _colours("mean of modelled − measured in N", -top, top, "RdBu"),
    }
    return {"data": [heat], "layout": layout}


def _shown_axis(name: str) -> tuple[str, float]:
    """``displacement (m)`` as ``displacement in mm``, with the factor."""
    quantity, _, unit = name.partition(" (")
    unit, factor = (unit.rstrip(")"), 1.0)
    if unit == "m":
        unit, factor = "mm", 1e3
    return f"{quantity} in {unit}".replace("^2", "²").replace("deg C", "°C"), factor
