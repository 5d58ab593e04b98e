"""What a worker does with one task: the work, a row that is kept, and what became of it."""

import errno
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from time import perf_counter

from damper_estimator import __version__
from damper_estimator.errors import InputError
from damper_estimator.files import write_text
from damper_estimator.fleet.rows import DONE, FAILED, write_row
from damper_estimator.fleet.task import Task

Work = Callable[[Task], Mapping[str, object]]
"""Does what the verb does, writes its results under `Task.place`, and gives the values of the row's columns."""

_NO_ROOM = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS}


@dataclass(frozen=True)
class Outcome:
    """What travels back from a worker.

    Attributes:
        reason: one line, "" where all went well.
        seconds: of work.
    """

    reason: str
    seconds: float


def carry_out(task: Task, work: Work, version: str) -> Outcome:
    """Does a task; its row is kept whether it went well or not.

    Raises:
        InputError: where results cannot be written, or the worker runs another version: no other task would do better.
    """
    if version != __version__:
        raise InputError(
            f"a worker runs version {__version__} of damper_estimator, here is {version}; install the same"
        )
    began = perf_counter()
    values: Mapping[str, object] = {}
    reason = ""
    try:
        values = work(task)
    except InputError as error:
        _raise_full_disk(error)
        reason = " ".join(str(error).split())
    except Exception as error:  # one recording stops nothing, not even by a mistake of ours
        _raise_full_disk(error)
        write_text(task.place("error.txt"), traceback.format_exc())
        told = " ".join(str(error).split())
        reason = f"{type(error).__name__}: {told} (unexpected; see {task.place('error.txt')})"
    write_row(task, FAILED if reason else DONE, reason, values)
    return Outcome(reason, perf_counter() - began)


def _raise_full_disk(error: BaseException) -> None:
    """A disk that is full is no matter of one recording."""
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, OSError) and cause.errno in _NO_ROOM:
            raise InputError(f"results cannot be written ({cause.strerror}); make room and start again") from error
        cause = cause.__cause__
