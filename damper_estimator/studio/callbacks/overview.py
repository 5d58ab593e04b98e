"""All dampers at once: one card each, what can be done with all of them, and the way to one in depth."""

from dash import ALL, ClientsideFunction, Dash, Input, Output, State, ctx, no_update
from dash.exceptions import PreventUpdate

from damper_estimator.diagnosis import MODES
from damper_estimator.errors import InputError
from damper_estimator.studio.callbacks.common import CHANGES, answered, clicked, opened
from damper_estimator.studio.corner_cards import corner_cards
from damper_estimator.studio.corners import TASKS
from damper_estimator.studio.sessions import Sessions

_OPEN = {"type": "corner", "damper": ALL}


def connect(app: Dash, sessions: Sessions) -> None:
    """The overview replaces the figures of one damper; a button at the top leads there, a card back."""
    app.clientside_callback(
        ClientsideFunction("studio", "overview"),
        Output("studio", "data-sight"),
        Input("overview", "n_clicks"),
        Input(_OPEN, "n_clicks"),
        Input("open", "n_clicks"),
        State("studio", "data-sight"),
    )

    @app.callback(
        *CHANGES,
        Output("corners-message", "children", allow_duplicate=True),
        Input("overview", "n_clicks"),
        *(Input(f"{kind}-all", "n_clicks") for kind in TASKS),
        State("mode", "value"),
        State("page", "data"),
        prevent_initial_call=True,
    )
    def begin(_overview, _compare, _diagnose, _improve, mode, page):
        session, cause = opened(sessions, page), ctx.triggered_id
        if session is None or (cause == "overview" and (session.corners or session.busy)):
            raise PreventUpdate
        kind = "compare" if cause == "overview" else cause.removesuffix("-all")
        return answered(sessions, page, lambda session: session.work_on_all(kind, mode if mode in MODES else MODES[0]))

    @app.callback(
        *CHANGES,
        Output("corners-message", "children", allow_duplicate=True),
        Input("ended", "data"),
        State("studio", "data-sight"),
        State("page", "data"),
        prevent_initial_call=True,
    )
    def begin_as_addressed(_, sight, page):
        session = opened(sessions, page)
        if session is None or sight != "corners" or session.job.name != "opening" or session.busy or session.corners:
            raise PreventUpdate
        return answered(sessions, page, lambda session: session.work_on_all("compare", MODES[0]))

    _connect_one(app, sessions)
    _connect_shown(app, sessions)


def _connect_one(app: Dash, sessions: Sessions) -> None:
    """The way to one damper, and the files of all."""

    @app.callback(
        *CHANGES,
        Output("corners-message", "children", allow_duplicate=True),
        Input(_OPEN, "n_clicks"),
        State("page", "data"),
        prevent_initial_call=True,
    )
    def enter(_clicks, page):
        damper = clicked()["damper"]
        return answered(sessions, page, lambda session: session.open_damper(damper))

    @app.callback(
        Output("corners-message", "children", allow_duplicate=True),
        Input("save-all", "n_clicks"),
        State("page", "data"),
        prevent_initial_call=True,
    )
    def save(_, page):
        try:
            return sessions.of(page).save_all()
        except (InputError, OSError) as error:
            return str(error)


def _connect_shown(app: Dash, sessions: Sessions) -> None:
    @app.callback(
        Output("corner-cards", "children"),
        Output("overview", "hidden"),
        Output("save-all", "disabled"),
        Input("generation", "data"),
        State("page", "data"),
    )
    def show(_, page):
        session = opened(sessions, page)
        if session is None:
            return "", True, True
        several = len(session.stage.signal_map.dampers) > 1
        if not session.corners:
            return "The dampers are compared when this page is opened.", not several, True
        improved = any(history.at for history in session.histories().values())
        return corner_cards(session), not several if several else no_update, not improved
