"""Runs a function in another process: the page stays responsive, and a cancelled job ends at once."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Any

from damper_estimator.errors import InputError

Progress = Callable[[str, float], None]
_EVERY = 0.2  # s between checks for a cancellation
_READY = "damper_estimator.studio.long_tasks"  # imported by the process that workers are forked from


class Cancelled(Exception):
    """The job was cancelled."""


def prepare() -> None:
    """Starts the process that the others are forked from, before this one has threads."""
    _context().Process(target=_nothing).start()


def run_in_process(function: Callable[..., Any], arguments: tuple, progress: Progress) -> Any:
    """``function(*arguments, progress)`` in another process, and what it returns.

    Args:
        function: of a module's top level; arguments and result can be pickled.
        progress: called with the current activity and the share done; its exceptions end the process and its children.

    Raises:
        InputError: as the function does.
        RuntimeError: where the process died, or the function has a bug.
    """
    here, there = multiprocessing.Pipe()
    process = _context().Process(target=_worked, args=(there, function, arguments))
    process.start()
    there.close()
    text, share = "starting", 0.0
    try:
        while True:
            progress(text, share)
            if not here.poll(_EVERY):
                continue
            kind, value = here.recv()
            if kind == "progress":
                text, share = value
            elif kind == "done":
                return value
            else:
                raise InputError(value) if kind == "refused" else RuntimeError(value)
    except EOFError:
        raise RuntimeError("the worker process has died; it may have run out of memory") from None
    finally:
        _end(process)
        here.close()


def _context():
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([_READY])
    return context


def _nothing() -> None:
    """Task of the first process."""


def _worked(pipe: Connection, function: Callable[..., Any], arguments: tuple) -> None:
    os.setsid()  # so that its own workers end with it
    threading.Thread(target=_end_with, args=(pipe,), daemon=True).start()
    try:
        pipe.send(("done", function(*arguments, lambda text, share: pipe.send(("progress", (text, share))))))
    except InputError as error:
        pipe.send(("refused", str(error)))
    except Exception as error:  # shown on the page; the traceback goes to the terminal
        pipe.send(("failed", f"{type(error).__name__}: {error}"))
        raise


def _end_with(pipe: Connection) -> None:
    """Waits until the server's end of the pipe is closed, by whatever ended the server, and ends all with it."""
    with suppress(EOFError, OSError):
        pipe.recv()
    os.killpg(0, signal.SIGKILL)


def _end(process: multiprocessing.Process) -> None:
    """Ends the process and what it started."""
    if process.is_alive():
        with suppress(ProcessLookupError, PermissionError):
            if os.getpgid(process.pid) == process.pid:
                os.killpg(process.pid, signal.SIGKILL)
        process.kill()
    process.join()
