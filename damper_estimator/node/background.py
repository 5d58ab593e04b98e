"""Long work in another thread, while this thread continues to answer messages."""

import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import TypeVar

Result = TypeVar("Result")
# A thread that waits for the interpreter gets it after this time, s; the usual 5 ms would show in the latency.
SWITCH = 0.0005
PAUSE = 0.0002  # s between two checks for messages


def in_background(work: Callable[[], Result], serve: Callable[[], bool]) -> Result:
    """The result of ``work``, or its exception; ``serve`` answers waiting messages and returns whether there were
    any.
    """
    with _quick_switches(), ThreadPoolExecutor(1) as pool:
        future = pool.submit(work)
        while not future.done():
            if not serve():
                time.sleep(PAUSE)
        return future.result()


@contextmanager
def _quick_switches() -> Iterator[None]:
    before = sys.getswitchinterval()
    sys.setswitchinterval(SWITCH)
    try:
        yield
    finally:
        sys.setswitchinterval(before)
