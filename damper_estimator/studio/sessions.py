"""The pages that are open: found by a number that nobody guesses, let go when they are left.

A page that is only silent (its computer sleeps, a tunnel is down) ends its work soon and keeps what it has for an hour.
Nothing is lost with a page: its steps are in its session's file, from which it is opened again.
"""

import secrets
import threading
from time import monotonic

from damper_estimator.errors import InputError
from damper_estimator.studio.folder import Folder
from damper_estimator.studio.session import Session

MOST = 8  # pages at a time
SILENCE = 90.0  # s without a sign of life until work ends; browsers slow hidden pages down to one a minute
KEPT = 3600.0  # s until a silent page is let go


class Sessions:
    """All pages of one server; final."""

    def __init__(self, folder: Folder, silence: float = SILENCE, kept: float = KEPT) -> None:
        self.folder = folder
        self._silence, self._kept = silence, kept
        self._open: dict[str, tuple[Session, float]] = {}
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._sweeper = threading.Thread(target=self._sweep, name="sweeper", daemon=True)
        self._sweeper.start()

    def __len__(self) -> int:
        return len(self._open)

    def new(self, owner: str = "") -> str:
        """A page more, in a browser tab. Of too many, the one that was silent for longest is let go.

        Raises:
            InputError: where there are too many and none may be let go: with unsaved steps, or at work.
        """
        page = secrets.token_urlsafe(16)
        with self._lock:
            left = self._to_leave()
            self._open[page] = (Session(self.folder, owner), monotonic())
        for other in left:
            self.leave(other)
        return page

    def of(self, page: object) -> Session:
        """The session of a page, which thereby shows that it is there.

        Raises:
            InputError: where there is none any longer.
        """
        with self._lock:
            if not isinstance(page, str) or page not in self._open:
                raise InputError("the studio does not know this page any longer; load it again")
            session, _ = self._open[page]
            self._open[page] = (session, monotonic())
        return session

    def is_open(self, name: str) -> bool:
        """Whether some page has the session of that name open."""
        with self._lock:
            return any(session.writer.name == name for session, _ in self._open.values())

    def leave(self, page: str) -> None:
        """The page has gone: its work ends."""
        with self._lock:
            session, _ = self._open.pop(page, (None, 0.0))
        if session is not None:
            session.close()

    def close(self) -> None:
        """All pages are let go."""
        self._stop.set()
        for page in list(self._open):
            self.leave(page)

    def _to_leave(self) -> list[str]:
        """Which pages have to go for one more."""
        count = len(self._open) - MOST + 1
        idle = [page for page, (session, _) in self._open.items() if not (session.unsaved or session.busy)]
        if count > len(idle):
            raise InputError(
                f"{len(self._open)} pages with unsaved steps are open in this studio; save or close one, then load "
                "this page again"
            )
        return sorted(idle, key=lambda page: self._open[page][1])[: max(count, 0)]

    def _sweep(self) -> None:
        while not self._stop.wait(min(self._silence / 4.0, 5.0)):
            now = monotonic()
            with self._lock:
                silent = [(page, *entry) for page, entry in self._open.items() if now - entry[1] > self._silence]
            for page, session, seen in silent:
                session.rest()
                if now - seen > self._kept and not (session.unsaved and session.writer.failed):
                    self.leave(page)
