"""Compiles the loop over a series while the model's own error is read, where no earlier run has kept it.

It takes as long as everything that is compiled until the first attempt. Done by one more process meanwhile, it costs
no time where there are two cores, and not every worker compiles it.
"""

import multiprocessing

from damper_estimator.compiled import COMPILED
from damper_estimator.model import chain
from damper_estimator.model.kernels import addresses

_underway: list = []


def compile_ahead(workers: int) -> None:
    """Begins; does nothing for a single worker, and where processes cannot be forked."""
    if COMPILED and workers > 1 and "fork" in multiprocessing.get_all_start_methods():
        process = multiprocessing.get_context("fork").Process(
            target=addresses, args=([chain.sample_loop], []), daemon=True
        )
        process.start()
        _underway.append(process)


def wait_for_loop() -> None:
    """Waits until the loop can be loaded, if it was begun."""
    while _underway:
        _underway.pop().join()
