"""Who may talk to the studio: hooks of the web server that refuse what does not come from its own page.

A page of some other site that is open in the same browser can send requests to the loopback address. It cannot choose
their ``Host`` (so a name of its own that points here, DNS rebinding, is seen), nor hide its ``Origin`` or the
``Sec-Fetch-*`` headers. From elsewhere only a link to the page itself is followed, which reads nothing and creates
nothing: a session is made by a request of the page that was loaded.
"""

import hmac
import ipaddress
import secrets
import socket
from contextlib import suppress
from dataclasses import dataclass
from urllib.parse import urlencode

from flask import Flask, Request, Response, abort, redirect, request

LARGEST_REQUEST = 1_000_000  # bytes; files come to UPLOAD, which looks how much the disk holds
UPLOAD = "/upload"
_READING = ("GET", "HEAD")
_OURS = ("same-origin", "none")  # of Sec-Fetch-Site; none: typed, a bookmark, another program
# A link from elsewhere: the page loads itself once more, now as its own request, which has the cookie.
_AGAIN = """<!doctype html><html lang="en"><title>damper studio</title>
<meta http-equiv="refresh" content="0"><p>Opening the studio ...</p>"""


SANDBOX = (
    "sandbox allow-scripts allow-downloads; default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data: blob:; font-src data:"
)
"""Policy of a self-contained page that was written into the folder."""


@dataclass(frozen=True)
class ServerAddress:
    """How the studio is reached.

    Attributes:
        host: the address or name it is bound to.
        port: of the server.
        token: what every request must know; "" where the loopback address is guard enough.
        names: further names under which the machine is known to others, as in DNS.
    """

    host: str
    port: int
    token: str = ""
    names: tuple[str, ...] = ()

    @property
    def url(self) -> str:
        """An address of the page that a browser can open, with the token."""
        host = self.names[0] if self.names else usable_address(self.host)
        host = f"[{host}]" if ":" in host else host
        return f"http://{host}:{self.port}/" + (f"?token={self.token}" if self.token else "")

    @property
    def cookie(self) -> str:
        """The cookie that holds the token; browsers share cookies between the ports of a host."""
        return f"damper_studio_{self.port}"

    def knows(self, host: str) -> bool:
        """Whether a ``Host`` header names this server: by one of its names, as localhost, or by address.

        An address cannot be made to point elsewhere, a foreign name can.
        """
        name, _, port = host.rpartition(":")
        if not name or port != str(self.port):
            return False
        name = name.strip("[]").lower()
        if name in ("localhost", self.host.lower(), *(allowed.lower() for allowed in self.names)):
            return True
        try:
            address = ipaddress.ip_address(name)
        except ValueError:
            return False
        return address.is_loopback or not is_loopback(self.host)


def is_loopback(host: str) -> bool:
    """Whether an address or name is this machine alone."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def usable_address(host: str) -> str:
    """An address under which the machine is reached where ``host`` stands for all of its addresses.

    Nothing is sent: a datagram socket is only asked which address it would send from.
    """
    try:
        if not ipaddress.ip_address(host).is_unspecified:
            return host
    except ValueError:
        return host
    six = ":" in host
    with suppress(OSError), socket.socket(socket.AF_INET6 if six else socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.connect(("2001:db8::1" if six else "192.0.2.1", 9))  # addresses that are reserved for documentation
        return str(probe.getsockname()[0])
    return "::1" if six else "127.0.0.1"


def new_token() -> str:
    """A token that nobody guesses."""
    return secrets.token_urlsafe(24)


def guard(server: Flask, address: ServerAddress, scripts: list[str]) -> None:
    """Puts the hooks on a server; ``scripts`` are the hashes of its own inline scripts."""
    server.config["MAX_CONTENT_LENGTH"] = LARGEST_REQUEST
    policy = (
        f"default-src 'self'; script-src 'self' {' '.join(scripts)}; style-src 'self' 'unsafe-inline'; "
        "img-src 'self' data: blob:; font-src 'self' data:; object-src 'none'; base-uri 'none'; form-action 'none'; "
        "frame-ancestors 'none'"
    )

    @server.before_request
    def admit() -> Response | None:
        return _admitted(request, address)

    @server.after_request
    def harden(response: Response) -> Response:
        response.headers.setdefault("Content-Security-Policy", policy)
        response.headers["X-Content-Type-Options"] = "nosniff"
        response.headers["Referrer-Policy"] = "no-referrer"
        response.headers["Cross-Origin-Resource-Policy"] = "same-origin"
        return response


def _admitted(asked: Request, address: ServerAddress) -> Response | None:
    if not address.knows(asked.headers.get("Host", "")):
        abort(403, "this Host is not the studio's; start it with --allow-host NAME where it is")
    origin = asked.headers.get("Origin")
    if origin is None and asked.method not in _READING:
        abort(403, "a request that changes something must name its Origin")
    if origin is not None and origin != f"http://{asked.headers['Host']}":
        abort(403, "this Origin is not the studio's")
    if asked.headers.get("Sec-Fetch-Site", "none") not in _OURS:
        return _from_elsewhere(asked)
    if asked.method not in _READING and asked.content_length is None:
        abort(411)
    if asked.content_length is not None and asked.content_length > LARGEST_REQUEST and asked.path != UPLOAD:
        abort(413)
    return _with_token(asked, address.token, address.cookie) if address.token else None


def _from_elsewhere(asked: Request) -> Response:
    """A link that was clicked on another site leads to the page; everything else that a site sends is refused."""
    link = [asked.headers.get(f"Sec-Fetch-{name}") for name in ("Mode", "Dest")] == ["navigate", "document"]
    if asked.path != "/" or asked.method != "GET" or not link:
        abort(403, "this request comes from another site")
    return Response(_AGAIN, mimetype="text/html")


def _with_token(asked: Request, token: str, cookie: str) -> Response | None:
    """Takes the token from the address once and keeps it in a cookie that no script and no other site gets."""
    given = asked.args.get("token", "")
    if asked.path == "/" and given and _same(given, token):
        rest = urlencode([(name, value) for name, value in asked.args.items(multi=True) if name != "token"])
        response = redirect(f"/?{rest}" if rest else "/")
        response.set_cookie(cookie, token, httponly=True, samesite="Strict")
        return response
    if not _same(asked.cookies.get(cookie, ""), token):
        abort(403, "open the address with the token that the studio printed")
    return None


def _same(given: str, token: str) -> bool:
    return hmac.compare_digest(given.encode(), token.encode())
