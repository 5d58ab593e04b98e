"""The page's skeleton: what stands where. What is in it comes from ``callbacks``."""

from collections.abc import Sequence

from dash import dcc, html

from damper_estimator.effects.discovery import all_effects
from damper_estimator.model import library_models
from damper_estimator.studio.folder import Folder
from damper_estimator.studio.view import MOTIONS

TICK = 500  # ms between two looks at how far the work is
_GRAPH = {"displaylogo": False, "responsive": True, "modeBarButtons": [["toImage", "resetScale2d"]]}
_PLAIN = _GRAPH | {"displayModeBar": False}
_TABS = {"fails": "Where it fails", "learn": "What is missing", "change": "Model", "steps": "Steps", "save": "Save"}
_WAY = {
    "Compare": "shows measured and modelled force, linked over time, velocity, displacement and acceleration.",
    "Where it fails": "lists the regions of operation that carry the error; a click goes there.",
    "What is missing": "tries every physical effect on data that the model was not fitted to, and ranks them.",
    "Add": "puts an effect in and refits; the steps, down to the noise floor, can be undone.",
    "Save": "writes the model, the signal map and the reports, for the command line and the node.",
}
_TOOLS = {"zoom": "zoom", "pan": "pan", "select": "mark", "lasso": "lasso"}
EMPTY = {"data": [], "layout": {"xaxis": {"visible": False}, "yaxis": {"visible": False}}}


def layout(page: str, folder: Folder) -> html.Div:
    """The whole page for a session's id."""
    stores = {
        "page": page,
        "generation": 0,
        "drawn": None,  # generation, theme and opening that the figures show
        "scene": None,  # what the figure over time shows: generation, view, tried parameters, theme, tool
        "rebuilt": 0,
        "view": {},
        "hovered": "",
        "tried": None,
        "theme": None,
        "ended": 0,
        "dragged": None,
    }
    stores |= {f"told-{name}": stores[name] for name in ("generation", "rebuilt", "drawn")}
    return html.Div(
        [
            *(dcc.Store(id=name, data=value) for name, value in stores.items()),
            dcc.Interval(id="tick", interval=TICK),
            _header(folder),
            html.Details(
                [
                    html.Summary([html.Span("Data and models", id="opened"), html.Span(id="data-told")]),
                    html.Div(_chooser(folder), className="choices"),
                ],
                id="chooser",
                open=True,
            ),
            _guide(folder),
            html.Main([_left(), _right()], id="work", className="empty"),
        ],
        id="studio",
    )


def _header(folder: Folder) -> html.Header:
    return html.Header(
        [
            html.H1(["damper studio ", html.Small(str(folder.root))]),
            html.Progress(id="progress", max="1", value="0", hidden=True, **{"aria-label": "how much is done"}),
            html.Div(id="job", role="status", **{"aria-live": "polite"}),
            html.Div("The studio does not answer. Start it again, then load this page anew.", id="gone", role="alert"),
            html.Button("cancel", id="cancel", hidden=True),
            html.Button("undo", id="undo", disabled=True, title="Ctrl+Z"),
            html.Button("redo", id="redo", disabled=True, title="Ctrl+Y"),
            html.Button("◐", id="theme-button", **{"aria-label": "switch between light and dark"}),
        ]
    )


def _chooser(folder: Folder) -> list:
    recordings, maps = folder.recordings(), folder.maps()
    models = [*folder.models(), *library_models()]
    window = [_number("start", "from, s"), _number("stop", "to, s")]
    return [
        _labelled("recordings", _several("recordings", recordings, "what to look at"), "several"),
        _labelled("judge on", _several("unseen", recordings, "the last 40 % of each"), "several"),
        _labelled("models", _several("models", models, "the first is worked on"), "several"),
        _labelled("damper", dcc.Dropdown([], id="damper", placeholder="the first", clearable=True)),
        _labelled("signal map", dcc.Dropdown(maps, id="map", placeholder="default topics", clearable=True)),
        _labelled("window", html.Div(window, className="pair-of-numbers")),
        html.Button("Open", id="open", className="primary"),
        html.P("", id="open-told", className="told-here"),
    ]


def _guide(folder: Folder) -> html.Section:
    """What to do while nothing is open."""
    if not folder.recordings():
        missing = (
            f"There is no recording in {folder.root}. Put an .mcap file or a rosbag2 folder there, or start the studio "
            "on another folder, then load this page again."
        )
        way = "Files of a bench or a logger (CSV, text, MAT) become recordings with "
        return html.Section([html.H2(missing), html.P([way, html.Code("damper-estimator import"), "."])], id="guide")
    steps = [html.Li([html.B(name), f" {what}"]) for name, what in _WAY.items()]
    return html.Section([html.H2("Choose a recording and a model above, then open them."), html.Ol(steps)], id="guide")


def _left() -> html.Section:
    tools = dcc.RadioItems(
        [{"label": label, "value": tool} for tool, label in _TOOLS.items()], "zoom", id="tool", inline=True,
        className="choice",
    )  # fmt: skip
    bar = html.Div(
        [
            html.H2("Force over time"),
            html.Div(dcc.Dropdown([], id="recording", clearable=False), id="recording-place", hidden=True),
            tools,
            html.Button("all", id="all", title="the whole recording"),
            html.Button("unmark", id="unmark", title="take the marks away"),
        ],
        className="title",
    )
    told = [html.Span("", id="marked-told", className="hint"), html.P("", id="draw-told", className="told-here")]
    time = html.Section([bar, *told, _graph("time")], className="card")
    clouds = [html.Section([html.H2(f"Force over {m}"), _graph(m)], className="card") for m in MOTIONS]
    below = html.Div([html.Div(clouds, className="three"), _looked()], className="below")
    return html.Section([html.Div(id="measures"), time, below], id="left")


def _looked() -> html.Section:
    """What the effect that is pointed at would explain; it lies over the clouds, beside the list that is pointed at."""
    title = [html.H2("", id="looked-name"), html.Button("×", id="unlook", **{"aria-label": "close", "title": "Esc"})]
    parts = [_plain("explained"), html.Div(id="equation")]
    return html.Section(
        [html.Div(title, className="title"), html.Div(parts, className="two")],
        id="looked",
        className="card",
        hidden=True,
    )


def _graph(name: str) -> html.Div:
    config = _GRAPH | {"scrollZoom": True} if name == "time" else _PLAIN  # a bar would lie over the small figures
    graph = dcc.Graph(id={"type": "linked", "name": name}, figure=EMPTY, config=config, style={"height": "100%"})
    return html.Div(graph, className=f"figure {name}")


def _right() -> html.Section:
    panels = {"fails": _fails(), "learn": _learn(), "change": _change(), "steps": _steps(), "save": _save()}
    tabs = dcc.RadioItems(
        [{"label": label, "value": name} for name, label in _TABS.items()], "fails", id="tab", inline=True,
        className="choice tabs",
    )  # fmt: skip
    return html.Section(
        [
            tabs,
            *(
                html.Section(panel, id={"type": "panel", "name": name}, className="panel", hidden=name != "fails")
                for name, panel in panels.items()
            ),
        ],
        id="right",
    )


def _fails() -> list:
    return [
        html.Div(id="verdict"),
        html.Div(id="regions"),
        html.H2("Error over velocity and displacement"),
        _plain("error-map"),
        html.H2("Data quality"),
        html.Div(id="quality"),
    ]


def _learn() -> list:
    modes = [
        {"label": "both ways", "value": "both"},
        {"label": "parameters kept", "value": "kept"},
        {"label": "refitted", "value": "refit"},
    ]
    return [
        html.Div(
            [
                html.Button("Diagnose", id="diagnose", className="primary"),
                html.Button("Improve", id="improve", title="diagnose, add, refit, until nothing more is justified"),
                dcc.RadioItems(modes, "both", id="mode", inline=True, className="choice"),
            ],
            className="title",
        ),
        html.P("", id="learn-told", className="told-here"),
        html.Div(id="findings"),
        html.Div([_plain("ranking"), html.Div(id="candidates")], id="ranked", hidden=True),
    ]


def _change() -> list:
    effects = [name for name, own in all_effects().items() if own.kind not in ("channel", "path")]
    return [
        html.Div(
            [
                html.Button("Refit", id="refit", className="primary", title="identify the free parameters"),
                dcc.Dropdown(effects, id="effect", placeholder="another effect"),
                html.Button("Add", id="add-effect"),
            ],
            className="title",
        ),
        html.P("", id="change-told", className="told-here"),
        html.Div(id="parameters"),
    ]


def _steps() -> list:
    return [_plain("waterfall"), html.Div(id="steps"), html.P("", id="steps-told", className="told-here")]


def _save() -> list:
    kinds = {
        "model": "model",
        "map": "signal map",
        "comparison": "report: comparison",
        "diagnosis": "report: diagnosis",
    }
    return [
        dcc.RadioItems(
            [{"label": text, "value": kind} for kind, text in kinds.items()], "model", id="kind", className="choice"
        ),
        _labelled("name in the folder", dcc.Input(id="name", type="text", value="model.yaml", className="wide")),
        html.Button("Save", id="save", className="primary"),
        html.Button("Replace it", id="replace", hidden=True),
        html.P("", id="save-told", className="told-here"),
    ]


def _plain(name: str) -> html.Div:
    graph = dcc.Graph(id=name, figure=EMPTY, config=_PLAIN, style={"height": "100%"})
    return html.Div(graph, className=f"figure {name}")


def _labelled(label: str, piece: object, more: str = "") -> html.Div:
    parts = [html.Span(label, className="label"), piece]
    return html.Div(parts, className=f"field {more}", role="group", **{"aria-label": label})


def _several(name: str, choices: list[str], hint: str) -> dcc.Dropdown:
    return dcc.Dropdown(choices, id=name, multi=True, placeholder=hint)


def _number(name: str, hint: str) -> dcc.Input:
    return dcc.Input(id=name, type="number", min=0, placeholder=hint, debounce=True)


def names_of(models: Sequence, changed: bool) -> list[str]:
    """Names of the models on view; what has the same name is told apart, as is the model that is worked on."""
    names = [own.name for own in models]
    if changed:
        names[1] = f"{names[1]} as given"
    return [f"{name} ({names[:i].count(name) + 1})" if names.count(name) > 1 else name for i, name in enumerate(names)]
