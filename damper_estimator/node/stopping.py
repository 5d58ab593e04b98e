"""How the process is asked to end: SIGTERM, SIGINT and SIGHUP. Knows no ROS."""

import os
import signal
import threading
import time

SIGNALS = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
TOGETHER = 0.5  # s within which several signals are one request: a terminal and a supervisor may both send theirs


class Stop:
    """The request to end; final.

    While the process is starting, nothing is commanded yet and a signal ends it at once, with status 0. Once
    `is_orderly` is set, a signal only sets `is_requested`, so that dampers are left at the safe current first. Another
    one, more than half a second later, ends the process at once, with status 128 + its number.

    A thread of its own learns of the signals through a pipe: a handler would only run when the main thread is back from
    whatever it does outside Python, and could raise in the middle of anything.

    Attributes:
        is_requested: whether a signal has come.
        is_orderly: whether whoever runs looks at `is_requested`.
    """

    def __init__(self) -> None:
        self.is_requested = self.is_orderly = False

    def listen(self) -> None:
        """Takes the signals from now on; SIGHUP not where it is ignored, as under nohup."""
        source, sink = os.pipe()
        os.set_blocking(sink, False)
        signal.set_wakeup_fd(sink, warn_on_full_buffer=False)
        for number in SIGNALS:
            if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:
                signal.signal(number, lambda *_: None)
        threading.Thread(target=self._wait, args=(source,), name="signals", daemon=True).start()

    def ignore(self) -> None:
        """Ignores the signals from now on: nothing is left to be done, and the status is decided."""
        for number in SIGNALS:
            signal.signal(number, signal.SIG_IGN)

    def _wait(self, source: int) -> None:
        since = float("inf")
        while True:
            (number,) = os.read(source, 1)
            now = time.monotonic()
            if number not in SIGNALS:
                continue
            if not self.is_orderly:
                os._exit(0)
            self.is_requested = True
            since = min(since, now)
            if now - since > TOGETHER:
                os._exit(128 + number)
