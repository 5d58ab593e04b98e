"""Choosing recordings, damper, map and models."""

from dash import Dash, Input, Output, State, no_update

from damper_estimator.errors import InputError
from damper_estimator.studio.callbacks.common import CHANGES, answered, opened
from damper_estimator.studio.sessions import Sessions
from damper_estimator.studio.stage import Choice, dampers_in


def connect(app: Dash, sessions: Sessions) -> None:
    """Dampers follow the recordings; Open reads."""

    @app.callback(
        Output("damper", "options"),
        Output("open-message", "children", allow_duplicate=True),
        Input("recordings", "value"),
        Input("map", "value"),
        State("page", "data"),
        prevent_initial_call=True,
    )
    def dampers(recordings, signals, page):
        try:
            return dampers_in(sessions.of(page).folder, recordings or [], signals or ""), ""
        except InputError as error:
            return [], str(error)

    @app.callback(
        *CHANGES,
        Output("open-message", "children", allow_duplicate=True),
        Input("open", "n_clicks"),
        State("recordings", "value"),
        State("unseen", "value"),
        State("damper", "value"),
        State("map", "value"),
        State("models", "value"),
        State("start", "value"),
        State("stop", "value"),
        State("page", "data"),
        prevent_initial_call=True,
    )
    def open_(_, recordings, unseen, damper, signals, models, start, stop, page):
        choice = Choice(tuple(recordings or ()), tuple(unseen or ()), damper or "", signals or "", start, stop)
        return answered(sessions, page, lambda session: session.open(choice, list(models or ())))

    _connect_opened(app, sessions)


def _connect_opened(app: Dash, sessions: Sessions) -> None:
    """What is open."""

    @app.callback(
        Output("chooser", "open"),
        Output("opened", "children"),
        Output("recording", "options"),
        Output("recording", "value"),
        Output("recording-place", "hidden"),
        Output("work", "className"),
        Output("view", "data", allow_duplicate=True),
        Input("generation", "data"),
        State("page", "data"),
        State("opened", "children"),
        State("view", "data"),
        prevent_initial_call="initial_duplicate",
    )
    def show_choice(_, page, before, view):
        session = opened(sessions, page)
        if session is None:
            return True, "Data and models", [], None, True, "empty", no_update
        stage = session.stage
        names = " and ".join(model.name for model in (session.history.versions[0].step.model, *session.others))
        summary = f"{', '.join(stage.names)} · {stage.damper} · {names}"
        options = [{"label": name, "value": i} for i, name in enumerate(stage.names)]
        if summary == before:
            return (no_update,) * 7
        shown = view.get("recording", 0) if view.get("opened") == session.opened else 0
        view = no_update
        if shown >= len(options):  # an address may name a recording that is not there any more
            shown, view = 0, {"opened": session.opened}
        return False, summary, options, shown, len(options) < 2, "", view
