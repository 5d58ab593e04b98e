"""Small pieces of plotly figures: axes, traces, numbers as short as they are shown.

A colour is written ``@role``; the page's script puts the theme's colour there, so a figure is right in light and dark.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from damper_estimator.report.figures import packed

INK, SOFT, LINE, GREY, CARD = "@ink", "@soft", "@line", "@samples", "@card"
BEFORE, AFTER, FOUND = "@error", "@model0", "@model2"

Figure = dict[str, object]


def axis(title: str = "", **more: object) -> Figure:
    """An axis with its title, quantity and unit."""
    return ({"title": {"text": title, "standoff": 6}} if title else {}) | more


def short(values: np.ndarray, digits: int = 4) -> list[float | None]:
    """Numbers for JSON with few digits; what is not finite becomes null."""
    return [float(f"{value:.{digits}g}") if np.isfinite(value) else None for value in np.asarray(values, float)]


def line(x: np.ndarray, y: np.ndarray, name: str, colour: str, width: float = 1.4, **more: object) -> Figure:
    """A line through many points; a NaN breaks it."""
    return {
        "type": "scatter",
        "mode": "lines",
        "name": name,
        "x": packed(x),
        "y": packed(y),
        "line": {"color": colour, "width": width},
        "hovertemplate": "%{y:.4g} N<extra>" + name + "</extra>",
    } | more


def points(x: np.ndarray, y: np.ndarray, name: str, colour: str, size: float = 3.0, **more: object) -> Figure:
    """A cloud of many points."""
    return {
        "type": "scatter",
        "mode": "markers",
        "name": name,
        "x": packed(x),
        "y": packed(y),
        "marker": {"color": colour, "size": size, "opacity": 0.55},
        "hoverinfo": "skip",
    } | more


def note(text: str, x: float, y: float, **more: object) -> Figure:
    """A word in a figure; ``x`` and ``y`` are shares of the plot unless said otherwise."""
    return {"text": text, "x": x, "y": y, "xref": "paper", "yref": "paper", "showarrow": False} | more


def apart(sections: Sequence[Mapping[str, object]]) -> dict[str, object]:
    """The figures of all sections with each packed array in once, for ``plots.js``."""
    arrays: dict[str, int] = {}
    kept: list[object] = []

    def without(value: object) -> object:
        if isinstance(value, Mapping) and "bdata" in value:
            number = arrays.setdefault(value["bdata"], len(kept))
            if number == len(kept):
                kept.append(value)
            return {"array": number}
        if isinstance(value, Mapping):
            return {key: without(own) for key, own in value.items()}
        return [without(own) for own in value] if isinstance(value, (list, tuple)) else value

    return {"sections": [without(section) for section in sections], "arrays": kept}
