"""The page of a Pareto front: the objectives two by two, with the chosen point, and what is best for each group."""

from collections.abc import Mapping, Sequence

import numpy as np

from damper_estimator.report.page import render
from damper_estimator.report.plots import Figure, axis, shared_arrays, short
from damper_estimator.report.wording import groups_in_words

_LEAST = 1e-9  # a squared error that is shown as it is
_TICKS = ((1.0,), (1.0, 3.0), (1.0, 2.0, 5.0), tuple(np.arange(1.0, 10.0)), tuple(np.arange(1.0, 10.0, 0.2)))
_FEWEST_TICKS, _MOST_TICKS = 3, 7


def front_page(
    model: str,
    groups: Sequence[str],
    objectives: np.ndarray,
    picked: int,
    regimes: Mapping[str, Mapping[str, Mapping[str, float]]],
) -> str:
    """The whole page as HTML; it is self-contained and needs no network.

    Args:
        model: its name.
        groups: names of the objectives.
        objectives: (k, g), squared error relative to that of the start.
        picked: row that became the model.
        regimes: by group and parameter, ``mean`` and ``stddev`` over the solutions that are best for the group.
    """
    pairs = [(a, b) for b in range(len(groups)) for a in range(b)]
    corners = [int(np.argmin(objectives[:, k])) for k in range(len(groups))]
    names = list(next(iter(regimes.values())))
    rows = [
        [name, *(f"{regimes[group][name]['mean']:.4g} ± {regimes[group][name]['stddev']:.2g}" for group in groups)]
        for name in names
    ]
    shares = [
        ", ".join(f"{group} {value:.3g}" for group, value in zip(groups, objective, strict=True))
        for objective in objectives
    ]
    section = {
        "damper": model,
        "headline": f"{len(objectives)} solutions, none better than another for every group. Point {picked} became the "
        f"model: squared error relative to the start {shares[picked]}.",
        "groups": groups,
        "meaning": groups_in_words(groups),
        "pairs": len(pairs),
        "pair_names": [f"{groups[b]} over {groups[a]}" for a, b in pairs],
        "rows": rows,
    }
    figures = {f"pair{k}": _pair(groups, objectives, a, b, picked, corners) for k, (a, b) in enumerate(pairs)}
    return render(
        "front.html", f"Pareto front of {model}", [section], ["page.css"], "plots.js", shared_arrays([figures])
    )


def _pair(groups: Sequence[str], objectives: np.ndarray, a: int, b: int, picked: int, corners: Sequence[int]) -> Figure:
    """Two objectives against each other: all solutions, those that are best for one group, the chosen one."""

    def marks(rows: Sequence[int], name: str, size: int, colour: str, symbol: str) -> Figure:
        shown = np.maximum(objectives[list(rows)], _LEAST)
        return {
            "type": "scatter",
            "mode": "markers",
            "name": name,
            "x": short(shown[:, a]),
            "y": short(shown[:, b]),
            "text": [f"point {row}" for row in rows],
            "marker": {"size": size, "color": colour, "symbol": symbol},
            "hovertemplate": "%{text}: %{x:.3g}, %{y:.3g}<extra></extra>",
        }

    data = [
        marks(range(len(objectives)), "solutions", 6, "@model0", "circle"),
        marks(corners, "best for one group", 10, "@model2", "diamond"),
        marks([picked], "chosen", 12, "@model1", "square"),
    ]
    titles = [f"{groups[k]}: relative squared error" for k in (a, b)]
    axes = [_log_axis(title, np.maximum(objectives[:, k], _LEAST)) for title, k in zip(titles, (a, b), strict=True)]
    return {"data": data, "layout": {"xaxis": axes[0], "yaxis": axes[1]}}


def _log_axis(title: str, values: np.ndarray) -> Figure:
    """A logarithmic axis with three ticks or more at round numbers, also where the values span less than a decade."""
    low, high = float(values.min()) / 1.12, float(values.max()) * 1.12
    decades = 10.0 ** np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1)
    for steps in _TICKS:
        ticks = np.unique(np.outer(decades, steps).round(12))
        ticks = ticks[(ticks >= low) & (ticks <= high)]
        if ticks.size >= _FEWEST_TICKS:
            break
    else:
        ticks = np.linspace(low, high, _FEWEST_TICKS + 2)[1:-1]
    ticks = ticks[:: -(-ticks.size // _MOST_TICKS)]
    ends = np.log10([low, high]).tolist()
    shown = [f"{tick:.3g}" for tick in ticks]
    return axis(title, type="log", range=ends, tickvals=[float(tick) for tick in ticks], ticktext=shown)
