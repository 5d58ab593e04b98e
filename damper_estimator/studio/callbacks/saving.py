"""Saving the model, the signal map and the reports into the studio's folder; nothing is replaced unasked."""

from pathlib import Path

from dash import Dash, Input, Output, State, ctx, html

from damper_estimator.errors import InputError
from damper_estimator.studio.callbacks.common import opened
from damper_estimator.studio.folder import Taken
from damper_estimator.studio.saving import KINDS
from damper_estimator.studio.sessions import Sessions


def connect(app: Dash, sessions: Sessions) -> None:
    """The name follows what is saved; a second button appears where it would replace a file."""

    @app.callback(Output("name", "value"), Input("kind", "value"), State("name", "value"))
    def name(kind, before):
        suffix = KINDS[kind].suffix if kind in KINDS else ""
        return before if before and Path(before).suffix == suffix else f"{kind}{suffix}"

    @app.callback(
        Output("save-told", "children"),
        Output("replace", "hidden"),
        Input("save", "n_clicks"),
        Input("replace", "n_clicks"),
        Input("name", "value"),
        State("kind", "value"),
        State("page", "data"),
        prevent_initial_call=True,
    )
    def save(_save, _replace, name, kind, page):
        session = opened(sessions, page)
        if ctx.triggered_id == "name":
            return "", True
        try:
            if session is None or kind not in KINDS:
                raise InputError("open a recording and a model first; there is nothing to save yet")
            KINDS[kind].write(
                session, session.folder.target(name or "", KINDS[kind].suffix, ctx.triggered_id == "replace")
            )
            if kind == "model":
                session.saved(name)
        except Taken as taken:
            return str(taken), False
        except (InputError, OSError) as error:
            return str(error), True
        return html.Span(f"saved {name}", className="good"), True
