"""The page's skeleton: what stands where. What is in it comes from ``callbacks``."""

from collections.abc import Sequence

from dash import dcc, html

from damper_estimator.effects.discovery import all_effects
from damper_estimator.studio.choosing import chooser, guide
from damper_estimator.studio.components import EMPTY, PLAIN, files, labelled, number, plain
from damper_estimator.studio.corner_cards import corners_section
from damper_estimator.studio.folder import Folder
from damper_estimator.studio.live import Live
from damper_estimator.studio.live_panel import live_section
from damper_estimator.studio.marked_bar import marked_bar
from damper_estimator.studio.saving import KINDS
from damper_estimator.studio.view import MOTIONS
from damper_estimator.workflows import RIDE_DAMPERS, RIG, library_rigs

TICK = 500  # ms between two looks at how far the work is
NOTICE = 5000  # ms between two looks for new files
TABS = {
    "fails": "Where it fails",
    "learn": "What is missing",
    "change": "Model",
    "steps": "Steps",
    "tests": "Tests",
    "save": "Save",
}
_TOOLS = {"zoom": "zoom", "pan": "pan", "select": "mark", "lasso": "lasso", "cursor": "cursors"}
_GONE = "The studio does not answer. Start it again on the same port, and this page goes on where it is."
_LOCKED = "The studio was started again with another token. Open the address that it printed; your steps are kept."


def layout(folder: Folder, live: Live | None = None) -> html.Div:
    """The whole page; it gets its session when it has arrived in a browser."""
    stores = {
        "page": None,
        "address": None,  # what the page's URL names when it arrives, and its browser tab
        "place": None,  # what the URL is to name of the session
        "added": None,  # files that were dropped on the page or imported
        "carded": None,  # what the cards show
        "listed": None,  # what the lists of files show
        "bench-guess": None,
        "lost": 0,  # how often the server did not know the page
        "generation": 0,
        "drawn": None,  # generation, theme and opening that the figures show
        "scene": None,  # what the figure over time shows: generation, view, preview parameters, theme, tool
        "rebuilt": 0,
        "view": {},
        "hovered": "",
        "preview": None,
        "theme": None,
        "ended": 0,
        "dragged": None,
    }
    stores |= {f"reported-{name}": stores[name] for name in ("generation", "rebuilt", "drawn")}
    return html.Div(
        [
            *(dcc.Store(id=name, data=value) for name, value in stores.items()),
            dcc.Interval(id="tick", interval=TICK),
            dcc.Interval(id="notice", interval=NOTICE),
            _header(folder),
            html.Details(
                [
                    html.Summary([html.Span("Data and models", id="opened"), html.Span(id="data-summary")]),
                    html.Div(chooser(folder), className="choices"),
                ],
                id="chooser",
                open=True,
            ),
            live_section(folder, live),
            guide(folder),
            corners_section(),
            html.Main([_left(), _right()], id="work", className="empty"),
        ],
        id="studio",
        **{"data-sight": "depth"},
    )


def _header(folder: Folder) -> html.Header:
    return html.Header(
        [
            html.H1(["damper studio ", html.Small(str(folder.root))]),
            html.Progress(id="progress", max="1", value="0", hidden=True, **{"aria-label": "how much is done"}),
            html.Div(id="job", role="status", **{"aria-live": "polite"}),
            html.Div(_GONE, id="gone", role="alert"),
            html.Div(_LOCKED, id="locked", role="alert"),
            html.Div("", id="unkept", role="alert"),
            html.Button("cancel", id="cancel", hidden=True),
            html.Button("all dampers", id="overview", hidden=True, title="every damper of the recordings at once"),
            html.Button("undo", id="undo", disabled=True, title="the last step of the model: Ctrl+Z"),
            html.Button("redo", id="redo", disabled=True, title="the step that was undone: Ctrl+Y or Ctrl+Shift+Z"),
            html.Button("◐", id="theme-button", **{"aria-label": "switch between light and dark"}),
        ]
    )


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
            html.Div(dcc.Dropdown([], id="traces", multi=True, placeholder="further traces"), id="traces-place"),
            html.Button("back", id="back", title="the stretch that was on view before"),
            html.Button("all", id="all", title="the whole recording"),
            html.Button("CSV", id="export-view", title="the samples on view as a table, all of them"),
        ],
        className="title",
    )
    notices = [*marked_bar(), html.P("", id="draw-message", className="message")]
    time = html.Section([bar, *notices, html.Div(id="cursor-values"), _graph("time")], className="card")
    clouds = [html.Section([html.H2(f"Force over {m}"), _graph(m)], className="card") for m in MOTIONS]
    below = html.Div([html.Div(clouds, className="three"), _looked()], className="below")
    return html.Section([html.Div(id="measures"), time, below], id="left")


def _looked() -> html.Section:
    """What the effect under the pointer would explain; it covers the clouds, next to the list of effects."""
    title = [html.H2("", id="looked-name"), html.Button("×", id="unlook", **{"aria-label": "close", "title": "Esc"})]
    parts = [plain("explained"), html.Div(id="equation")]
    return html.Section(
        [html.Div(title, className="title"), html.Div(parts, className="two")],
        id="looked",
        className="card",
        hidden=True,
    )


def _graph(name: str) -> html.Div:
    config = PLAIN | {"scrollZoom": name == "time"}  # a bar of tools would lie over the small figures
    graph = dcc.Graph(id={"type": "linked", "name": name}, figure=EMPTY, config=config, style={"height": "100%"})
    return html.Div([graph, files()], className=f"figure with-files {name}")


def _right() -> html.Section:
    panels = {
        "fails": _fails(),
        "learn": _learn(),
        "change": _change(),
        "steps": _steps(),
        "tests": _tests(),
        "save": _save(),
    }
    tabs = dcc.RadioItems(
        [{"label": label, "value": name} for name, label in TABS.items()], "fails", id="tab", inline=True,
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
        plain("error-map"),
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
        html.P("", id="learn-message", className="message"),
        html.Div(id="findings"),
        html.Div(
            [
                html.H2("What the error depends on"),
                plain("atlas"),
                html.H2("What the model lacks, curve by curve"),
                plain("curves"),
                html.P(id="curves-left-out", className="hint"),
                html.H2("What could explain it"),
                plain("ranking"),
                html.Div(id="candidates"),
            ],
            id="ranked",
            hidden=True,
        ),
    ]


def _change() -> list:
    effects = [name for name, effect in all_effects().items() if effect.kind not in ("channel", "path")]
    return [
        html.Div(
            [
                html.Button("Refit", id="refit", className="primary", title="identify the free parameters"),
                dcc.Dropdown(effects, id="effect", placeholder="another effect"),
                html.Button("Add", id="add-effect"),
            ],
            className="title",
        ),
        html.P("", id="change-message", className="message"),
        html.Div(id="parameters"),
    ]


def _steps() -> list:
    return [plain("waterfall"), html.Div(id="steps"), html.P("", id="steps-message", className="message")]


def _tests() -> list:
    return [
        html.H2("Characteristic diagrams"),
        html.P("The cycles of the open recordings, averaged, and the types of their patterns.", className="hint"),
        html.Button("Characterise", id="characterize"),
        html.H2("The next test"),
        labelled("for", dcc.Dropdown([], id="aim", clearable=False)),
        labelled("on the rig", dcc.Dropdown(library_rigs(), RIG, id="rig", clearable=False)),
        labelled("minutes", number("minutes", "the shortest that decides, at most 10")),
        html.Button("Plan", id="plan", className="primary"),
        html.H2("Simulated ride"),
        html.P(
            "Feed-forward of the current on a simulated damper: a model of this structure, identified there, against "
            "a look-up table and a passive damper.",
            className="hint",
        ),
        labelled("on the damper", dcc.Dropdown(list(RIDE_DAMPERS), RIDE_DAMPERS[0], id="ride-damper", clearable=False)),
        labelled("seconds per road", dcc.Input(id="ride-seconds", type="number", min=5, max=120, value=12)),
        html.Button("Ride", id="ride"),
        html.P("", id="tests-message", className="message"),
        html.Div(id="tests-done"),
    ]


def _save() -> list:
    return [
        dcc.RadioItems(
            [{"label": file_kind.label, "value": kind} for kind, file_kind in KINDS.items()],
            "model",
            id="kind",
            className="choice",
        ),
        labelled("name in the folder", dcc.Input(id="name", type="text", value="", className="wide")),
        html.Button("Save", id="save", className="primary"),
        html.Button("Replace it", id="replace", hidden=True),
        html.P("", id="save-message", className="message"),
    ]


def names_of(models: Sequence, changed: bool) -> list[str]:
    """Names of the models on view; models of the same name get a suffix, as does the model that is edited."""
    names = [model.name for model in models]
    if changed:
        names[1] = f"{names[1]} as given"
    return [f"{name} ({names[:i].count(name) + 1})" if names.count(name) > 1 else name for i, name in enumerate(names)]
