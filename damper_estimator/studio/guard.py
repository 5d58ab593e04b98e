"""Who may talk to the studio: hooks of the web server that refuse what does not come from its own page.

A page of some other site that is open in the same browser can send requests to the loopback address. It cannot choose
their ``Host`` (so a name of its own that points here, DNS rebinding, is seen) nor hide its ``Origin``.
"""

import hmac
import ipaddress
import secrets
from dataclasses import dataclass

from flask import Flask, Request, Response, abort, redirect, request

LARGEST_REQUEST = 1_000_000  # bytes
_READING = ("GET", "HEAD")


@dataclass(frozen=True)
class Door:
    """How the studio is reached.

    Attributes:
        host: the address or name it is bound to.
        port: of the server.
        token: what every request must know; "" where the loopback address is guard enough.
    """

    host: str
    port: int
    token: str = ""

    @property
    def url(self) -> str:
        """The address of the page, with the token."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"http://{host}:{self.port}/" + (f"?token={self.token}" if self.token else "")

    @property
    def cookie(self) -> str:
        """The cookie that holds the token; browsers share cookies between the ports of a host."""
        return f"damper_studio_{self.port}"

    def knows(self, host: str) -> bool:
        """Whether a ``Host`` header names this server: by its own name, as localhost, or by address.

        An address cannot be made to point elsewhere, a foreign name can.
        """
        name, _, port = host.rpartition(":")
        if not name or port != str(self.port):
            return False
        name = name.strip("[]").lower()
        if name in ("localhost", self.host.lower()):
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


def new_token() -> str:
    """A token that nobody guesses."""
    return secrets.token_urlsafe(24)


def guard(server: Flask, door: Door, scripts: list[str]) -> None:
    """Puts the hooks on a server; ``scripts`` are the hashes of its own inline scripts."""
    server.config["MAX_CONTENT_LENGTH"] = LARGEST_REQUEST
    policy = (
        f"default-src 'self'; script-src 'self' {' '.join(scripts)}; style-src 'self' 'unsafe-inline'; "
        "img-src 'self' data: blob:; font-src 'self' data:; object-src 'none'; base-uri 'none'; form-action 'none'; "
        "frame-ancestors 'none'"
    )

    @server.before_request
    def admit() -> Response | None:
        return _admitted(request, door)

    @server.after_request
    def harden(response: Response) -> Response:
        response.headers["Content-Security-Policy"] = policy
        response.headers["X-Content-Type-Options"] = "nosniff"
        response.headers["Referrer-Policy"] = "no-referrer"
        response.headers["Cross-Origin-Resource-Policy"] = "same-origin"
        return response


def _admitted(asked: Request, door: Door) -> Response | None:
    if not door.knows(asked.headers.get("Host", "")):
        abort(403, "this Host is not the studio's")
    origin = asked.headers.get("Origin")
    if origin is None and asked.method not in _READING:
        abort(403, "a request that changes something must name its Origin")
    if origin is not None and origin != f"http://{asked.headers['Host']}":
        abort(403, "this Origin is not the studio's")
    if asked.headers.get("Sec-Fetch-Site", "none") == "cross-site" and asked.method not in _READING:
        abort(403, "this request comes from another site")
    if asked.method not in _READING and asked.content_length is None:
        abort(411)
    if asked.content_length is not None and asked.content_length > LARGEST_REQUEST:
        abort(413)
    return _with_token(asked, door.token, door.cookie) if door.token else None


def _with_token(asked: Request, token: str, cookie: str) -> Response | None:
    """Takes the token from the address once and keeps it in a cookie that no script and no other site gets."""
    given = asked.args.get("token", "")
    if asked.path == "/" and given and _same(given, token):
        response = redirect("/")
        response.set_cookie(cookie, token, httponly=True, samesite="Strict")
        return response
    if not _same(asked.cookies.get(cookie, ""), token):
        abort(403, "open the address with the token that the studio printed")
    return None


def _same(given: str, token: str) -> bool:
    return hmac.compare_digest(given.encode(), token.encode())
