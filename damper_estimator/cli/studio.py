"""Compare, diagnose, add, fit and improve in the browser, on the recordings of a folder.

Opens a page on the loopback address of this machine; nothing is loaded from a network. The page reads and writes only
in FOLDER. With --host other machines can connect, and need the printed token.
"""

import argparse
import errno
import re
import socket
import webbrowser
from importlib.util import find_spec
from pathlib import Path

from damper_estimator.cli.verb_support import optional_packages, progress
from damper_estimator.errors import InputError

EXAMPLES = (
    "studio",
    "studio recordings --no-browser --port 0",
)
PORT = 8050
_NAME = re.compile(r"[A-Za-z0-9]([A-Za-z0-9.-]*[A-Za-z0-9])?")
_NO_ADDRESS = (errno.EADDRNOTAVAIL, socket.EAI_NONAME, socket.EAI_AGAIN)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the verb's arguments."""
    parser.add_argument(
        "folder", metavar="FOLDER", nargs="?", type=Path, default=Path("."),
        help="folder with recordings, models and maps (default: the current one)",
    )  # fmt: skip
    parser.add_argument(
        "--port", metavar="N", type=_port, default=PORT, help="default: %(default)s; 0 selects a free one"
    )
    parser.add_argument("--no-browser", action="store_true", help="only print the address")
    parser.add_argument("--token", action="store_true", help="require the printed token for access")
    parser.add_argument(
        "--host", metavar="ADDRESS", default="127.0.0.1",
        help="another address to listen on, 0.0.0.0 for all; needs --token",
    )  # fmt: skip
    parser.add_argument(
        "--allow-host", metavar="NAME", action="append", default=[],
        help="a name of this machine that browsers may use, others are refused; may be repeated",
    )  # fmt: skip
    parser.add_argument(
        "--live", metavar="MINUTES", nargs="?", type=float, const=5.0, default=0.0,
        help="listen to a running node (needs ROS 2) and keep its last minutes, which can be saved (5)",
    )  # fmt: skip


def _port(text: str) -> int:
    number = int(text)
    if not 0 <= number <= 65535:
        raise ValueError(text)
    return number


def run(arguments: argparse.Namespace) -> int:
    """Serves the page until it is interrupted."""
    with optional_packages("the studio", "studio", ("dash", "flask", "werkzeug")):
        from damper_estimator.studio.folder import Folder
        from damper_estimator.studio.guard import ServerAddress, is_loopback, new_token
        from damper_estimator.studio.server import serve
    host = arguments.host
    if not is_loopback(host) and not arguments.token:
        raise InputError(f"--host {host}: other machines could reach the studio; add --token to require a token")
    names = tuple(arguments.allow_host)
    for name in names:
        if not _NAME.fullmatch(name):
            raise InputError(f"--allow-host {name}: give only a name such as rig.local, without scheme and port")
    if arguments.live and not 0.0 < arguments.live <= 60.0:
        raise InputError(f"--live {arguments.live:g}: give minutes between 0 and 60")
    if arguments.live and find_spec("rclpy") is None:
        raise InputError("--live: ROS 2 is not installed (no rclpy); source its setup, or omit --live")
    folder, token = Folder(arguments.folder), new_token() if arguments.token else ""

    def ready(address: ServerAddress) -> None:
        progress(f"the studio is at {address.url} (Ctrl+C ends it)")
        if not arguments.no_browser:
            webbrowser.open(address.url)

    try:
        serve(folder, lambda port: ServerAddress(host, port, token, names), host, arguments.port, ready, arguments.live)
    except OSError as error:
        remedy = (
            "choose an address of this machine" if error.errno in _NO_ADDRESS else "choose another port with --port N"
        )
        raise InputError(f"port {arguments.port} of {host}: {error.strerror}; {remedy}") from error
    return 0
