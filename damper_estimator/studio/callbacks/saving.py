"""Saving the model, the map, reports and exports into the studio's folder; nothing is replaced without asking."""

from pathlib import Path

from dash import Dash, Input, Output, State, ctx, html, no_update

from damper_estimator.errors import InputError
from damper_estimator.model import library_models
from damper_estimator.studio.callbacks.common import opened
from damper_estimator.studio.folder import Taken
from damper_estimator.studio.saving import KINDS, save
from damper_estimator.studio.sessions import Sessions


def connect(app: Dash, sessions: Sessions) -> None:
    """The name follows what is saved; a second button appears where it would replace a file."""

    @app.callback(Output("name", "value"), Input("kind", "value"), State("name", "value"))
    def name(kind, before):
        chosen = KINDS.get(kind)
        # A name that the user gave stays where it suits; one that was proposed follows the kind.
        proposed = not before or before in {f"{other.stem}{other.suffix}" for other in KINDS.values()}
        if chosen is None or (not proposed and Path(before).suffix == chosen.suffix):
            return no_update
        return f"{chosen.stem}{chosen.suffix}"

    @app.callback(
        Output("save-message", "children"),
        Output("replace", "hidden"),
        Output("models", "options"),
        Output("map", "options"),
        Input("save", "n_clicks"),
        Input("replace", "n_clicks"),
        Input("name", "n_submit"),
        Input("name", "value"),
        State("kind", "value"),
        State("page", "data"),
        running=[(Output("save", "disabled"), True, False)],
        prevent_initial_call=True,
    )
    def write(_save, _replace, _enter, name, kind, page):
        if [trigger["prop_id"] for trigger in ctx.triggered] == ["name.value"]:
            return "", True, no_update, no_update
        session = opened(sessions, page)
        try:
            if session is None:
                raise InputError("open a recording and a model first; there is nothing to save yet")
            said = save(session, kind, str(name or ""), ctx.triggered_id == "replace")
        except Taken as taken:
            return str(taken), False, no_update, no_update
        except (InputError, OSError) as error:
            return str(error), True, no_update, no_update
        folder = session.folder
        saved = html.Span(f"saved {name}: {said}", className="good")
        return saved, True, [*folder.models(), *library_models()], folder.maps()
