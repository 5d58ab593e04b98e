"""Fits all hypotheses, spread over the machine's cores."""

import multiprocessing
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import replace

from damper_estimator.diagnosis.baseline import Baseline
from damper_estimator.diagnosis.hypotheses import Hypothesis
from damper_estimator.diagnosis.trial_fit import TrialFit, trial_fit
from damper_estimator.model import wait_for_loops

WORTH = 0.03  # of the squared error: what explains less by itself gets no derivatives

_work: tuple[Baseline, Sequence[Hypothesis], float] | None = None  # what forked workers see without its being sent


def all_fitted(
    baseline: Baseline, hypotheses: Sequence[Hypothesis], worth: float, workers: int, progress: Callable[[int], None]
) -> list[Hypothesis]:
    """The hypotheses with their trial fits; the result does not depend on ``workers``.

    Workers are forked from this process, so nothing is sent to them; where processes cannot be forked, or one worker
    is asked for, all is done here.

    Args:
        worth: see ``trial_fit``.
        progress: gets the number of those that are done; what it raises ends the work.
    """
    global _work
    wait_for_loops(True)
    _ = baseline.recorded, baseline.recorded_inside, baseline.recorded_beside_oil  # once, before the workers part
    # Compliances take longest, so they begin.
    order = sorted(range(len(hypotheses)), key=lambda i: hypotheses[i].effect.kind != "series")
    done: dict[int, TrialFit] = {}
    if workers <= 1 or "fork" not in multiprocessing.get_all_start_methods():
        for i in order:
            done[i] = trial_fit(baseline, hypotheses[i], worth)
            progress(len(done))
    else:
        _work = (baseline, hypotheses, worth)
        try:
            _in_processes(order, workers, done, progress)
        finally:
            _work = None
    return [replace(hypothesis, fit=done[i]) for i, hypothesis in enumerate(hypotheses)]


def _in_processes(
    order: Sequence[int], workers: int, done: dict[int, TrialFit], progress: Callable[[int], None]
) -> None:
    with ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("fork")) as pool:
        futures = {pool.submit(_one, i): i for i in order}
        try:
            for future in as_completed(futures):
                done[futures[future]] = future.result()
                progress(len(done))
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _one(i: int) -> TrialFit:
    baseline, hypotheses, worth = _work
    return trial_fit(baseline, hypotheses[i], worth)
