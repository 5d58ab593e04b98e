"""Puts page, guard and callbacks together, and serves them."""

import logging
import traceback
from collections.abc import Callable

from dash import Dash, set_props
from flask import request
from werkzeug.serving import BaseWSGIServer, make_server

from damper_estimator import __version__
from damper_estimator.report.paint import styles
from damper_estimator.studio import apart
from damper_estimator.studio.callbacks import connect
from damper_estimator.studio.folder import Folder
from damper_estimator.studio.guard import Door, guard
from damper_estimator.studio.page import layout
from damper_estimator.studio.sessions import Sessions

_INDEX = """<!doctype html>
<html lang="en">
<head>
{%metas%}
<meta name="viewport" content="width=device-width, initial-scale=1">
<link rel="icon" href="data:,">
<title>{%title%}</title>
<style>__STYLES__</style>
{%css%}
</head>
<body>
{%app_entry%}
<footer>{%config%}{%scripts%}{%renderer%}</footer>
</body>
</html>"""


def application(folder: Folder, door: Door) -> tuple[Dash, Sessions]:
    """The studio as a web application, and the pages that are open in it."""
    sessions = Sessions(folder)
    app = Dash(
        "damper_estimator.studio",
        title="damper studio",
        update_title=None,
        serve_locally=True,
        suppress_callback_exceptions=True,
        index_string=_INDEX.replace("__STYLES__", styles()),
        on_error=_told,
    )
    app.layout = lambda: layout(sessions.new(), folder)
    connect(app, sessions)

    @app.server.post("/leave")
    def leave() -> tuple[str, int]:
        sessions.leave(request.get_data(as_text=True))
        return "", 204

    guard(app.server, door, app.csp_hashes())
    return app, sessions


def _told(error: Exception) -> None:
    """A bug of ours in a callback is told on the page, and its traceback on the terminal."""
    traceback.print_exception(error)
    set_props("job", {"children": f"this should not have happened: {type(error).__name__}: {error}"})


def serve(folder: Folder, door_at: Callable[[int], Door], host: str, port: int, ready: Callable[[Door], None]) -> None:
    """Serves until the process is ended.

    Args:
        door_at: the door for the port that was got (``port`` 0: any that is free).
        ready: is told the door when the page can be opened.

    Raises:
        OSError: where the port is taken.
    """
    apart.prepare()
    logging.getLogger("werkzeug").setLevel(logging.WARNING)  # no line per request
    listening: BaseWSGIServer = make_server(host, port, _nothing, threaded=True)
    door = door_at(listening.server_port)
    app, sessions = application(folder, door)
    listening.app = app.server
    ready(door)
    try:
        listening.serve_forever()
    finally:
        sessions.close()
        listening.server_close()


def _nothing(environment: dict, start_response: Callable) -> list[bytes]:
    """Answers while the page is put together."""
    start_response("503 Service Unavailable", [("Retry-After", "1")])
    return [f"damper studio {__version__} starts".encode()]
