"""The page of ``ride``: tracking error and comfort by surface, and how table and model follow the wanted force."""

from collections.abc import Mapping, Sequence

import numpy as np

from damper_estimator.report.page import render
from damper_estimator.report.plots import INK, LINE, Figure, axis, line, shared_arrays, short
from damper_estimator.vehicle import LIMITS, Trial, tracking_ratio

COLOURS = {"passive": "@samples", "table": "@model1", "model": "@model0"}
SHOWN = 1.5
"""s of a trace."""
_THIN = 10

Surfaces = Mapping[str, Mapping[str, Trial]]


def ride_page(found: Mapping[str, Surfaces], law: str) -> str:
    """The whole page as HTML; it is self-contained and needs no network.

    Args:
        found: trials by damper, surface and way (passive, table, model).
        law: its name.
    """
    sections, figures = [], []
    for damper, surfaces in found.items():
        best = min(surfaces, key=lambda way: tracking_ratio(surfaces[way]))
        figures.append(_figures(surfaces, best))
        ratios = {surface: tracking_ratio(trials) for surface, trials in surfaces.items()}
        sections.append({
            "damper": damper,
            "headline": _for_drivers(surfaces, ratios),
            "law": law,
            "ends": _at_the_ends(surfaces[best]["model"]),
            "best": best,
            "rows": [_row(surface, trials, ratios[surface]) for surface, trials in surfaces.items()],
        })  # fmt: skip
    return render(
        "ride.html", f"feed-forward of the current, {law}", sections, ["page.css"], "plots.js", shared_arrays(figures)
    )


def ride_figure(surfaces: Surfaces) -> Figure:
    """Error of the damper's force by road and command."""
    return _bars(surfaces, "tracking_n", 1.0, "rms force error in N")


def _for_drivers(surfaces: Surfaces, ratios: Mapping[str, float]) -> str:
    """What a test driver would notice, in a sentence or two."""
    less = {other: [_body_change(surface, other) for surface in surfaces.values()] for other in ("table", "passive")}
    roads = "road" if len(ratios) == 1 else "roads"
    passive, table = _range(less["passive"]), _range(less["table"])
    return (
        f"over {len(ratios)} {roads}: with the model the body shakes {passive} with the damper left at one "
        f"current, and {table} with the look-up table. The damper gives the force that is asked for with "
        f"{_span(min(ratios.values()), max(ratios.values()), 2)} times the table's error."
    )


def _body_change(trials: Mapping[str, Trial], other: str) -> float:
    """%, weighted acceleration of the body with the model over that of another way, less 1."""
    model, rival = (trials[way].measures.weighted_acceleration for way in ("model", other))
    return 100.0 * (model / rival - 1.0)


def _range(changes: list[float]) -> str:
    """``3 to 5 % less than``, or ``as much as`` if the changes round to nothing."""
    low, high = round(min(changes)), round(max(changes))
    if low == high == 0:
        return "as much as"
    if high <= 0:
        return f"{_span(-high, -low)} % less than"
    if low >= 0:
        return f"{_span(low, high)} % more than"
    return f"between {-low} % less and {high} % more than"


def _span(low: float, high: float, digits: int = 0) -> str:
    """``3 to 5``, or one number where both ends are the same."""
    ends = [f"{value:.{digits}f}" for value in (low, high)]
    return ends[0] if ends[0] == ends[1] else " to ".join(ends)


def _at_the_ends(trial: Trial) -> str:
    """Why the current jumps between its ends: how often it is there, and how often because nothing better is left."""
    ride, (low, high) = trial.ride, trial.attainable
    judged = slice(round(1.0 / ride.step), None)
    current, wanted = ride.current[judged], trial.desired[judged]
    least, most = LIMITS
    margin = 0.02 * (most - least)
    ends = (current <= least + margin) | (current >= most - margin)
    outside = (wanted < low[judged]) | (wanted > high[judged])
    share, because = 100.0 * float(np.mean(ends)), 100.0 * float(np.mean(outside[ends])) if ends.any() else 0.0
    return (
        "A damper cannot push where it should pull: whenever the wanted force lies outside of what it can give on the "
        "motion of that moment, the nearest end of the current is the best there is, so the current jumps as often as "
        f"the motion turns. Here it is at one of its ends {share:.0f} % of the time, and in {because:.0f} % of that "
        "the wanted force lies outside of what the damper can give."
    )


def _row(surface: str, trials: Mapping[str, Trial], ratio: float) -> list[str]:
    rows = [trial.measures for trial in trials.values()]
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
    traces = {way: _trace(surfaces[best][way], start, way) for way in ("table", "model")}
    ends = _common_range([surfaces[best][way] for way in traces], start)
    for values in traces.values():
        values["layout"]["yaxis"]["range"] = ends
    return {
        "error": ride_figure(surfaces),
        "body": _bars(surfaces, "weighted_acceleration", 1.0, "weighted body acceleration in m/s²"),
        "tyre": _bars(surfaces, "tyre_load", 100.0, "rms tyre load change in %"),
        "stroke": _bars(surfaces, "stroke", 1e3, "rms stroke in mm"),
        "trace_table": traces["table"],
        "trace_model": traces["model"],
        "current": _currents(surfaces[best], start),
    }


def _common_range(trials: Sequence[Trial], start: float) -> list[float]:
    """N, from and to on an axis that traces side by side share."""
    values = np.concatenate([
        curve for trial in trials for curve in (*trial.attainable[:, _part(trial, start)],
                                            trial.ride.force[_part(trial, start)])
    ])  # fmt: skip
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    return [low - 0.05 * (high - low), high + 0.05 * (high - low)]


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
    """s, where the stretch with the largest desired force begins; after the rest at the start."""
    ride = trial.ride
    size = round(SHOWN / ride.step)
    summed = np.cumsum(trial.desired**2)
    first = round(1.0 / ride.step)
    return ride.step * (first + int(np.argmax(summed[first + size :] - summed[first:-size])))


def _part(trial: Trial, start: float) -> slice:
    step = trial.ride.step
    return slice(round(start / step), round((start + SHOWN) / step), _THIN)


def _trace(trial: Trial, start: float, way: str) -> Figure:
    """The force and the desired force, and what is attainable between two thin lines."""
    ride, part = trial.ride, _part(trial, start)
    low, high = trial.attainable[:, part]
    time = ride.time[part]
    edges = [
        line(time, edge, "attainable", LINE, 1.0, showlegend=False, hoverinfo="skip", **more)
        for edge, more in ((low, {}), (high, {"fill": "tonexty", "fillcolor": LINE, "opacity": 0.4}))
    ]
    data = [
        *edges,
        line(time, np.clip(trial.desired[part], low, high), "wanted, cut to the attainable", INK, 1.2, line={
            "color": INK, "width": 1.2, "dash": "dot"}),
        line(time, ride.force[part], f"force by {way}", COLOURS[way], 1.8),
    ]  # fmt: skip
    return {
        "data": data,
        "layout": {"xaxis": axis("time in s"), "yaxis": axis("damper force in N"), "showlegend": True},
    }


def _currents(trials: Mapping[str, Trial], start: float) -> Figure:
    data = []
    for way in ("table", "model"):
        ride, part = trials[way].ride, _part(trials[way], start)
        hover = "%{y:.2f} A<extra>" + way + "</extra>"
        data.append(line(ride.time[part], ride.current[part], way, COLOURS[way], 1.4, hovertemplate=hover))
    layout = {"xaxis": axis("time in s"), "yaxis": axis("commanded current in A"), "showlegend": True}
    return {"data": data, "layout": layout}
