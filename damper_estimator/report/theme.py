"""Colours, fonts and axes of every figure: one Plotly template per theme, for reports, studio and notebooks.

Figures name colours by role, ``@error``, so that one figure serves both themes. Lines and marks have the colours of
Okabe and Ito, which colour-blind readers can distinguish.
"""

from collections.abc import Mapping
from functools import cache
from importlib import resources

LIGHT, DARK = "light", "dark"
FONT = 'system-ui, "Segoe UI", "DejaVu Sans", sans-serif'
COLOURS: Mapping[str, Mapping[str, str]] = {
    LIGHT: {
        "page": "#f5f6f7", "card": "#fff", "ink": "#1b1e23", "soft": "#5d6570", "line": "#dcdfe3", "error": "#d55e00",
        "samples": "#9aa3ad", "measured": "#1b1e23", "model0": "#0072b2", "model1": "#d55e00", "model2": "#009e73",
        "model3": "#cc79a7", "model4": "#e69f00", "bad": "#a33f00",
    },
    DARK: {
        "page": "#14171b", "card": "#1d2126", "ink": "#e8eaed", "soft": "#9aa3ad", "line": "#343a42",
        "error": "#e69f00", "samples": "#6b7480", "measured": "#e8eaed", "model0": "#56b4e9", "model1": "#e69f00",
        "model2": "#009e73", "model3": "#cc79a7", "model4": "#f0e442", "bad": "#f0b060",
    },
}  # fmt: skip
_MODEL_COLOURS = 5
_CLEAR = "rgba(0,0,0,0)"


def model_colour(index: int) -> str:
    """Colour of the model with this index, by role."""
    return f"@model{index % _MODEL_COLOURS}"


@cache
def template(theme: str) -> dict[str, object]:
    """The Plotly template of a theme."""
    colours = COLOURS[theme]
    axis = {
        "gridcolor": colours["line"], "zerolinecolor": colours["samples"], "linecolor": colours["line"],
        "automargin": True, "title": {"standoff": 6},
    }  # fmt: skip
    colour_bar = {"thickness": 12, "outlinewidth": 0, "title": {"side": "right"}}
    layout = {
        "paper_bgcolor": _CLEAR,
        "plot_bgcolor": _CLEAR,
        "font": {"color": colours["ink"], "size": 12, "family": FONT},
        "colorway": [colours[f"model{index}"] for index in range(_MODEL_COLOURS)],
        "margin": {"l": 50, "r": 14, "t": 24, "b": 40},
        "hovermode": "closest",
        "showlegend": False,
        "legend": {
            "itemsizing": "constant", "orientation": "h", "x": 0, "xanchor": "left", "y": 1, "yanchor": "bottom",
            "bgcolor": _CLEAR,
        },
        "modebar": {"bgcolor": _CLEAR, "color": colours["samples"], "activecolor": colours["ink"]},
        "hoverlabel": {"bgcolor": colours["card"], "font": {"color": colours["ink"]}, "align": "left"},
        "coloraxis": {"colorbar": colour_bar},
        "xaxis": axis,
        "yaxis": axis,
    }  # fmt: skip
    return {"layout": layout, "data": {"heatmap": [{"colorscale": "Cividis", "colorbar": colour_bar}]}}


def themed(figure: Mapping, theme: str) -> dict[str, object]:
    """The figure with the theme's template, and the theme's colours where it names roles."""
    colours = COLOURS[theme]
    height = {"height": figure["height"]} if "height" in figure else {}
    layout = {"template": template(theme)} | height | _coloured(figure.get("layout", {}), colours)
    return {"data": _coloured(figure["data"], colours), "layout": layout}


def height_style(figure: Mapping) -> dict[str, str]:
    """The style of an element that is as tall as its figure, whose height grows with its rows."""
    return {"height": f"{figure['height']}px"}


def themes() -> dict[str, object]:
    """Colours by role and the template of each theme, for the pages' script."""
    return {name: {"colours": colours, "template": template(name)} for name, colours in COLOURS.items()}


@cache
def variables() -> str:
    """The colours and the font as variables of a style sheet."""

    def block(selector: str, theme: str) -> str:
        colours = "".join(f"--{role}:{colour}; " for role, colour in COLOURS[theme].items())
        return f"{selector} {{ {colours}color-scheme:{theme}; }}\n"

    return block(":root", LIGHT) + block(":root.dark", DARK) + f":root {{ --font:{FONT}; }}\n"


@cache
def styles() -> str:
    """The style sheets that the studio shares with the reports' pages."""
    folder = resources.files("damper_estimator.report")
    sheets = (folder.joinpath(name).read_text(encoding="utf-8") for name in ("page.css", "diagnosis.css"))
    return variables() + "\n".join(sheets)


def _coloured(value: object, colours: Mapping[str, str]) -> object:
    if isinstance(value, str):
        return colours.get(value[1:], value) if value.startswith("@") else value
    if isinstance(value, Mapping):
        return {key: _coloured(inner, colours) for key, inner in value.items()}
    return [_coloured(inner, colours) for inner in value] if isinstance(value, list | tuple) else value
