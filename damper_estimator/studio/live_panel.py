"""The page's part that shows a running node."""

from dash import dcc, html

from damper_estimator.model import library_models
from damper_estimator.studio.components import EMPTY, PLAIN
from damper_estimator.studio.folder import Folder
from damper_estimator.studio.live import Live

TICK = 500  # ms between two pictures
_LEVELS = ("", "warned", "failed", "failed")


def live_section(folder: Folder, live: Live | None) -> html.Section:
    """Its place; empty where the studio does not listen to a node."""
    models = [*folder.models(), *library_models()]
    buttons = [
        html.Button("Freeze", id="freeze", title="stop the figures; messages are still stored"),
        html.Button("Save the last minutes", id="live-save", title="as a recording in the folder"),
        dcc.Dropdown(models, id="live-model", placeholder="model to diagnose"),
        html.Button("Save and diagnose", id="live-diagnose", className="primary"),
    ]
    title = html.Div([html.H2("Live"), html.Span("", id="live-seconds", className="hint"), *buttons], className="title")
    return html.Section(
        [
            title,
            html.P("", id="live-words", className="message"),
            html.Div("waiting for a node ...", id="live-dampers"),
            dcc.Interval(id="live-tick", interval=TICK, disabled=live is None),
        ],
        id="live",
        hidden=live is None,
    )


def live_card(name: str) -> html.Section:
    """One damper: its state in words, force and residual."""
    state = html.Span("", id={"type": "live-state", "damper": name}, className="state")
    graph = dcc.Graph(id={"type": "live-figure", "damper": name}, figure=EMPTY, config=PLAIN, style={"height": "100%"})
    title = html.Div([html.H2(name), state], className="title")
    return html.Section([title, html.Div(graph, className="figure")], className="card")


def state_words(state: tuple[str, int, str, bool]) -> list:
    """What the node says of a damper; a drift alarm first."""
    status, level, message, alarm = state
    words = [html.B("drift alarm ", className="failed")] if alarm else []
    shown = html.Span(message, className=_LEVELS[min(level, 3)])
    return [*words, html.B(f"{status or 'no estimate yet'} "), shown]
