"""What to open: recordings, models, files from elsewhere, and what to do while nothing is open."""

from dash import dcc, html

from damper_estimator.model import library_models
from damper_estimator.studio.components import labelled, number, plain, several
from damper_estimator.studio.folder import Folder

_WAY = {
    "Compare": "shows measured and modelled force, linked over time, velocity, displacement and acceleration.",
    "Where it fails": "lists the regions of operation that carry the error; a click goes there.",
    "What is missing": "tries every physical effect on data that the model was not fitted to, and ranks them.",
    "Add": "puts an effect in and refits; the steps, down to the noise floor, can be undone.",
    "Save": "writes the model, the signal map and the reports, for the command line and the node.",
}


def chooser(folder: Folder) -> list:
    """What to open."""
    recordings, maps = folder.recordings(), folder.maps()
    models = [*folder.models(), *library_models()]
    window = [number("start", "from, s"), number("stop", "to, s")]
    return [
        labelled("recordings", several("recordings", recordings, "what to look at"), "several"),
        labelled("judge on", several("unseen", recordings, "40 % of each"), "several"),
        labelled("models", several("models", models, "the first is worked on"), "several"),
        labelled("damper", dcc.Dropdown([], id="damper", placeholder="the first", clearable=True)),
        labelled("signal map", dcc.Dropdown(maps, id="map", placeholder="default topics", clearable=True)),
        labelled("window", html.Div(window, className="pair-of-numbers")),
        html.Button("Open", id="open", className="primary"),
        html.Div(_taking(folder), className="taking"),
        html.Details(
            [
                html.Summary("Library: recordings and models at a glance"),
                dcc.Input(id="search", type="search", placeholder="search: name, effect, channel", className="wide"),
                html.Div("looking ...", id="cards"),
            ],
            id="library",
        ),
        html.Div(id="earlier"),
        html.P("", id="open-message", className="message"),
    ]


def _taking(folder: Folder) -> list:
    """Files from elsewhere, and bench files that become recordings."""
    files = dcc.Dropdown(folder.bench_files(), id="bench-file", placeholder="a CSV, text or MAT file", clearable=True)
    figures = [plain("bench-time"), plain("bench-velocity")]
    form = [
        html.Div([html.Div(id="bench-form"), html.Button("Import", id="bench-import", className="primary")]),
        html.Div(figures),
    ]
    return [
        html.Div(
            [
                html.Button("Add files ...", id="add-files", title="recordings, bench files, models and maps"),
                html.Button("Add a folder ...", id="add-folder", title="a rosbag2 folder"),
                html.Span("or drop them on the page: mcap, rosbag2 (folder or zip), CSV, text, MAT", className="hint"),
                html.Span("", id="upload-message", role="status"),
            ],
            className="title",
        ),
        labelled("bench file to recording", files),
        html.P("", id="bench-message", className="message"),
        html.Section(form, id="bench", hidden=True),
    ]


def guide(folder: Folder) -> html.Section:
    """What to do while nothing is open."""
    if not folder.recordings():
        missing = (
            f"There is no recording in {folder.root}. Put an .mcap file or a rosbag2 folder there, or drop it on this "
            "page."
        )
        way = "Bench and logger files (CSV, text, MAT) can be dropped as well: they become recordings above, or with "
        command = html.Code("damper-estimator import --guess")
        return html.Section([html.H2(missing), html.P([way, command, "."])], id="guide")
    steps = [html.Li([html.B(name), f" {what}"]) for name, what in _WAY.items()]
    return html.Section([html.H2("Choose a recording and a model above, then open them."), html.Ol(steps)], id="guide")
