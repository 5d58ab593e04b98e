"""Divides a recording into a part that parameters are found on and a part that is kept back to judge on.

Kept back are the last 40 %. Where these move faster, further, or at other commands than the rest, they would test how
well a model extrapolates, and a fit to the rest would not be the user's damper: a staircase of sines has its fast ones
at the end. Such a recording is divided into sections, as few as are necessary, and the last 40 % of each are kept back.

What happened before a part begins still acts in it: fields, gas and fluids remember for seconds. So models run over
some of the recording before each part, and nothing is judged there.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from damper_estimator.signals import Measurement
from damper_estimator.signals.layout import COMMAND, V, X

UNSEEN_SHARE = 0.4  # of each recording, where no other is given to judge on
_SECTIONS = (1, 2, 3, 5, 8)
_SHORTEST = 2.5  # s, of a section: a second is kept back
_BEYOND = 1.25  # times the speed, and the range of displacement and command, of the part that parameters are found on
_LEAD = 5.0  # s before a part, at most
_LEAD_SHARE = 0.5  # of the part, at most: it costs time
_TAIL = 0.005  # share of the samples at each end of a range that does not count


def divided(measurement: Measurement) -> tuple[Measurement, Measurement]:
    """The part that parameters are found on, and the part that is kept back; with gaps where there are sections."""
    seconds = measurement.kinematics.time[-1] - measurement.kinematics.time[0]
    for sections in _SECTIONS:
        early, late = _divided(measurement, sections)
        is_longest = seconds < 2.0 * _SHORTEST * sections
        if is_longest or not _goes_beyond(late, early):
            break
    return early, late


def all_divided(measurements: Sequence[Measurement]) -> tuple[list[Measurement], list[Measurement]]:
    """The parts of several recordings that parameters are found on, and the parts that are kept back."""
    pairs = [divided(measurement) for measurement in measurements]
    return [early for early, _ in pairs], [late for _, late in pairs]


def _divided(measurement: Measurement, sections: int) -> tuple[Measurement, Measurement]:
    ends = np.linspace(0, len(measurement.kinematics), sections + 1)
    found, kept = [], []
    for begin, end in zip(ends, ends[1:], strict=False):
        cut = round(end - UNSEEN_SHARE * (end - begin))
        found.append(slice(round(begin), cut))
        kept.append(slice(cut, round(end)))
    return _led(measurement, found), _led(measurement, kept)


def _led(measurement: Measurement, windows: Sequence[slice]) -> Measurement:
    """The windows with what leads to them, which may not reach into the one before."""
    time, end, parts = measurement.kinematics.time, 0, []
    judged = np.zeros_like(measurement.judged)
    for window in windows:
        begin = time[min(window.start, time.size - 1)]
        length = time[window.stop - 1] - begin if window.stop > window.start else 0.0
        first = int(np.searchsorted(time, begin - min(_LEAD, _LEAD_SHARE * length)))
        parts.append(slice(max(first, end), window.stop))
        judged[window] = measurement.judged[window]
        end = window.stop
    return replace(measurement, judged=judged).parts(parts)


def _goes_beyond(late: Measurement, early: Measurement) -> bool:
    """Whether the one drives what the other does not."""
    if not (early.judged.any() and late.judged.any()):
        return False
    if _fastest(late) > _BEYOND * _fastest(early):
        return True
    return any(_reaches_beyond(_range(late, row), _range(early, row)) for row in (X, COMMAND))


def _fastest(part: Measurement) -> float:
    return float(np.quantile(np.abs(part.kinematics.block[V, part.judged]), 1.0 - 2.0 * _TAIL))


def _range(part: Measurement, row: int) -> tuple[float, float] | None:
    """Lowest and highest value of a channel; None where it was not recorded."""
    values = part.kinematics.block[row, part.judged]
    values = values[np.isfinite(values)]
    return tuple(np.quantile(values, [_TAIL, 1.0 - _TAIL])) if values.size else None


def _reaches_beyond(late: tuple[float, float] | None, early: tuple[float, float] | None) -> bool:
    if late is None or early is None:
        return late is not None
    margin = (_BEYOND - 1.0) * (early[1] - early[0])
    return late[0] < early[0] - margin or late[1] > early[1] + margin
