"""Compiles `Line.step` in other processes while a node starts, unless an earlier run kept it.

One process compiles the loop over a model and the judgement of samples, the other what precedes them and then the step,
while this one imports ROS and prepares the models. `Line.add` waits for them.
"""

from time import monotonic, sleep

import numpy as np

from damper_estimator.compiled import compile_in_background, is_kept
from damper_estimator.model import chain
from damper_estimator.runtime import line
from damper_estimator.runtime.damper_record import SLOW, fresh_record
from damper_estimator.runtime.line import Line, take_motion, take_slow
from damper_estimator.runtime.line_arrays import LineInput, LineOutput
from damper_estimator.runtime.status import watch
from damper_estimator.signals.layout import ROWS

_WHOLE, _REAL, _FLAGS = np.zeros(0, np.int64), np.zeros(0), np.zeros(0, np.uint8)
_BLOCK = np.zeros((ROWS, 0))
_PATIENCE = 20.0  # s for the other process; without it this one compiles everything


def compile_line_ahead() -> None:
    """Begins to compile."""
    compile_in_background(watch, _compile_judgement)
    compile_in_background(line._step, _compile_step)


def _compile_judgement() -> None:
    (record,) = fresh_record()
    table, traces = np.zeros((0, chain.COLUMNS), np.int64), np.zeros((0, 0))
    # First, since preparing the models needs it as well.
    chain.run_with_resets(_WHOLE, table, _REAL, _REAL, _BLOCK, 1, 1, _REAL, 0, np.zeros(1), traces, _REAL)
    watch(record, _WHOLE, _REAL, _REAL, _WHOLE, _FLAGS, _FLAGS, _WHOLE, _BLOCK, _REAL, _FLAGS, _FLAGS, _REAL)


def _compile_step() -> None:
    (record,) = records = fresh_record()
    acceleration, stamp = np.zeros((0, 1)), np.zeros((0, 1), np.int64)
    take_motion(record, 0, _WHOLE, _WHOLE, _REAL, _REAL, acceleration, stamp, _BLOCK, _FLAGS)
    slow, received = np.zeros((0, len(SLOW), 1)), np.zeros((0, len(SLOW), 1), np.int64)
    take_slow(record, 0, _WHOLE, _WHOLE, slow, received, _BLOCK, _WHOLE)
    end = monotonic() + _PATIENCE
    while not is_kept(watch) and monotonic() < end:
        sleep(0.02)
    empty, one, other = Line(), LineInput.empty(1, 1), LineOutput.empty(1, 1)
    program = _WHOLE, empty._table, empty._parameters, empty._constants, empty._states
    absent, number = np.zeros(1, bool), np.ones(1)
    line._step(0, number, absent, False, number, number, absent, *program, records, *one.arrays(), *other.arrays())
