"""A page's arrival: its session, from what its URL names; and the URL that follows what is open and on view."""

from collections.abc import Mapping

from dash import ClientsideFunction, Dash, Input, Output, html, no_update
from dash.exceptions import PreventUpdate

from damper_estimator.errors import InputError
from damper_estimator.studio.address import Address, fields_of, parsed_address
from damper_estimator.studio.page_layout import TABS
from damper_estimator.studio.session import Session
from damper_estimator.studio.session_files import SessionFiles
from damper_estimator.studio.sessions import Sessions
from damper_estimator.studio.stage import Choice

_FIRST = 1  # what `Session.opened` counts first: the opening that the address asks for
_CHOSEN = ("recordings", "unseen", "damper", "map", "models", "start", "stop")
_NOTHING = [no_update] * (3 + len(_CHOSEN))


def connect(app: Dash, sessions: Sessions) -> None:
    """The server makes a session only for a page that has loaded here and asks for one."""
    _connect_address(app)

    @app.callback(
        Output("page", "data"),
        Output("open-message", "children", allow_duplicate=True),
        Output("view", "data", allow_duplicate=True),
        Output("tab", "value", allow_duplicate=True),
        Output("studio", "data-sight", allow_duplicate=True),
        *(Output(name, "value", allow_duplicate=True) for name in _CHOSEN),
        Input("address", "data"),
        prevent_initial_call=True,
    )
    def arrive(data):
        given = data if isinstance(data, Mapping) else {}
        address = parsed_address(given.get("query"))
        try:
            page = sessions.new(str(given.get("tab") or "")[:40])
        except InputError as error:
            return None, str(error), *_NOTHING
        chosen, models, message = _begun(sessions, sessions.of(page), address)
        return page, message, *(_shown(address, chosen, models) if models else _NOTHING)

    _connect_kept(app, sessions)


def _connect_address(app: Dash) -> None:
    def in_browser(name: str, *arguments: object) -> None:
        app.clientside_callback(ClientsideFunction("studio", name), *arguments)

    in_browser("arrive", Output("address", "data"), Input("studio", "id"))
    in_browser("reload", Output("studio", "data-lost"), Input("lost", "data"))
    in_browser(
        "locate", Output("studio", "data-place"), Input("place", "data"), Input("view", "data"), Input("tab", "value"),
        Input("studio", "data-sight"),
    )  # fmt: skip


def _connect_kept(app: Dash, sessions: Sessions) -> None:
    @app.callback(
        Output("place", "data"),
        Output("unkept", "children"),
        Output("earlier", "children"),
        Input("generation", "data"),
        Input("page", "data"),
    )
    def place(_, page):
        try:
            session = sessions.of(page)
        except InputError:
            raise PreventUpdate from None
        listed = _earlier(SessionFiles(session.folder).listed(), session.writer.name)
        if session.history is None:
            return no_update, "", listed
        choice, damper = session.stage.choice, session.stage.damper
        fields = fields_of(choice, damper, session.names, session.writer.name, session.history.at)
        return fields, session.writer.failed, listed


def _begun(sessions: Sessions, session: Session, address: Address) -> tuple[Choice, tuple[str, ...], str]:
    """Starts to open what an address names: what is opened, and what could not be."""
    message = ""
    if address.session:
        try:
            kept = session.resume(address.session, address.step, not sessions.is_open(address.session))
            return kept.choice, kept.models, ""
        except InputError as error:
            message = f"{error}; its steps are missing, only recordings and models are opened"
    if address.opens:
        session.open(address.choice, list(address.models))
        return address.choice, address.models, message
    return address.choice, (), message


def _shown(address: Address, chosen: Choice, models: tuple[str, ...]) -> list:
    """What is on view once it is open, the panel, and what was chosen."""
    recording, start, stop = address.view
    view = {"opened": _FIRST, "recording": recording, "start": start, "stop": stop, "mark": None}
    tab = address.tab if address.tab in TABS else no_update
    values = (chosen.fit, chosen.unseen, chosen.damper or None, chosen.signals or None, models)
    lists = [list(value) if isinstance(value, tuple) else value for value in values]
    sight = "corners" if address.all_dampers else no_update
    return [view, tab, sight, *lists, chosen.start, chosen.stop]


def _earlier(listed: list[tuple[str, str, str]], name: str) -> html.Details | str:
    """Links to the sessions of the folder, newest first."""
    rows = []
    for session, words, when in listed:
        here = " (this page)" if session == name else ""
        rows.append(html.Li([html.A(words, href=f"/?session={session}"), html.Small(f" {when}{here}")]))
    return html.Details([html.Summary(f"Earlier work ({len(rows)})"), html.Ul(rows)]) if rows else ""
