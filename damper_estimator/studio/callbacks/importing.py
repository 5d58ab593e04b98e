"""Bench files: the guess, its correction in a form, a preview, and the import; and lists that follow new files."""

from dash import ALL, Dash, Input, Output, State, no_update
from dash.exceptions import PreventUpdate

from damper_estimator.errors import InputError
from damper_estimator.model import library_models
from damper_estimator.report import import_figures
from damper_estimator.report.theme import themed
from damper_estimator.studio import bench_form
from damper_estimator.studio.components import EMPTY
from damper_estimator.studio.folder import Folder
from damper_estimator.studio.sessions import Sessions

_COLUMN, _TURN = ({"type": kind, "index": ALL} for kind in ("bench-column", "bench-turn"))
_HEIGHT = 250  # pixels of a preview
_LISTS = ("recordings", "unseen", "models", "map", "bench-file")


def connect(app: Dash, sessions: Sessions) -> None:
    """The preview follows the form."""
    folder = sessions.folder

    @app.callback(
        Output("bench-form", "children"),
        Output("bench-guess", "data"),
        Output("bench-message", "children"),
        Output("bench", "hidden"),
        Input("bench-file", "value"),
        prevent_initial_call=True,
    )
    def guess(name):
        if not name:
            return "", None, "", True
        try:
            found = bench_form.guessed(folder, name)
        except InputError as error:
            return "", None, str(error), True
        return bench_form.form(found), bench_form.kept(found, name), "", False

    @app.callback(
        Output("bench-time", "figure"),
        Output("bench-velocity", "figure"),
        Output("bench-message", "children", allow_duplicate=True),
        Input(_COLUMN, "value"),
        Input(_TURN, "value"),
        Input("theme", "data"),
        State("bench-guess", "data"),
        prevent_initial_call=True,
    )
    def preview(chosen, turned, theme, data):
        if not data or not chosen or theme is None:
            raise PreventUpdate
        try:
            parts = bench_form.parts_of(folder, dict(data).get("file"), bench_form.corrected(data, chosen, turned))
        except InputError as error:
            return EMPTY, EMPTY, str(error)
        drawn = import_figures(parts, next(iter(parts[0].dampers)))
        for figure in drawn.values():
            figure["layout"]["height"] = _HEIGHT  # the form may still be hidden, and have no size of its own
        return themed(drawn["time"], theme), themed(drawn["velocity"], theme), ""

    _connect_import(app, folder)
    _connect_lists(app, folder)


def _connect_import(app: Dash, folder: Folder) -> None:
    @app.callback(
        Output("bench-message", "children", allow_duplicate=True),
        Output("added", "data", allow_duplicate=True),
        Input("bench-import", "n_clicks"),
        State(_COLUMN, "value"),
        State(_TURN, "value"),
        State("bench-guess", "data"),
        running=[(Output("bench-import", "disabled"), True, False)],
        prevent_initial_call=True,
    )
    def write(clicks, chosen, turned, data):
        if not clicks or not data:
            raise PreventUpdate
        try:
            file = dict(data).get("file")
            parts = bench_form.parts_of(folder, file, bench_form.corrected(data, chosen, turned))
            names = bench_form.imported(folder, parts)
        except (InputError, OSError) as error:
            return str(error), no_update
        return f"imported as {', '.join(names)}; choose it above under recordings", names


def _connect_lists(app: Dash, folder: Folder) -> None:
    @app.callback(
        *(Output(name, "options", allow_duplicate=True) for name in _LISTS),
        Output("listed", "data"),
        Input("notice", "n_intervals"),
        Input("added", "data"),
        State("listed", "data"),
        prevent_initial_call=True,
    )
    def notice(_, _added, listed):
        now = lists(folder)
        if now == listed:
            return *(no_update for _ in _LISTS), no_update
        return *(now[name] for name in _LISTS), now

    # Together, since the list drops a value that it does not offer yet.
    @app.callback(Output("bench-file", "options", allow_duplicate=True), Output("bench-file", "value"),
                  Input("added", "data"), prevent_initial_call=True)  # fmt: skip
    def show(added):
        offered = folder.bench_files()
        names = [name for name in added or [] if name in offered] if isinstance(added, list) else []
        if not names:
            raise PreventUpdate
        return offered, names[-1]


def lists(folder: Folder) -> dict[str, list[str]]:
    """What can be chosen from the folder now."""
    recordings = folder.recordings()
    models = [*folder.models(), *library_models()]
    values = (recordings, recordings, models, folder.maps(), folder.bench_files())
    return dict(zip(_LISTS, values, strict=True))
