"""A drift of the zero: the same change whatever the motion."""

from dataclasses import dataclass

import numpy as np

from damper_estimator.signals import Measurement
from damper_estimator.validation.surrogate import Surrogate

_CERTAIN = 5.0  # standard errors
_ALIKE = 0.5  # by which the change in any direction and speed may differ from the whole, over it
_FEWEST = 20  # rows of one direction and speed


@dataclass(frozen=True)
class Drift:
    """How a recording's zero changes.

    Attributes:
        begin, end: s since the first sample, between which it changes most.
        change: N.
    """

    begin: float
    end: float
    change: float


def drift(m: Measurement, explained: Surrogate, index: int = 0) -> Drift | None:
    """The drift of recording ``index`` of a surrogate; None where it is within chance, or not the same everywhere.

    An effect of the motion that the curve does not contain seems to drift as well where the excitation changes over the
    recording, but then by different amounts in the two directions, or in fast and slow motion.
    """
    zero = explained.zeros[index]
    if zero is None:
        return None
    first, last, change, error = zero.change()
    if abs(change) <= _CERTAIN * error:
        return None
    begin, end = float(zero.knots[first]), float(zero.knots[last])
    rows = explained.rows[index]
    time = m.kinematics.time[rows] - m.kinematics.time[0]
    velocity = m.kinematics.velocity[rows]
    reach = 0.5 * float(zero.knots[1] - zero.knots[0])
    early, late = (np.abs(time - moment) <= reach for moment in (begin, end))
    fast = np.abs(velocity) > np.median(np.abs(velocity[early | late]))
    for direction in (velocity > 0.0, velocity < 0.0):
        for speed in (fast, ~fast):
            before, after = (
                explained.still[index][early & direction & speed],
                explained.still[index][late & direction & speed],
            )
            if min(before.size, after.size) < _FEWEST:
                continue
            if abs(float(after.mean() - before.mean()) - change) > _ALIKE * abs(change):
                return None
    return Drift(begin, end, change)
