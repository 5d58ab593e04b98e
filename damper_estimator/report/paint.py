"""Gives the report's figures the colours of a theme; the colours are those of the report's own style sheet."""

import re
from collections.abc import Mapping
from functools import cache
from importlib import resources

LIGHT, DARK = "light", "dark"
_FONT = 'system-ui, "Segoe UI", "DejaVu Sans", sans-serif'


@cache
def styles() -> str:
    """The style sheets of the report's pages."""
    folder = resources.files("damper_estimator.report")
    return "\n".join(folder.joinpath(name).read_text(encoding="utf-8") for name in ("page.css", "diagnosis.css"))


@cache
def palette(theme: str) -> dict[str, str]:
    """Colours by role, such as ``ink``, ``error``, ``model0``."""
    selector = r":root\.dark" if theme == DARK else ":root"
    block = re.search(selector + r" \{([^}]*)\}", styles()).group(1)
    return dict(re.findall(r"--(\w+):(#[0-9a-fA-F]+)", block))


def painted(figure: Mapping, theme: str) -> dict[str, object]:
    """A figure for the page: ``@role`` replaced by the theme's colour, axes and fonts as everywhere."""
    own = palette(theme)
    layout = _coloured(figure.get("layout", {}), own)
    axis = {"gridcolor": own["line"], "zerolinecolor": own["samples"], "linecolor": own["line"], "automargin": True}
    axes = {name: axis | value for name, value in layout.items() if re.match("[xy]axis", name)}
    height = {"height": figure["height"]} if "height" in figure else {}
    return {"data": _coloured(figure["data"], own), "layout": _base(own) | height | layout | axes}


def as_tall_as(figure: Mapping) -> dict[str, str]:
    """The style of a figure that brings its height with it, as it grows with its rows."""
    return {"height": f"{figure['height']}px"}


def _base(own: Mapping[str, str]) -> dict[str, object]:
    clear = "rgba(0,0,0,0)"
    return {
        "paper_bgcolor": clear,
        "plot_bgcolor": clear,
        "font": {"color": own["ink"], "size": 12, "family": _FONT},
        "margin": {"l": 50, "r": 14, "t": 24, "b": 40},
        "hovermode": "closest",
        "showlegend": False,
        "legend": {
            "itemsizing": "constant", "orientation": "h", "x": 0, "xanchor": "left", "y": 1, "yanchor": "bottom",
            "bgcolor": clear,
        },
        "modebar": {"bgcolor": clear, "color": own["samples"], "activecolor": own["ink"]},
        "hoverlabel": {"bgcolor": own["card"], "font": {"color": own["ink"]}, "align": "left"},
    }  # fmt: skip


def _coloured(value: object, own: Mapping[str, str]) -> object:
    if isinstance(value, str):
        return own[value[1:]] if value.startswith("@") else value
    if isinstance(value, Mapping):
        return {key: _coloured(inner, own) for key, inner in value.items()}
    return [_coloured(inner, own) for inner in value] if isinstance(value, list | tuple) else value
