"""The page of ``ride``: tracking error and comfort by surface, and how force follows wish by table and by model."""

from collections.abc import Mapping

import numpy as np

from damper_estimator.report.page import render
from damper_estimator.report.plots import INK, LINE, Figure, apart, axis, line, short
from damper_estimator.vehicle.comparison import Trial, tracking_ratio

COLOURS = {"passive": "@samples", "table": "@model1", "model": "@model0"}
SHOWN = 1.5
"""s of a trace."""
_THIN = 10

Surfaces = Mapping[str, Mapping[str, Trial]]


def ride_page(found: Mapping[str, Surfaces], law: str) -> str:
    """The whole page as HTML; it needs nothing else, no network either.

    Args:
        found: trials by damper, surface and way (passive, table, model).
        law: its name.
    """
    sections, figures = [], []
    for damper, surfaces in found.items():
        best = min(surfaces, key=lambda own: tracking_ratio(surfaces[own]))
        figures.append(_figures(surfaces, best))
        ratios = {surface: tracking_ratio(trials) for surface, trials in surfaces.items()}
        sections.append({
            "damper": damper,
            "headline": f"by {law}: the model's force error is {min(ratios.values()):.2f} to "
            f"{max(ratios.values()):.2f} times the table's in {len(ratios)} scenarios.",
            "best": best,
            "rows": [_row(surface, trials, ratios[surface]) for surface, trials in surfaces.items()],
        })  # fmt: skip
    return render(
        "ride.html", f"feed-forward of the current, {law}", sections, ["page.css"], "plots.js", apart(figures)
    )


def _row(surface: str, trials: Mapping[str, Trial], ratio: float) -> list[str]:
    rows = [own.measures for own in trials.values()]
    return [
        surface,
        " / ".join(f"{m.tracking_n:.0f}" for m in rows),
        f"{ratio:.2f}",
        " / ".join(f"{m.weighted_acceleration:.2f}" for m in rows),
        " / ".join(f"{100 * m.tyre_load:.1f}" for m in rows),
        " / ".join(f"{1e3 * m.stroke:.1f}" for m in rows),
    ]


def _figures(surfaces: Surfaces, best: str) -> dict[str, Figure]:
    start = _strongest(surfaces[best]["model"])
    return {
        "error": _bars(surfaces, "tracking_n", 1.0, "rms force error in N"),
        "body": _bars(surfaces, "weighted_acceleration", 1.0, "weighted body acceleration in m/s²"),
        "tyre": _bars(surfaces, "tyre_load", 100.0, "rms tyre load change in %"),
        "stroke": _bars(surfaces, "stroke", 1e3, "rms stroke in mm"),
        "trace_table": _trace(surfaces[best]["table"], start, "table"),
        "trace_model": _trace(surfaces[best]["model"], start, "model"),
        "current": _currents(surfaces[best], start),
    }


def _bars(surfaces: Surfaces, measure: str, scale: float, title: str) -> Figure:
    ways = next(iter(surfaces.values())).keys()
    data = [
        {
            "type": "bar",
            "name": way,
            "x": list(surfaces),
            "y": short(np.array([scale * getattr(trials[way].measures, measure) for trials in surfaces.values()])),
            "marker": {"color": COLOURS[way]},
            "hovertemplate": "%{x}: %{y:.3g}<extra>" + way + "</extra>",
        }
        for way in ways
    ]
    return {"data": data, "layout": {"xaxis": axis(), "yaxis": axis(title), "showlegend": True, "barmode": "group"}}


def _strongest(trial: Trial) -> float:
    """s, where the stretch with the largest wish begins; after the rest at the start."""
    own = trial.ride
    size = round(SHOWN / own.step)
    summed = np.cumsum(own.wanted**2)
    first = round(1.0 / own.step)
    return own.step * (first + int(np.argmax(summed[first + size :] - summed[first:-size])))


def _part(trial: Trial, start: float) -> slice:
    step = trial.ride.step
    return slice(round(start / step), round((start + SHOWN) / step), _THIN)


def _trace(trial: Trial, start: float, way: str) -> Figure:
    """The force and the wish, and what could be given between two thin lines."""
    own, part = trial.ride, _part(trial, start)
    low, high = trial.attainable[:, part]
    time = own.time[part]
    edges = [
        line(time, edge, "attainable", LINE, 1.0, showlegend=False, hoverinfo="skip", **more)
        for edge, more in ((low, {}), (high, {"fill": "tonexty", "fillcolor": LINE, "opacity": 0.4}))
    ]
    data = [
        *edges,
        line(time, np.clip(own.wanted[part], low, high), "wish, cut to the attainable", INK, 1.2, line={
            "color": INK, "width": 1.2, "dash": "dot"}),
        line(time, own.force[part], f"force by {way}", COLOURS[way], 1.8),
    ]  # fmt: skip
    return {
        "data": data,
        "layout": {"xaxis": axis("time in s"), "yaxis": axis("damper force in N"), "showlegend": True},
    }


def _currents(trials: Mapping[str, Trial], start: float) -> Figure:
    data = []
    for way in ("table", "model"):
        own, part = trials[way].ride, _part(trials[way], start)
        told = "%{y:.2f} A<extra>" + way + "</extra>"
        data.append(line(own.time[part], own.current[part], way, COLOURS[way], 1.4, hovertemplate=told))
    layout = {"xaxis": axis("time in s"), "yaxis": axis("commanded current in A"), "showlegend": True}
    return {"data": data, "layout": layout}
