"""The page's own life: its theme, its tabs, the work that goes on, its leaving."""

from dash import ALL, ClientsideFunction, Dash, Input, Output, State, no_update
from dash.exceptions import PreventUpdate

from damper_estimator.errors import InputError
from damper_estimator.studio.callbacks.common import CHANGES, answered, opened
from damper_estimator.studio.corners import TASKS
from damper_estimator.studio.job import Job
from damper_estimator.studio.session import Session
from damper_estimator.studio.sessions import Sessions

_PLACES = {
    "opening": 0,
    "diagnosing": 1,
    "improving": 1,
    "identifying": 2,
    "judging": 4,
    "characterizing": 5,
    "planning": 5,
    "riding": 5,
}
_PLACES |= dict.fromkeys(TASKS.values(), 3)
"""Where a work's failure is said, by its name."""
_STEPPING = ("improving", "identifying")  # works that end in a step more


def connect(app: Dash, sessions: Sessions) -> None:
    """Theme and tabs need no server; the work is looked at twice a second, which is the page's sign of life."""

    def in_browser(name: str, *arguments: object) -> None:
        app.clientside_callback(ClientsideFunction("studio", name), *arguments)

    in_browser("theme", Output("theme", "data"), Input("theme-button", "n_clicks"), State("theme", "data"))
    in_browser("introduce", Output("studio", "data-page"), Input("page", "data"))
    panels = {"type": "panel", "name": ALL}
    in_browser("tab", Output(panels, "hidden"), Output("work", "data-tab"), Input("tab", "value"), State(panels, "id"))

    @app.callback(
        *CHANGES,
        Output("job", "children"),
        Output("progress", "value"),
        Output("progress", "hidden"),
        Output("cancel", "hidden"),
        Output("ended", "data"),
        Output("tab", "value"),
        Output("open-message", "children", allow_duplicate=True),
        Output("learn-message", "children", allow_duplicate=True),
        Output("change-message", "children", allow_duplicate=True),
        Output("corners-message", "children", allow_duplicate=True),
        Output("draw-message", "children", allow_duplicate=True),
        Output("tests-message", "children", allow_duplicate=True),
        Output("lost", "data"),
        Input("tick", "n_intervals"),
        State("page", "data"),
        State("generation", "data"),
        State("rebuilt", "data"),
        State("ended", "data"),
        prevent_initial_call=True,
    )
    def look(_, page, generation, rebuilt, ended):
        if page is None:
            raise PreventUpdate
        try:
            session = sessions.of(page)
        except InputError as error:
            return no_update, no_update, str(error), no_update, True, True, *[no_update] * 8, 1
        changes = (
            session.generation if session.generation != generation else no_update,
            session.rebuilt if session.rebuilt != rebuilt else no_update,
        )
        return *changes, *_work(session, ended), no_update

    _connect_buttons(app, sessions)


def _connect_buttons(app: Dash, sessions: Sessions) -> None:
    """Cancel, undo and redo."""

    @app.callback(*CHANGES, Output("job", "children", allow_duplicate=True), Input("cancel", "n_clicks"),
                  State("page", "data"), prevent_initial_call=True)  # fmt: skip
    def cancel(_, page):
        return answered(sessions, page, lambda session: session.job and session.job.cancel())

    @app.callback(*CHANGES, Output("job", "children", allow_duplicate=True), Input("undo", "n_clicks"),
                  State("page", "data"), prevent_initial_call=True)  # fmt: skip
    def undo(_, page):
        return answered(sessions, page, Session.undo)

    @app.callback(*CHANGES, Output("job", "children", allow_duplicate=True), Input("redo", "n_clicks"),
                  State("page", "data"), prevent_initial_call=True)  # fmt: skip
    def redo(_, page):
        return answered(sessions, page, Session.redo)

    @app.callback(Output("undo", "disabled"), Output("redo", "disabled"), Input("generation", "data"),
                  State("page", "data"))  # fmt: skip
    def ways(_, page):
        session = opened(sessions, page)
        if session is None:
            return True, True
        return not session.history.at, session.history.at + 1 == len(session.history.versions)


def _work(session: Session, ended: object) -> list[object]:
    """Progress of the work and, once, its result; ``ended`` is the number of the last work whose result was shown."""
    job, messages = session.job, [no_update] * 6
    if job is None or job.number == ended:
        return [no_update] * 6 + messages
    if job.running:
        text = f"{job.name}: {100.0 * job.share:.0f} %, {job.text} ({job.seconds:.0f} s)"
        return [text, f"{job.share:.3f}", False, False, no_update, no_update, *messages]
    messages[_PLACES[job.name]] = job.error
    # An error that fell is to be seen falling.
    turned = "steps" if job.state == "done" and job.name in _STEPPING else no_update
    return [_ended(job), no_update, True, True, job.number, turned, *messages]


def _ended(job: Job) -> str:
    return {"done": f"{job.name}: done ({job.seconds:.0f} s)", "cancelled": f"{job.name}: cancelled"}.get(
        job.state, f"{job.name}: failed"
    )
