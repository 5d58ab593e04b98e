"""Spreads attempts over the machine's cores."""

import multiprocessing
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed

from damper_estimator.diagnosis.attempt import Attempt, attempt
from damper_estimator.diagnosis.candidates import Candidate
from damper_estimator.diagnosis.null import Null
from damper_estimator.model import wait_for_loops

_work: tuple[Null, Sequence[Candidate], float] | None = None  # what forked workers see without its being sent


def attempts(
    null: Null, candidates: Sequence[Candidate], worth: float, workers: int, progress: Callable[[int], None]
) -> list[Attempt]:
    """Tries all candidates; the result does not depend on ``workers``.

    Workers are forked from this process, so nothing is sent to them; where processes cannot be forked, or one worker
    is asked for, all is done here.

    Args:
        worth: see ``attempt``.
        progress: is told how many are done; what it raises ends the work.
    """
    global _work
    wait_for_loops(True)
    _ = null.frozen  # once, before the workers part
    # Compliances take longest, so they begin.
    order = sorted(range(len(candidates)), key=lambda i: candidates[i].effect.kind != "series")
    done: dict[int, Attempt] = {}
    if workers <= 1 or "fork" not in multiprocessing.get_all_start_methods():
        for i in order:
            done[i] = attempt(null, candidates[i], worth)
            progress(len(done))
        return [done[i] for i in range(len(candidates))]
    _work = (null, candidates, worth)
    try:
        with ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("fork")) as pool:
            futures = {pool.submit(_one, i): i for i in order}
            try:
                for future in as_completed(futures):
                    done[futures[future]] = future.result()
                    progress(len(done))
            except BaseException:
                pool.shutdown(wait=False, cancel_futures=True)
                raise
    finally:
        _work = None
    return [done[i] for i in range(len(candidates))]


def _one(i: int) -> Attempt:
    null, candidates, worth = _work
    return attempt(null, candidates[i], worth)
