"""Figures of the atlas's curves: what the model lacks over each variable, with its band and what it may be."""

from collections.abc import Sequence
from textwrap import wrap

import numpy as np

from damper_estimator.diagnosis import AtlasCurve, Diagnosis, Template
from damper_estimator.numbers import number
from damper_estimator.report.diagnosis_wording import listed
from damper_estimator.report.plots import INK, LINE, Figure, axis, note, short

_HEIGHT, _LEGEND, _TITLE, _BELOW = 240, 84, 40, 46  # px, of a panel, its legend, its title, and its axis below
_WIDTH = 48  # characters of a title after which it wraps
_MARGIN = 8  # px
_LINES = {
    "mass": ("@model0", "dash"), "shift": ("@model1", "dot"), "series": ("@model2", "dashdot"),
    "valve": ("@model3", "longdash"),
}  # fmt: skip
_TITLES = {
    "velocity": "Force over velocity",
    "displacement": "Force over displacement",
    "position": "Damping over displacement",
    "temperature": "Force per kelvin, over velocity",
    "command": "Force per unit of the command, over velocity",
    "acceleration": "Force that goes with acceleration, over velocity",
    "history": "Force at rising less force at falling speed, over velocity",
    "memory": "Force in the direction of motion, over the travel since the last reversal",
}
_VARIABLES = {
    "velocity": "a change of the curve over velocity",
    "displacement": "a force over displacement",
    "position": "damping that depends on displacement",
    "temperature": "temperature",
    "command": "the command",
    "acceleration": "acceleration",
    "history": "whether the speed rises or falls",
    "memory": "travel since the last reversal",
}
_OVER = {
    "displacement": (1e3, "displacement in mm", "mm"), "position": (1e3, "displacement in mm", "mm"),
    "memory": (1e3, "travel since the last reversal in mm", "mm"),
}  # fmt: skip
_VELOCITY = (1.0, "velocity in m/s", "m/s")


def notable(curves: Sequence[AtlasCurve]) -> list[AtlasCurve]:
    """The curves that are shown, the one that explains most first."""
    return sorted((curve for curve in curves if curve.is_notable), key=lambda curve: -curve.explains)


def curve_title(curve: AtlasCurve) -> str:
    """What a curve shows, and how much of the error it explains."""
    beyond = " beyond the others" if curve.is_memory else ""
    return f"{_TITLES[curve.name]}: explains {100.0 * curve.explains:.0f} %{beyond}"


def command_unit(found: Diagnosis) -> str:
    """The unit of the command, A unless the signal map says otherwise."""
    return found.signals.command.unit or "A"


def left_out(curves: Sequence[AtlasCurve]) -> str:
    """A sentence about the curves that are not shown; "" without any."""
    names = [_VARIABLES[curve.name] for curve in curves if not curve.is_notable]
    return f"Explains next to nothing beside the others: {listed(names, 'and')}." if names else ""


def template_words(template: Template) -> str:
    """What a template is, with the share of the error that it explains."""
    size = template.size
    words = {
        "mass": f"a mass of {_signed(size)} kg",
        "shift": f"a force that is {number(1e3 * abs(size), 2)} ms {'late' if size > 0.0 else 'early'}",
        "series": "something elastic in series",
        "valve": f"a valve that opens at {number(size, 2)} m/s",
    }[template.name]
    return f"{words}: {100.0 * max(template.explains, 0.0):.0f} %"


def _signed(value: float) -> str:
    return number(value, 2).replace("-", "−")


def curve_figure(curve: AtlasCurve, unit: str) -> Figure:
    """One curve with its band, 5 to 95 %, and its templates; ``unit`` is the command's."""
    factor, title, short_unit = _OVER.get(curve.name, _VELOCITY)
    scale, quantity = _quantity(curve, unit)
    known = np.isfinite(curve.value)
    at = short(factor * np.array(curve.at)[known])
    value, low, high = (scale * np.array(values)[known] for values in (curve.value, curve.low, curve.high))
    hover = f"%{{x:.3g}} {short_unit}: %{{y:.3g}} {quantity.rpartition(' in ')[2]}<extra>%{{fullData.name}}</extra>"
    quiet = {
        "type": "scatter",
        "mode": "lines",
        "x": at,
        "line": {"width": 0},
        "hoverinfo": "skip",
        "showlegend": False,
    }
    band = {"name": "5 to 95 %", "fillcolor": LINE}
    data = [
        quiet | {"y": short(low)},
        quiet | band | {"y": short(high), "fill": "tonexty"},
        *(_template(template, np.array(curve.at)[known], known) for template in curve.templates),
        quiet
        | {
            "y": short(value), "mode": "lines+markers", "line": {"color": INK, "width": 1.8}, "marker": {"size": 4},
            "name": "found", "hoverinfo": "x+y", "hovertemplate": hover,
        },
    ]  # fmt: skip
    layout = {
        "xaxis": axis(title),
        "yaxis": axis(quantity, range=_range(value, low, high), nticks=7),
        "showlegend": bool(curve.templates),
        "legend": {"traceorder": "normal"},
    }
    return {"data": data, "layout": layout, "height": _HEIGHT + (_LEGEND if curve.templates else 0), "plain": True}


def _quantity(curve: AtlasCurve, unit: str) -> tuple[float, str]:
    """Factor and title of the curve's own axis."""
    return {
        "position": (100.0, "change in % of the force"),
        "temperature": (1.0, "change in N/K"),
        "command": (1.0, f"change in N/{unit}"),
        "acceleration": (1.0, "force per acceleration in kg"),
        "history": (1.0, "difference of the force in N"),
    }.get(curve.name, (1.0, "change of the force in N"))


def _template(template: Template, at: np.ndarray, known: np.ndarray) -> Figure:
    colour, dash = _LINES[template.name]
    return {
        "type": "scatter",
        "mode": "lines",
        "name": template_words(template),
        "x": short(at),
        "y": short(np.array(template.value)[known]),
        "line": {"color": colour, "width": 1.4, "dash": dash},
        "hoverinfo": "skip",
    }


def _range(value: np.ndarray, low: np.ndarray, high: np.ndarray) -> list[float]:
    """Of the curve and as much of its band as leaves the curve visible."""
    top = float(np.abs(value).max())
    lowest = min(float(np.maximum(low, value - 0.5 * top).min()), 0.0)
    highest = max(float(np.minimum(high, value + 0.5 * top).max()), 0.0)
    pad = 0.07 * (highest - lowest)
    return short([lowest - pad, highest + pad])


def curve_figures(found: Diagnosis, key: str = "curve") -> dict[str, Figure]:
    """The figures of the curves that say something, by the name in the page, which begins with ``key``."""
    unit = command_unit(found)
    return {f"{key}_{curve.name}": curve_figure(curve, unit) for curve in notable(found.curves)}


def curve_text(found: Diagnosis, key: str = "curve") -> dict[str, object]:
    """The words that go with ``curve_figures``."""
    titles = [(f"{key}_{curve.name}", curve_title(curve)) for curve in notable(found.curves)]
    return {"curves": titles, "left_out": left_out(found.curves)}


def curves_figure(curves: Sequence[AtlasCurve], unit: str) -> Figure:
    """All curves that say something, one below the other."""
    panels = [(curve_title(curve), curve_figure(curve, unit)) for curve in notable(curves)]
    height = sum(_TITLE + panel["height"] for _, panel in panels) + 2 * _MARGIN
    inside = height - 2 * _MARGIN
    data, layout, top = [], {"margin": {"t": _MARGIN, "b": _MARGIN, "l": 50, "r": 12}, "annotations": []}, inside
    for index, (title, panel) in enumerate(panels):
        number_of = "" if index == 0 else str(index + 1)
        bottom = top - _TITLE - panel["height"]
        ceiling = top - _TITLE - (_LEGEND if panel["layout"]["showlegend"] else 0)
        domain = {"domain": [(bottom + _BELOW) / inside, ceiling / inside]}
        layout[f"xaxis{number_of}"] = panel["layout"]["xaxis"] | {"anchor": f"y{number_of}"}
        layout[f"yaxis{number_of}"] = panel["layout"]["yaxis"] | {"anchor": f"x{number_of}"} | domain
        data += [trace | {"xaxis": f"x{number_of}", "yaxis": f"y{number_of}"} for trace in panel["data"]]
        layout["annotations"].append(
            note("<br>".join(wrap(title, _WIDTH)), 0.0, top / inside, xanchor="left", yanchor="top", align="left")
        )
        if panel["layout"]["showlegend"]:
            layout |= {"showlegend": True, "legend": panel["layout"]["legend"] | {"y": ceiling / inside}}
        top = bottom
    return {"data": data, "layout": layout, "height": height, "plain": True}
