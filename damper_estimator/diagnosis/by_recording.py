"""Recordings judge one by one: what an effect leaves is the geometric mean of what it leaves in each of them.

    log left = sum_r w_r log((S_r + e_r) / (S_0r + e_r)),      w_r ~ min(duration, 20 s)

S and S_0 are squared errors with the effect and without. Their sum over recordings would be the error on the largest
forces alone: a test of small strokes, driven to break a tie, has a hundredth of the squared error of a rough road. e_r
is what no effect is asked to explain, so that a recording at rest does not decide.

An explanation that raises the error of many recordings is contradicted by them, however much of another one it
explains: it does something on that motion that the model gets wrong, and is not what is missing.

Recordings of different motion are independent, because a form that is not quite the damper's errs otherwise
in each. Of recordings with weights w and distributions p_r over the cells of motion, command and temperature, so many
count as independent:

    n = 1 / sum_rs w_r w_s o_rs,      o_rs = sum over the cells of min(p_r, p_s)
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.identification.rows import Rows
from damper_estimator.signals.layout import COMMAND, TEMPERATURE, A, V, X

_WHOLE = 20.0  # s, from which on a recording counts fully
_CELLS = 6  # over the driven range of each variable
_VARIABLES = X, V, A, COMMAND, TEMPERATURE
_MOST = 2.0  # independent recordings: what is wrong with a form shows on every motion to some extent


@dataclass(frozen=True)
class ByRecording:
    """Which rows are whose.

    Attributes:
        rows: (r,) int, the recording of each row.
        weight: (recordings,) of each one's judgement, 1 together.
    """

    rows: np.ndarray
    weight: np.ndarray

    def squares(self, values: np.ndarray) -> np.ndarray:
        """(recordings,) sums of squares of rows (r,)."""
        return np.bincount(self.rows, values**2, minlength=self.weight.size)

    def left(self, after: np.ndarray, before: np.ndarray, ignored: float) -> np.ndarray:
        """(...,) share of the squared error that is left, of sums of squares (..., recordings) after and before.

        Args:
            ignored: N^2 of each row that no effect is asked to explain; it plays no part if there is one recording.
        """
        if self.weight.size == 1:
            return after[..., 0] / np.maximum(before[..., 0], 1e-300)
        return np.exp(np.log(self._shares(after, before, ignored)) @ self.weight)

    def worsened(self, after: np.ndarray, before: np.ndarray, ignored: float) -> float:
        """Weight of the recordings whose squared error rises by more than ``limits().worse``; 0 if there is one."""
        if self.weight.size == 1:
            return 0.0
        return float(self.weight[self._shares(after, before, ignored) > limits().worse].sum())

    def _shares(self, after: np.ndarray, before: np.ndarray, ignored: float) -> np.ndarray:
        floor = ignored * np.bincount(self.rows, minlength=self.weight.size) + 1e-300
        return (after + floor) / (before + floor)


def by_recording(rows: Sequence[Rows]) -> ByRecording:
    """The recordings of some rows; windows of one recording belong together."""
    names = [part.measurement.recording for part in rows]
    order = {name: k for k, name in enumerate(dict.fromkeys(names))}
    seconds = np.zeros(len(order))
    for part, name in zip(rows, names, strict=True):
        seconds[order[name]] += part.picks.size / part.rate
    weight = np.minimum(seconds, _WHOLE)
    owner = np.repeat([order[name] for name in names], [part.picks.size for part in rows])
    return ByRecording(owner, weight / weight.sum())


def independent(rows: Sequence[Rows]) -> float:
    """n, for how many independent recordings those of some rows count; 1 to 2."""
    apart = by_recording(rows)
    if apart.weight.size == 1:
        return 1.0
    blocks = np.hstack([part.measurement.kinematics.block[:, part.picks] for part in rows])
    cells = np.zeros(blocks.shape[1], int)
    for row in _VARIABLES:
        values = np.nan_to_num(blocks[row])
        low, high = np.quantile(values, [0.001, 0.999])
        place = np.clip((values - low) / max(high - low, 1e-12) * _CELLS, 0.0, _CELLS - 1.0)
        cells = cells * _CELLS + place.astype(int)
    cell = np.unique(cells, return_inverse=True)[1]
    count = np.zeros((apart.weight.size, cell.max() + 1))
    np.add.at(count, (apart.rows, cell), 1.0)
    share = count / count.sum(axis=1, keepdims=True)
    alike = np.array([np.minimum(share, one).sum(axis=1) for one in share])
    return float(min(1.0 / (apart.weight @ alike @ apart.weight), _MOST))
