"""Compiles the loops over a model in other processes while a recording is read, unless an earlier run kept them.

Reading compiles other functions. On two cores the loops, which take longest, are ready when they are needed, and
the workers of a diagnosis do not compile them again.
"""

import multiprocessing
import os
import threading

import numpy as np

from damper_estimator.compiled import COMPILED, is_kept
from damper_estimator.model import chain
from damper_estimator.model.kernels import addresses

_underway: dict[bool, tuple[int, multiprocessing.Process]] = {}
"""By whether it is the loop with a series element: the process that began it, and the one that compiles."""


def compile_loops_ahead() -> None:
    """Begins; does nothing where the loops are kept, on a single core, or where a fork is impossible or unsafe."""
    if not COMPILED or (os.cpu_count() or 1) < 2 or threading.active_count() > 1 or _underway:
        return
    if "fork" not in multiprocessing.get_all_start_methods():
        return
    context = multiprocessing.get_context("fork")
    for series, loop in ((False, chain.run_with_resets), (True, chain.sample_loop)):
        if not is_kept(loop):
            process = context.Process(target=_compile_series if series else _compile_plain, daemon=True)
            process.start()
            _underway[series] = os.getpid(), process


def wait_for_loops(series: bool) -> None:
    """Waits until the loops that a program needs can be loaded, if this process has begun them."""
    for which in (False, True)[: 1 + series]:
        beginner, process = _underway.pop(which, (0, None))
        if beginner == os.getpid():
            process.join()


def _compile_plain() -> None:
    from damper_estimator.model.program import compile_program
    from damper_estimator.model.stream import Stream
    from damper_estimator.signals.layout import ROWS

    stream = Stream(compile_program(()))
    stream.force(np.zeros((ROWS, 2)))


def _compile_series() -> None:
    addresses([chain.sample_loop], [])
