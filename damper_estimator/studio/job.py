"""One piece of long work of a page, in a thread: how far it is, and its end."""

import sys
import threading
import traceback
from collections.abc import Callable
from time import monotonic

from damper_estimator.errors import InputError
from damper_estimator.studio.worker_process import Cancelled, Progress


class Job:
    """Work in the background of the page; final.

    Attributes:
        name: what it does, for people.
        number: identifies it on its page, which remembers the last job whose result was shown.
        state: ``running``, ``done``, ``failed`` or ``cancelled``.
        text, share: what goes on, and how much of it is done, 0 to 1.
        error: why it failed, in one line.
    """

    def __init__(self, name: str, work: Callable[[Progress], None], number: int = 1) -> None:
        """Starts ``work``; it takes on its results itself, at its end."""
        self.name, self.number = name, number
        self.state, self.text, self.share, self.error = "running", "", 0.0, ""
        self._began, self._ended = monotonic(), 0.0
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, args=(work,), name=name, daemon=True)
        self._thread.start()

    @property
    def running(self) -> bool:
        """Whether it still works."""
        return self.state == "running"

    @property
    def seconds(self) -> float:
        """How long it has taken."""
        return (self._ended or monotonic()) - self._began

    def cancel(self) -> None:
        """Asks it to end; it does when it next tells how far it is."""
        self._stop.set()

    def wait(self, seconds: float | None = None) -> None:
        """Until it has ended."""
        self._thread.join(seconds)

    def _tell(self, text: str, share: float) -> None:
        if self._stop.is_set():
            raise Cancelled
        self.text, self.share = text, share

    def _run(self, work: Callable[[Progress], None]) -> None:
        try:
            work(self._tell)
            state = "done"
        except Cancelled:
            state = "cancelled"
        except InputError as error:
            state, self.error = "failed", str(error)
        except Exception as error:  # a bug of ours must not leave a page that waits for ever
            state, self.error = "failed", f"this should not have happened: {type(error).__name__}: {error}"
            traceback.print_exc(file=sys.stderr)
        self._ended = monotonic()
        self.state = state
