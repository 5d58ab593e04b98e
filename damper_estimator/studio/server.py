"""Puts page, guard and callbacks together, and serves them."""

import logging
import socket
import traceback
from collections.abc import Callable

from dash import Dash, set_props
from flask import Response, request
from werkzeug.serving import BaseWSGIServer, make_server

from damper_estimator import __version__
from damper_estimator.errors import InputError
from damper_estimator.report.page import figure_script
from damper_estimator.report.theme import styles
from damper_estimator.studio import worker_process
from damper_estimator.studio.callbacks import connect
from damper_estimator.studio.folder import Folder, Taken
from damper_estimator.studio.guard import SANDBOX, UPLOAD, ServerAddress, guard
from damper_estimator.studio.live import Live
from damper_estimator.studio.page_layout import layout
from damper_estimator.studio.sessions import Sessions
from damper_estimator.studio.uploads import receive

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
<footer>{%config%}{%scripts%}{%renderer%}<script src="/figure_files.js"></script></footer>
</body>
</html>"""


def application(folder: Folder, address: ServerAddress, live: Live | None = None) -> tuple[Dash, Sessions]:
    """The studio as a web application, and the pages that are open in it."""
    sessions = Sessions(folder)
    app = Dash(
        "damper_estimator.studio",
        title="damper studio",
        update_title=None,
        serve_locally=True,
        suppress_callback_exceptions=True,
        index_string=_INDEX.replace("__STYLES__", styles()),
        on_error=_report_bug,
    )
    app.layout = lambda: layout(folder, live)  # a page gets a session when it asks for one, not with its layout
    connect(app, sessions, live)

    @app.server.get("/figure_files.js")
    def figure_files() -> Response:
        return Response(figure_script(), mimetype="text/javascript")

    @app.server.get("/test/<page>/<int:number>")
    def test_page(page: str, number: int) -> Response:
        return _test_page(sessions, page, number)

    @app.server.post("/leave")
    def leave() -> tuple[str, int]:
        sessions.leave(request.get_data(as_text=True))
        return "", 204

    @app.server.post(UPLOAD)
    def upload() -> tuple[str, int]:
        return _received(sessions)

    guard(app.server, address, app.csp_hashes())
    return app, sessions


def _test_page(sessions: Sessions, page: str, number: int) -> Response:
    """The page of a test; its scripts run, but not as the studio's: they reach neither its cookie nor its address."""
    try:
        session = sessions.of(page)
        test = session.tests[number]
        text = session.folder.existing(f"{test.folder}/{test.page}").read_text(encoding="utf-8")
    except (InputError, IndexError, OSError):
        return Response("there is no such page; make it again under Tests", 404, mimetype="text/plain")
    response = Response(text, mimetype="text/html")
    response.headers["Content-Security-Policy"] = SANDBOX
    return response


def _received(sessions: Sessions) -> tuple[str, int]:
    """Takes a file that a page sends; the answer is what was added, or why it could not be."""
    try:
        sessions.of(request.headers.get("X-Studio-Page"))
        # Straight from the connection: Flask's own limit is that of small requests.
        name, length = request.args.get("name", ""), request.content_length or 0
        return receive(sessions.folder, name, request.environ["wsgi.input"], length), 200
    except Taken as taken:
        return str(taken), 409
    except InputError as error:
        return str(error), 400


def _report_bug(error: Exception) -> None:
    """Shows a bug in a callback on the page, and its traceback on the terminal."""
    traceback.print_exception(error)
    set_props("job", {"children": f"internal error: {type(error).__name__}: {error}"})


def serve(
    folder: Folder, address_at: Callable[[int], ServerAddress], host: str, port: int,
    ready: Callable[[ServerAddress], None], minutes: float = 0.0,
) -> None:  # fmt: skip
    """Serves until the process is ended.

    Args:
        address_at: the address for the port that was got (``port`` 0: any that is free).
        ready: is called with the address when the page can be opened.
        minutes: of a running node's inputs that are held; 0 where it listens to none.

    Raises:
        OSError: where the port is taken, or the address is not this machine's.
    """
    bound = _bound(host, port)
    worker_process.prepare()
    logging.getLogger("werkzeug").setLevel(logging.WARNING)  # no line per request
    listening: BaseWSGIServer = make_server(host, port, _nothing, threaded=True, fd=bound.fileno())
    address = address_at(bound.getsockname()[1])
    live = Live(minutes) if minutes else None
    app, sessions = application(folder, address, live)
    listening.app = app.server
    ready(address)
    try:
        listening.serve_forever()
    finally:
        sessions.close()
        if live is not None:
            live.close()
        listening.server_close()
        bound.close()


def _bound(host: str, port: int) -> socket.socket:
    """A socket that listens: werkzeug would end the process where the port is taken."""
    family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
    listener = socket.socket(family, kind, protocol)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(address)
        listener.listen(128)
    except OSError:
        listener.close()
        raise
    return listener


def _nothing(environment: dict, start_response: Callable) -> list[bytes]:
    """Answers while the page is put together."""
    start_response("503 Service Unavailable", [("Retry-After", "1")])
    return [f"damper studio {__version__} starts".encode()]
