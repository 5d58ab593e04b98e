"""Compiles parts of `Line.step` in other processes while a node starts, unless an earlier run kept them.

Two processes compile what takes longest, while this one imports ROS and prepares the models. `Line.add` waits for them.
"""

import numpy as np

from damper_estimator.compiled import compile_in_background
from damper_estimator.runtime.damper_record import SLOW, fresh_record
from damper_estimator.runtime.line import take_motion, take_slow
from damper_estimator.runtime.status import watch
from damper_estimator.signals.layout import ROWS

_WHOLE, _REAL, _FLAGS = np.zeros(0, np.int64), np.zeros(0), np.zeros(0, np.uint8)
_BLOCK = np.zeros((ROWS, 0))


def compile_line_ahead() -> None:
    """Begins to compile."""
    compile_in_background(watch, _compile_status)
    compile_in_background(take_motion, _compile_motion)


def _compile_status() -> None:
    (record,) = fresh_record()
    slow, received = np.zeros((0, len(SLOW), 1)), np.zeros((0, len(SLOW), 1), np.int64)
    watch(record, _WHOLE, _REAL, _WHOLE, _FLAGS, _FLAGS, _WHOLE, _BLOCK, _REAL, _FLAGS, _FLAGS, _REAL)
    take_slow(record, 0, _WHOLE, _WHOLE, slow, received, _BLOCK, _WHOLE)


def _compile_motion() -> None:
    (record,) = fresh_record()
    acceleration, stamp = np.zeros((0, 1)), np.zeros((0, 1), np.int64)
    take_motion(record, 0, _WHOLE, _WHOLE, _REAL, _REAL, acceleration, stamp, _BLOCK, _FLAGS)
