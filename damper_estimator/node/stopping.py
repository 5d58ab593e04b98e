"""Requests to end the process: SIGTERM, SIGINT and SIGHUP. Independent of ROS."""

import os
import signal
import threading
import time

SIGNALS = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
TOGETHER = 0.5  # s within which several signals are one request: a terminal and a supervisor can both send one


class Stop:
    """The request to end; final.

    While the process is starting, nothing is commanded and a signal ends it immediately, with status 0. Once
    `is_orderly` is set, a signal only sets `is_requested`, so that dampers are left at the safe current first. Another
    one, more than half a second later, ends the process immediately, with status 128 + its number.

    A separate thread reads the signals from a pipe: a handler would run only after the main thread returns from work
    outside Python, and could raise anywhere.

    Attributes:
        is_requested: whether a signal has come.
        is_orderly: whether the main loop checks `is_requested`.
    """

    def __init__(self) -> None:
        self.is_requested = self.is_orderly = False

    def listen(self) -> None:
        """Handles the signals from now on; not SIGHUP if it is ignored, as under nohup."""
        source, sink = os.pipe()
        os.set_blocking(sink, False)
        signal.set_wakeup_fd(sink, warn_on_full_buffer=False)
        for number in SIGNALS:
            if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:
                signal.signal(number, lambda *_: None)
        threading.Thread(target=self._wait, args=(source,), name="signals", daemon=True).start()

    def ignore(self) -> None:
        """Ignores the signals from now on: no work is left, and the exit status is determined."""
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
