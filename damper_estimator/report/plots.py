"""Small pieces of plotly figures: axes, traces, numbers as short as they are shown.

A colour is written ``@role``; the theme replaces it (``theme.py``, ``theme.js``).
"""

from collections.abc import Mapping, Sequence

import numpy as np

from damper_estimator.report.packing import packed

INK, SOFT, LINE, GREY, CARD = "@ink", "@soft", "@line", "@samples", "@card"
BEFORE, AFTER, FOUND = "@error", "@model0", "@model2"

TIGHT = {"l": 55, "r": 12, "t": 8, "b": 40}  # margin of figures with nothing above them
MOTIONS = {
    "displacement": "displacement in mm", "velocity": "velocity in m/s", "acceleration": "acceleration in m/s²",
}  # fmt: skip

Figure = dict[str, object]


def axis(title: str = "", **more: object) -> Figure:
    """An axis with its title, quantity and unit."""
    return ({"title": {"text": title}} if title else {}) | more


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


def shared_arrays(sections: Sequence[Mapping[str, object]]) -> dict[str, object]:
    """The figures of all sections, in which each packed array is stored once, for ``plots.js``."""
    arrays: dict[str, int] = {}
    stored: list[object] = []

    def referenced(value: object) -> object:
        if isinstance(value, Mapping) and "bdata" in value:
            number = arrays.setdefault(value["bdata"], len(stored))
            if number == len(stored):
                stored.append(value)
            return {"array": number}
        if isinstance(value, Mapping):
            return {key: referenced(inner) for key, inner in value.items()}
        return [referenced(inner) for inner in value] if isinstance(value, (list, tuple)) else value

    return {"sections": [referenced(section) for section in sections], "arrays": stored}
