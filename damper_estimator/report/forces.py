"""Measured and modelled force over time, for notebooks; and the report's figures as Plotly's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from damper_estimator.report.decimation import min_max_rows
from damper_estimator.report.plots import GREY, INK, axis, line
from damper_estimator.report.theme import LIGHT, model_colour, themed
from damper_estimator.validation import Comparison

if TYPE_CHECKING:
    from plotly.graph_objects import Figure as PlotlyFigure

_MOST = 20_000  # samples of all recordings together
_HEIGHT = 480


def forces_figure(comparisons: Sequence[Comparison]) -> dict[str, object]:
    """Measured and modelled force in band over time, and the error below; one line per model.

    Args:
        comparisons: one per model, all over the same measurements; several recordings follow each other in time.
    """
    first = comparisons[0]
    most = max(_MOST // len(first.traces), 2)
    begin, rows, times = 0.0, [], []
    for i, trace in enumerate(first.traces):
        rows.append(min_max_rows([trace.measured, *(c.traces[i].residual for c in comparisons)], most))
        times.append(begin + trace.time[rows[-1]] - trace.time[0])
        begin = float(times[-1][-1]) + 1.0
    time = _joined(times)
    measured = _joined([trace.measured[at] for trace, at in zip(first.traces, rows, strict=True)])
    data = [line(time, measured, "measured", INK)]
    for number, c in enumerate(comparisons):
        colour, name = model_colour(number), c.model.name
        modelled = [np.where(t.judged, t.modelled, np.nan)[at] for t, at in zip(c.traces, rows, strict=True)]
        data.append(line(time, _joined(modelled), name, colour))
        error = line(time, _joined(modelled) - measured, f"error of {name}", colour, yaxis="y2", showlegend=False)
        data.append(error)
    layout = {
        "xaxis": axis("time in s", anchor="y2"),
        "yaxis": axis("force in N", domain=[0.42, 1.0]),
        "yaxis2": axis("model - measured in N", domain=[0.0, 0.36], zerolinecolor=GREY),
        "showlegend": True,
    }
    return {"data": data, "layout": layout, "height": _HEIGHT}


def estimates_figure(time: np.ndarray, force: np.ndarray, at: np.ndarray, residual: np.ndarray) -> dict[str, object]:
    """Estimated force over time, and the residual below where a force was measured.

    Args:
        time, force: (n,) s and N.
        at, residual: (m,) s and N; empty without a measured force.
    """
    rows = min_max_rows([force], _MOST)
    data = [line(time[rows], force[rows], "estimate", "@model0")]
    layout: dict[str, object] = {"xaxis": axis("time in s"), "yaxis": axis("force in N")}
    if residual.size:
        shown = min_max_rows([residual], _MOST)
        data.append(line(at[shown], residual[shown], "residual", "@error", yaxis="y2"))
        layout["xaxis"] = axis("time in s", anchor="y2")
        layout["yaxis"] = axis("force in N", domain=[0.42, 1.0])
        layout["yaxis2"] = axis("estimate - measured in N", domain=[0.0, 0.36], zerolinecolor=GREY)
    return {"data": data, "layout": layout, "height": _HEIGHT}


def plotly_figure(figure: Mapping[str, object]) -> PlotlyFigure:
    """A figure of the report as one of Plotly's, in the light theme on white."""
    from plotly.graph_objects import Figure as PlotlyFigure

    drawn = themed(figure, LIGHT)
    layout = drawn["layout"] | {"paper_bgcolor": "#fff", "plot_bgcolor": "#fff"}
    return PlotlyFigure(data=drawn["data"], layout=layout)


def _joined(parts: Sequence[np.ndarray]) -> np.ndarray:
    """Parts behind each other, a NaN between them."""
    return np.concatenate([rows for part in parts for rows in (part, [np.nan])][:-1])
