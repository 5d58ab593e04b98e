"""What is done with a marked region: fit on it, diagnose it, leave it out, write it as a table."""

from collections.abc import Callable
from pathlib import Path

from dash import Dash, Input, Output, State, no_update
from dash.exceptions import PreventUpdate

from damper_estimator.diagnosis import MODES
from damper_estimator.errors import InputError
from damper_estimator.studio.callbacks.common import CHANGES, answered, opened
from damper_estimator.studio.marking import table
from damper_estimator.studio.page_layout import names_of
from damper_estimator.studio.session import Session
from damper_estimator.studio.sessions import Sessions
from damper_estimator.studio.view import View, parsed_view


def connect(app: Dash, sessions: Sessions) -> None:
    """One button for each."""
    verbs = {
        "fit-marked": lambda session, view, mode: session.refit_marked(view),
        "diagnose-marked": lambda session, view, mode: session.diagnose_marked(view, mode),
        "leave-out": lambda session, view, mode: session.leave_out(view),
        "take-back": lambda session, view, mode: session.take_back(),
    }
    for name, verb in verbs.items():
        _button(app, sessions, name, verb)

    @app.callback(
        Output("download", "data"),
        Output("draw-message", "children", allow_duplicate=True),
        Input("export-marked", "n_clicks"),
        Input("export-view", "n_clicks"),
        State("view", "data"),
        State("page", "data"),
        prevent_initial_call=True,
    )
    def export(_marked, _view, data, page):
        session = opened(sessions, page)
        if session is None:
            raise PreventUpdate
        try:
            view = viewed(session, data)
            models = [session.shown(model) for model in session.models()]
            content = table(models, names_of(session.models(), session.history.at > 0), view)
        except InputError as error:
            return no_update, str(error)
        recording = Path(session.stage.names[view.recording]).stem
        return {"content": content, "filename": f"{recording}_{session.stage.damper}.csv", "type": "text/csv"}, ""

    @app.callback(
        Output("left-out", "hidden"),
        Output("left-out-words", "children"),
        Input("generation", "data"),
        State("page", "data"),
    )
    def left_out(_, page):
        session = opened(sessions, page)
        stretches = session.stage.choice.left_out if session is not None else ()
        seconds = sum(stop - start for _, start, stop in stretches)
        many = "1 stretch" if len(stretches) == 1 else f"{len(stretches)} stretches"
        return not stretches, f"left out of fits and errors: {seconds:.3g} s in {many}"


def _button(app: Dash, sessions: Sessions, name: str, verb: Callable[[Session, View, str], None]) -> None:
    @app.callback(
        *CHANGES,
        Output("draw-message", "children", allow_duplicate=True),
        Input(name, "n_clicks"),
        State("view", "data"),
        State("mode", "value"),
        State("page", "data"),
        prevent_initial_call=True,
    )
    def act(_, data, mode, page):
        def on_view(session: Session) -> None:
            if session.history is None:
                raise InputError("nothing is open yet: choose a recording and a model, then open them")
            verb(session, viewed(session, data), mode if mode in MODES else MODES[0])

        return answered(sessions, page, on_view)


def viewed(session: Session, data: object) -> View:
    """What is on view in a page.

    Raises:
        InputError: for what no page of ours asks for.
    """
    current = data if isinstance(data, dict) and data.get("opened") == session.opened else {}
    return parsed_view(current, len(session.stage.whole))
