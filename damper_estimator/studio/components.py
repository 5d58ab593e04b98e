"""Pieces that the parts of the page are made of."""

from dash import dcc, html

PLAIN = {"displaylogo": False, "responsive": True, "displayModeBar": False}
EMPTY = {"data": [], "layout": {"xaxis": {"visible": False}, "yaxis": {"visible": False}}}


def plain(name: str) -> html.Div:
    """A figure without a bar of tools."""
    graph = dcc.Graph(id=name, figure=EMPTY, config=PLAIN, style={"height": "100%"})
    return html.Div([graph, files()], className=f"figure with-files {name}")


def files() -> html.Details:
    """The menu that writes a figure to a file; the report's own script answers it."""
    buttons = [html.Button(kind.upper(), type="button", **{"data-save": kind}) for kind in ("png", "svg", "csv")]
    summary = html.Summary("⤓", title="this figure as a file", **{"aria-label": "this figure as a file"})
    return html.Details([summary, html.Span(buttons)], className="files")


def labelled(label: str, piece: object, more: str = "") -> html.Div:
    """A piece with a label above it."""
    parts = [html.Span(label, className="label"), piece]
    return html.Div(parts, className=f"field {more}", role="group", **{"aria-label": label})


def several(name: str, choices: list[str], hint: str) -> dcc.Dropdown:
    """A list of which several can be chosen."""
    return dcc.Dropdown(choices, id=name, multi=True, placeholder=hint)


def number(name: str, hint: str) -> dcc.Input:
    """A field for a number."""
    return dcc.Input(id=name, type="number", min=0, placeholder=hint, debounce=True)
