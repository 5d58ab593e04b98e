"""Compiles the loops over a model in other processes while a recording is read, unless an earlier run kept them.

Reading compiles other functions. On two cores the loops, which take longest, are ready when they are needed, and
the workers of a diagnosis do not compile them again.
"""

import numpy as np

from damper_estimator.compiled import compile_in_background, wait_for
from damper_estimator.model import chain
from damper_estimator.model.kernels import addresses


def compile_loops_ahead() -> None:
    """Begins to compile the loops."""
    compile_in_background(chain.run_with_resets, _compile_plain)
    compile_in_background(chain.sample_loop, _compile_series)


def wait_for_loops(series: bool) -> None:
    """Waits until the loops that a program needs can be loaded, if this process has begun them."""
    wait_for(chain.run_with_resets, *([chain.sample_loop] if series else []))


def _compile_plain() -> None:
    from damper_estimator.model.program import compile_program
    from damper_estimator.model.stream import Stream
    from damper_estimator.signals.layout import ROWS

    stream = Stream(compile_program(()))
    stream.force(np.zeros((ROWS, 2)))


def _compile_series() -> None:
    addresses([chain.sample_loop], [])
