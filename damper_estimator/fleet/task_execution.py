"""A worker executes one task: it runs the work, stores a row and returns the outcome."""

import errno
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from time import perf_counter

from damper_estimator import __version__
from damper_estimator.errors import InputError
from damper_estimator.files import write_text
from damper_estimator.fleet.result_rows import DONE, FAILED, write_row
from damper_estimator.fleet.task import Task

Work = Callable[[Task], Mapping[str, object]]
"""Runs the verb, writes its results under `Task.place`, and returns the values of the row's columns."""

_DISK_FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS}


@dataclass(frozen=True)
class Outcome:
    """What a worker returns.

    Attributes:
        reason: one line, "" if the task succeeded.
        seconds: duration of the work.
    """

    reason: str
    seconds: float


def execute(task: Task, work: Work, version: str) -> Outcome:
    """Executes a task; its row is stored whether it succeeded or failed.

    Raises:
        InputError: if results cannot be written, or the worker runs another version: every other task would fail too.
    """
    if version != __version__:
        raise InputError(
            f"a worker runs version {__version__} of damper_estimator, this process {version}; install the same version"
        )
    began = perf_counter()
    values: Mapping[str, object] = {}
    reason = ""
    try:
        values = work(task)
    except InputError as error:
        _raise_full_disk(error)
        reason = str(error)
    except Exception as error:  # a bug met on one recording must not stop the others
        _raise_full_disk(error)
        write_text(task.place("error.txt"), traceback.format_exc())
        message = " ".join(str(error).split())
        reason = f"{type(error).__name__}: {message} (unexpected; see {task.place('error.txt')})"
    write_row(task, FAILED if reason else DONE, reason, values)
    return Outcome(reason, perf_counter() - began)


def _raise_full_disk(error: BaseException) -> None:
    """A full disk concerns all recordings, not only this one."""
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, OSError) and cause.errno in _DISK_FULL:
            raise InputError(
                f"results cannot be written ({cause.strerror}); free some space and start again"
            ) from error
        cause = cause.__cause__
