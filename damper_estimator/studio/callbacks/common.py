"""Helpers of the callbacks: actions whose error message appears next to their control."""

from collections.abc import Callable
from typing import Any

from dash import ClientsideFunction, Dash, Input, Output, State, ctx, no_update
from dash.exceptions import PreventUpdate

from damper_estimator.errors import InputError
from damper_estimator.studio.session import Session
from damper_estimator.studio.sessions import Sessions

CHANGES = tuple(Output(f"reported-{name}", "data", allow_duplicate=True) for name in ("generation", "rebuilt"))
"""Outputs of every callback that changes the session; what shows the session listens to the forwarded values."""


def forward_changes(app: Dash) -> None:
    """Forwards values that several answers report, only when they change: unchanged parts are not redrawn."""
    for name in ("generation", "rebuilt", "drawn"):
        app.clientside_callback(
            ClientsideFunction("studio", "news"),
            Output(name, "data"),
            Input(f"reported-{name}", "data"),
            State(name, "data"),
            prevent_initial_call=True,
        )


def answered(sessions: Sessions, page: object, verb: Callable[[Session], None]) -> tuple[object, object, str]:
    """Does something to a page's session: its counts of changes, and why it could not be done."""
    try:
        session = sessions.of(page)
        verb(session)
        return session.generation, session.rebuilt, ""
    except InputError as error:
        return no_update, no_update, str(error)


def opened(sessions: Sessions, page: object) -> Session | None:
    """A page's session, None where nothing is open in it."""
    try:
        session = sessions.of(page)
    except InputError:
        return None
    return session if session.history is not None else None


def clicked() -> Any:
    """The identifier of the button that was clicked. Buttons that have just been drawn trigger a callback as well, by
    themselves or together with one that was clicked meanwhile.

    Raises:
        PreventUpdate: where none was clicked.
    """
    place = next((one["prop_id"] for one in ctx.triggered if one["value"]), None)
    if place is None:
        raise PreventUpdate
    return ctx.triggered_prop_ids[place]
