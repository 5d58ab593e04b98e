"""The page of a running node: figures that roll on, what is frozen and saved, and its diagnosis."""

from datetime import datetime

from dash import ALL, ClientsideFunction, Dash, Input, Output, State, no_update
from dash.exceptions import PreventUpdate

from damper_estimator.diagnosis import MODES
from damper_estimator.errors import InputError
from damper_estimator.report.theme import DARK, LIGHT, themed
from damper_estimator.studio.callbacks.common import CHANGES
from damper_estimator.studio.live import Live
from damper_estimator.studio.live_panel import live_card, state_words
from damper_estimator.studio.session import Session
from damper_estimator.studio.sessions import Sessions

_FIGURE, _STATE = ({"type": f"live-{kind}", "damper": ALL} for kind in ("figure", "state"))


def connect(app: Dash, sessions: Sessions, live: Live) -> None:
    """Cards follow the dampers that the node estimates; figures follow the clock unless they are frozen."""
    app.clientside_callback(
        ClientsideFunction("studio", "freeze"),
        Output("live-tick", "disabled"),
        Output("freeze", "children"),
        Input("freeze", "n_clicks"),
        prevent_initial_call=True,
    )

    @app.callback(
        Output("live-dampers", "children"),
        Output("live-seconds", "children"),
        Input("live-tick", "n_intervals"),
        State(_FIGURE, "id"),
    )
    def cards(_, ids):
        names = sorted(live.states())
        held = live.held
        words = f"{held.get('seconds', 0.0):.0f} s, {held.get('messages', 0):.0f} messages in memory"
        words = words if live.running else "what listens to the node has ended; start the studio again"
        if not names or names == [entry["damper"] for entry in ids]:
            return no_update, words
        return [live_card(name) for name in names], words

    @app.callback(
        Output(_FIGURE, "figure"),
        Output(_STATE, "children"),
        Input("live-tick", "n_intervals"),
        State(_FIGURE, "id"),
        State("theme", "data"),
    )
    def roll(_, ids, theme):
        figures, states = live.figures(), live.states()
        names = [entry["damper"] for entry in ids]
        if not names or not set(names) <= set(figures):
            raise PreventUpdate
        theme = DARK if theme == DARK else LIGHT
        return [themed(figures[name], theme) for name in names], [state_words(states[name]) for name in names]

    _connect_saving(app, sessions, live)


def _connect_saving(app: Dash, sessions: Sessions, live: Live) -> None:
    @app.callback(
        Output("live-words", "children", allow_duplicate=True),
        Input("live-save", "n_clicks"),
        State("page", "data"),
        prevent_initial_call=True,
    )
    def save(_, page):
        try:
            name, count = saved(sessions.of(page), live)
        except InputError as error:
            return str(error)
        return f"saved {name}: {count} messages"

    @app.callback(
        *CHANGES,
        Output("live-words", "children", allow_duplicate=True),
        Output("studio", "data-sight", allow_duplicate=True),
        Input("live-diagnose", "n_clicks"),
        State("live-model", "value"),
        State("mode", "value"),
        State("page", "data"),
        prevent_initial_call=True,
    )
    def diagnose(_, model, mode, page):
        try:
            session = sessions.of(page)
            if not model:
                raise InputError("choose the model to diagnose")
            name, count = saved(session, live)
            session.open_and_diagnose(name, str(model), mode if mode in MODES else MODES[0])
        except InputError as error:
            return no_update, no_update, str(error), no_update
        return session.generation, session.rebuilt, f"saved {name}: {count} messages; diagnosing it", "corners"


def saved(session: Session, live: Live) -> tuple[str, int]:
    """Name and number of messages of a recording of the last minutes.

    Raises:
        InputError: where nothing came, or it cannot be written.
    """
    stem = f"live_{datetime.now().astimezone():%Y-%m-%d_%H%M%S}"
    names = (f"{stem}.mcap", *(f"{stem}_{number}.mcap" for number in range(2, 100)))  # several in one second
    name = next(name for name in names if not session.folder.path(name).exists())
    return name, live.save(session.folder.target(name, ".mcap", False))
