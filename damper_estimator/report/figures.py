"""Figures of a comparison as plain plotly objects; the page's script puts in the samples on view."""

import re
from collections.abc import Sequence

import numpy as np

from damper_estimator.report.decimation import detail_levels, min_max_rows
from damper_estimator.report.packing import packed
from damper_estimator.report.plots import MOTIONS, TIGHT, Figure, axis
from damper_estimator.report.theme import model_colour
from damper_estimator.validation import Comparison

MAP_COLUMNS, MAP_ROWS = 30, 18
_LEAST_IN_CELL = 5
_LEAST_DECADES = 0.3  # of frequency and of amplitude, for a map over them


def passage(comparisons: Sequence[Comparison], index: int, most: int) -> dict[str, object]:
    """One recording for the time trace and the clouds: at most ``most`` samples of motion, measured and modelled
    forces.

    Modelled forces are shown where they are judged; a row of NaN separates stretches. Models must have been compared on
    the same measurements.
    """
    first = comparisons[0].traces[index]
    kinematics = first.measurement.kinematics
    modelled = [np.where(c.traces[index].judged, c.traces[index].modelled, np.nan) for c in comparisons]
    signals = [first.measured, *(force - first.measured for force in modelled)]
    rows = min_max_rows(signals, most)
    breaks = np.flatnonzero(kinematics.dt[1:] <= 0.0) + 1
    places = np.searchsorted(rows, breaks)

    def column(values: np.ndarray) -> np.ndarray:
        return np.insert(values[rows], places, np.nan)

    time = first.time - first.time[0]
    # A break needs a time of its own, between its neighbours.
    own_time = np.insert(time[rows], places, (time[breaks] + time[breaks - 1]) / 2.0)
    return {
        "time": packed(own_time, "f8"),
        "measured": packed(column(first.measured)),
        "modelled": [packed(column(force)) for force in modelled],
        "motion": {
            "displacement": packed(column(1e3 * kinematics.displacement)),
            "velocity": packed(column(kinematics.velocity)),
            "acceleration": packed(column(kinematics.acceleration)),
        },
        "detail": packed(np.insert(detail_levels([values[rows] for values in signals]), places, 0), "u1"),
    }


def time_figure(names: Sequence[str]) -> Figure:
    """Force over time, the residual below, without samples: measured, modelled forces, residuals."""

    def trace(name: str, colour: str, **more: object) -> Figure:
        hover = f"%{{x:.4f}} s: %{{y:.4g}} N<extra>{name}</extra>"
        line = {"color": colour, "width": 1.2}
        return {"type": "scatter", "mode": "lines", "name": name, "line": line, "hovertemplate": hover} | more

    models = [(_without_markup(name), model_colour(index)) for index, name in enumerate(names)]
    below = {"yaxis": "y2", "showlegend": False}
    data = [trace("measured", "@measured", line={"color": "@measured", "width": 2.2})]
    data += [trace(name, colour) for name, colour in models]
    data += [trace(f"{name} - measured", colour, **below) for name, colour in models]
    layout = {
        "xaxis": axis("time in s", anchor="y2"),
        "yaxis": axis("force in N", domain=[0.36, 1.0], fixedrange=True),
        "yaxis2": axis("residual in N", domain=[0.0, 0.3], fixedrange=True),
        "hovermode": "x",
        "dragmode": "zoom",
        "showlegend": True,
        "margin": TIGHT,
    }
    return {"data": data, "layout": layout}


def cloud_figures(names: Sequence[str]) -> dict[str, Figure]:
    """Force over each motion, without samples: measured and modelled forces."""
    traces = [("measured", "@measured", 0.5)]
    traces += [(_without_markup(name), model_colour(index), 0.65) for index, name in enumerate(names)]
    data = [
        {
            "type": "scatter",
            "name": name,
            "line": {"color": colour, "width": 1.3},
            "marker": {"color": colour, "size": 3, "opacity": opacity},
            "hoverinfo": "x+y",
        }
        for name, colour, opacity in traces
    ]
    return {
        motion: {"data": data, "layout": {"xaxis": axis(title), "yaxis": axis("force in N"), "margin": TIGHT}}
        for motion, title in MOTIONS.items()
    }


def _without_markup(name: str) -> str:
    return re.sub("[<>&]", "", name)


def error_map(comparison: Comparison) -> dict[str, object]:
    """RMS error, less the gauge's zero and drift, over velocity and displacement, as a heat map."""
    pool = comparison.pool
    speed = float(np.quantile(np.abs(pool.velocity), 0.998)) or 1.0
    low, high = (1e3 * float(np.quantile(pool.displacement, q)) for q in (0.001, 0.999))
    edges = [np.linspace(-speed, speed, MAP_COLUMNS + 1), np.linspace(low, max(high, low + 1e-3), MAP_ROWS + 1)]
    hover = "%{x:.3g} m/s, %{y:.3g} mm: %{z:.3g} N"
    titles = ("velocity in m/s", "displacement in mm")
    return _map(pool.velocity, 1e3 * pool.displacement, pool.structure, edges, titles, hover)


def cycle_map(comparison: Comparison) -> dict[str, object] | None:
    """The same over frequency and amplitude of the half cycles, both by logarithms; None where one hardly varies."""
    pool = comparison.pool
    known = np.isfinite(pool.frequency) & (pool.frequency > 0.0) & (pool.amplitude > 0.0)
    if np.count_nonzero(known) < 100:
        return None
    places = [np.log10(values[known]) for values in (pool.frequency, 1e3 * pool.amplitude)]
    ends = [np.quantile(place, [0.005, 0.995]) for place in places]
    if min(high - low for low, high in ends) < _LEAST_DECADES:
        return None
    edges = [np.linspace(*end, count + 1) for end, count in zip(ends, (MAP_COLUMNS, MAP_ROWS), strict=True)]
    titles = ("frequency of the half cycle in Hz", "amplitude in mm")
    hover = "%{x:.3g} Hz, %{y:.3g} mm: %{z:.3g} N"
    drawn = _map(*places, pool.structure[known], edges, titles, hover)
    for side in "xy":
        drawn["data"][0][side] = [float(f"{10.0**value:.4g}") for value in drawn["data"][0][side]]
        drawn["layout"][f"{side}axis"]["type"] = "log"
    return drawn


def _map(
    x: np.ndarray, y: np.ndarray, error: np.ndarray, edges: Sequence[np.ndarray], titles: tuple[str, str], hover: str
) -> dict[str, object]:
    """A heat map of the rms of an error (n,) over two quantities (n,); empty where hardly anything was measured."""
    count = np.histogram2d(x, y, bins=edges)[0]
    rms = np.sqrt(np.histogram2d(x, y, bins=edges, weights=error**2)[0] / np.maximum(count, 1.0))
    middles = [(e[1:] + e[:-1]) / 2.0 for e in edges]
    return {
        "data": [
            {
                "type": "heatmap",
                "x": np.round(middles[0], 5).tolist(),
                "y": np.round(middles[1], 4).tolist(),
                "z": [
                    [float(f"{v:.4g}") if n >= _LEAST_IN_CELL else None for v, n in zip(*row, strict=True)]
                    for row in zip(rms.T, count.T, strict=True)
                ],
                "colorbar": {"title": {"text": "rms error in N"}},
                "hovertemplate": f"{hover}<extra></extra>",
            }
        ],
        "layout": {"xaxis": axis(titles[0]), "yaxis": axis(titles[1]), "margin": TIGHT},
    }


def coherence_figure(comparisons: Sequence[Comparison]) -> dict[str, object] | None:
    """Coherence of measured and modelled force over frequency; None where the recording is too short for it."""
    curves = [
        {
            "type": "scatter",
            "mode": "lines",
            "line": {"color": model_colour(index), "width": 1.6},
            "name": c.model.name,
            "x": np.round(c.coherence.frequency, 4).tolist(),
            "y": [float(f"{v:.4g}") if np.isfinite(v) else None for v in c.coherence.value],
            "hovertemplate": "%{x:.3g} Hz: %{y:.3f}<extra>%{fullData.name}</extra>",
        }
        for index, c in enumerate(comparisons)
        if c.coherence.frequency.size
    ]
    if not curves:
        return None
    layout = {
        "xaxis": axis("frequency in Hz"),
        "yaxis": axis("coherence (1)", range=[0.0, 1.03]),
        "margin": TIGHT,
        "showlegend": len(curves) > 1,
    }
    return {"data": curves, "layout": layout}
