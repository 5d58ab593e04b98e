"""Fits all hypotheses, spread over the machine's cores."""

import multiprocessing
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import replace

import numpy as np

from damper_estimator.diagnosis.baseline import Baseline
from damper_estimator.diagnosis.hypotheses import Hypothesis
from damper_estimator.diagnosis.trial_fit import TrialFit, trial_fit
from damper_estimator.model import wait_for_loops

WORTH = 0.03  # of the squared error: what explains less by itself gets no derivatives

BEHIND = 4.0
"""Times the squared error that the best of all others leaves: a compliance that leaves more on excerpts is not tied
with it, and is not fitted to the end.
"""

_work: tuple[Baseline, Sequence[Hypothesis], float, float] | None = None  # what forked workers see: it is not sent


def all_fitted(
    baseline: Baseline,
    hypotheses: Sequence[Hypothesis],
    worth: float,
    workers: int,
    progress: Callable[[int], None],
    most: float = 1.0,
) -> list[Hypothesis]:
    """The hypotheses with their trial fits; the result does not depend on ``workers``.

    Workers are forked from this process, so nothing is sent to them; where processes cannot be forked, or one worker
    is asked for, all is done here.

    Args:
        worth, most: see ``trial_fit``; without ``worth``, every one is fitted to the end.
        progress: gets the number of those that are done; what it raises ends the work.
    """
    wait_for_loops(True)
    _ = baseline.recorded, baseline.recorded_inside, baseline.recorded_beside_oil  # once, before the workers part
    series = [i for i, one in enumerate(hypotheses) if one.effect.kind == "series"]
    others = [i for i, one in enumerate(hypotheses) if one.effect.kind != "series"]
    done: dict[int, TrialFit] = {}
    _fitted(baseline, hypotheses, others, (worth, most), workers, done, progress)
    if worth > 0.0:  # compliances take longest: how well the others do limits what is worth their time
        before = float(np.sum(baseline.residual_fit**2))
        left = (float(np.sum((baseline.residual_fit + done[i].change_fit) ** 2)) for i in others)
        most = min(most, BEHIND * min(left, default=before) / max(before, 1e-300))
    _fitted(baseline, hypotheses, series, (worth, most), workers, done, progress)
    return [replace(hypothesis, fit=done[i]) for i, hypothesis in enumerate(hypotheses)]


def _fitted(
    baseline: Baseline,
    hypotheses: Sequence[Hypothesis],
    order: Sequence[int],
    shares: tuple[float, float],
    workers: int,
    done: dict[int, TrialFit],
    progress: Callable[[int], None],
) -> None:
    global _work
    if workers <= 1 or "fork" not in multiprocessing.get_all_start_methods():
        for i in order:
            done[i] = trial_fit(baseline, hypotheses[i], shares[0], most=shares[1])
            progress(len(done))
        return
    _work = (baseline, hypotheses, *shares)
    try:
        _in_processes(order, workers, done, progress)
    finally:
        _work = None


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
    baseline, hypotheses, worth, most = _work
    return trial_fit(baseline, hypotheses[i], worth, most=most)
