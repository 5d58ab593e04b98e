"""How far an estimate can be trusted: the one rule for status and faults, live and offline.

    WARMING_UP     filter and model were reset, less than the model's settling time ago (`memory`; 0.2 s at least)
    DEGRADED       within that time a sample was dropped, late (a gap), jumped or was doubtful, the displacement was
                   constant although its sensor is noisy, the model's force was not finite, or the accelerometer of a
                   fusion was missing; a slow channel that the force depends on is silent or implausible, or was so
                   within the model's memory; the displacement is so noisy that its velocity is uncertain by more than
                   0.05 m/s; or the model was never identified
    EXTRAPOLATING  outside the region that the model was fitted on (for slow channels: now or within the model's
                   memory), or a slow channel that the force depends on is unknown
    GOOD           none of these; the first that applies counts

A controller that sets the command itself needs to know whether it can act: ``trusted`` is the same status regardless of
whether the present command lies in the region, because that value is about to be replaced.

Noise is separated from motion by the third difference of the raw displacement (for white noise its variance is
20 sigma^2), if the sampling is at least eight times the filter's cutoff, and propagated through the filter: the
standard deviation of the velocity after the filter, for white noise of sigma, is 2 pi sigma (pi/3 dt cutoff^3)^(1/2). A
third difference far beyond that noise, and beyond that of a wheel, is an outlier and counts as a jump: a single sample
that is wrong by some millimetres is no faster than a damper, but the filter turns it into some 0.1 m/s.

A constant displacement means a standing car, unless its sensor is noisy: then neighbouring samples differ at rest as
well. A sensor counts as noisy if small changes (a few of the smallest, which is its resolution) often alternate from
sample to sample (zigzags), which slow motion does not cause. The share of equal neighbours is learnt from small
changes; a run of equal values that is less likely than ``_UNLIKELY`` by that share is a fault. The share is learnt
until then, so that a sensor that mostly rests on one step of its resolution never reaches this limit.
"""

from math import pi, sqrt

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.runtime.damper_record import (
    BY_STATUS,
    DEGRADED,
    EXTRAPOLATING,
    GOOD,
    JUMPS,
    LATE,
    NOT_FINITE,
    REGION_ROWS,
    SLOW,
    STUCK,
    SUSPECT,
    WARMING_UP,
)
from damper_estimator.runtime.slow import is_outside
from damper_estimator.signals.admission import DUPLICATE, INVERSION, NON_FINITE
from damper_estimator.signals.layout import COMMAND, DT, ROWS
from damper_estimator.signals.possible import SMALL

JUMP_SPEED = 5.0  # m/s, faster than a damper moves
JUMP_JERK = 2.5e5  # m/s^3, twice that of a wheel in a pothole; a single outlier of the displacement exceeds it
_OUTLIER = 6.0  # standard deviations of the noise
LATE_STEP = 3.0  # typical steps that make a gap
NOISE = 0.05  # m/s, standard deviation of the velocity
_VELOCITY_NOISE = 2.0 * pi * sqrt(pi / 3.0)
_OVERSAMPLED = 0.125  # largest step times cutoff at which noise can be separated from motion
_THIRD_DIFFERENCE = 20.0
_FORGET = 0.02  # share of a new sample in the variance of the noise
_FOLLOW = 0.05  # share of a new step in the typical step
_SMALL = 5.0  # times the smallest change, up to which a change is small
_GROW = 1.005  # growth of the smallest change per sample, so that one below the sensor's resolution is forgotten
_NOISY = 0.01  # share of zigzags among small changes above which a sensor is noisy
_REMEMBERED = 400.0  # small changes, over which the share of zigzags is learnt
_LEARN = 0.01  # smallest share of a new change in that of equal neighbours
_UNLIKELY = 1e-9


@compiled
def watch(record, stamp, value, used, verdict, suspect, alone, doubt, block, force, status, trusted, published):
    """Judges a block of samples in order of arrival; a block of one is the live case.

    Args:
        record: of the damper.
        stamp: (n,) int64 ns; ``value``: (n,) m, raw; ``verdict``: (n,) int64, from ``admission.judge``.
        used: (m,) m, what was used of it (``signals.possible``).
        suspect: (n,) uint8, 1 if the sample is doubtful for a reason outside the line.
        alone: (m,) uint8, 1 if the accelerometer of a fusion was missing.
        doubt: (m,) int64 ns for which the sample's slow channels make the force doubtful; 0 if they are good.
        block: (8, m) of the used samples; ``force``: (m,) N, the model's, possibly not finite.
        status, trusted: (m,) uint8 output.
        published: (m,) N output: the force; if it is not finite, the last finite one (0 before the first).
    """
    counts, settling = record["counts"], record["settling"]
    j = 0
    for i in range(stamp.size):
        counts[verdict[i]] += 1
        if verdict[i] >= DUPLICATE:
            if verdict[i] == NON_FINITE or verdict[i] == INVERSION:
                _fault(record, record["last"], settling)
            continue
        _follow(record, stamp[i], value[i], block[DT, j])
        if alone[j] != 0 or used[j] != value[i]:
            _fault(record, stamp[i], settling)
        if doubt[j] > 0:
            _fault(record, stamp[i], doubt[j])
        if suspect[i] != 0:
            counts[SUSPECT] += 1
            _fault(record, stamp[i], settling)
        if np.isfinite(force[j]):
            record["given"] = force[j]
        else:
            counts[NOT_FINITE] += 1
            _fault(record, stamp[i], settling)
        published[j] = record["given"]
        _judge(record, stamp[i], block[:, j], status[j : j + 1], trusted[j : j + 1])
        counts[BY_STATUS + status[j]] += 1
        j += 1


@compiled
def _fault(record, stamp, lasts):
    """Degrades the estimates until ``lasts`` ns after a stamp."""
    record["fault"] = stamp
    record["degraded_until"] = max(record["degraded_until"], stamp + lasts)


@compiled
def _follow(record, stamp, value, step):
    """Updates the record with one good sample."""
    record["last"] = stamp
    if step <= 0.0:
        record["started"] = record["degraded_until"] = record["outside_until"] = record["command_outside_until"] = stamp
        record["fault"] = stamp - 1
        record["raw"], record["first"], record["second"], record["known"] = value, 0.0, 0.0, 0.0
        record["step"] = record["steps"] = record["variance"] = 0.0
        return
    moved = value - record["raw"]
    # Scaled to even steps: motion at a constant speed has no second difference.
    first = moved * record["step"] / step if record["step"] > 0.0 else moved
    second = first - record["first"]
    third = second - record["second"]
    noise = _OUTLIER * sqrt(_THIRD_DIFFERENCE * max(record["variance"], 0.0))
    usual = max(SMALL, JUMP_JERK * record["step"] ** 3, noise)
    has_jumped, is_late, is_outlier = abs(moved) > max(SMALL, JUMP_SPEED * step), False, False
    if record["step"] <= 0.0:
        record["step"] = step
    elif step > LATE_STEP * record["step"]:
        record["counts"][LATE] += 1
        is_late = True
    record["steps"] += 1.0  # a mean at first, so that a single long step at the start does not hide later gaps
    record["step"] += max(_FOLLOW, 1.0 / record["steps"]) * (min(step, 2.0 * record["step"]) - record["step"])
    if record["known"] < 2.0:  # a third difference needs three good steps
        record["known"] += 1.0
    elif not has_jumped and not is_late:
        is_outlier = abs(third) > usual
        third = min(abs(third), usual)
        record["variance"] += _FORGET * (third * third / _THIRD_DIFFERENCE - record["variance"])
    if has_jumped or is_outlier:
        record["counts"][JUMPS] += 1
    if has_jumped or is_outlier or is_late:
        _fault(record, stamp, record["settling"])
        record["known"] = 0.0
    if _is_stuck(record, moved):
        record["counts"][STUCK] += 1
        _fault(record, stamp, record["settling"])
    record["raw"], record["first"], record["second"] = value, first, second


@compiled
def _is_stuck(record, moved):
    """Takes one change of the raw value; returns whether the run of equal values is too long for the sensor's noise."""
    if moved != 0.0:
        record["likelihood"] = 1.0
        grown = _GROW * record["smallest"]
        record["smallest"] = abs(moved) if record["smallest"] <= 0.0 else min(grown, abs(moved))
    if record["likelihood"] < _UNLIKELY and record["zigzag"] > _NOISY:
        return True
    if abs(moved) > _SMALL * record["smallest"] or record["known"] < 2.0:
        return False
    record["small"] = min(record["small"] + 1.0, _REMEMBERED)
    share = 1.0 / (record["small"] + 1.0)
    record["equal"] += max(share, _LEARN) * ((1.0 if moved == 0.0 else 0.0) - record["equal"])
    if moved != 0.0:
        before = record["first"] - record["second"]
        is_zigzag = moved * record["first"] < 0.0 and record["first"] * before < 0.0
        record["zigzag"] += share * ((1.0 if is_zigzag else 0.0) - record["zigzag"])
        return False
    record["likelihood"] *= record["equal"]
    return record["zigzag"] > _NOISY and record["likelihood"] < _UNLIKELY


@compiled
def _judge(record, stamp, column, status, trusted):
    """Status of one sample, and the same regardless of the command's region."""
    outside, command_outside = _outside(record, stamp, column)
    trusted[0] = GOOD
    if stamp - record["started"] < record["settling"]:
        # Waiting does not help a model without a finite force.
        trusted[0] = DEGRADED if record["fault"] == stamp else WARMING_UP
    elif stamp < record["degraded_until"] or record["identified"] == 0 or velocity_noise(record) > NOISE:
        trusted[0] = DEGRADED
    elif outside:
        trusted[0] = EXTRAPOLATING
    status[0] = EXTRAPOLATING if trusted[0] == GOOD and command_outside else trusted[0]


@compiled
def _outside(record, stamp, column):
    """Whether a sample lies outside the region of the fit, and whether only its command does."""
    outside = False
    for row in range(COMMAND):
        if column[row] < record["bounds"][row, 0] or column[row] > record["bounds"][row, 1]:
            outside = True
    for row in range(len(SLOW)):
        value = column[COMMAND + row]
        if is_outside(record, row, value):
            until = stamp + record["memory"][row] + 1
            if row == 0 and not np.isnan(value):
                record["command_outside_until"] = max(record["command_outside_until"], until)
            else:
                record["outside_until"] = max(record["outside_until"], until)
    return outside or stamp < record["outside_until"], stamp < record["command_outside_until"]


@compiled
def velocity_noise(record):
    """Standard deviation in m/s of the velocity after the filter, from the noise of the displacement; 0 if it is
    unknown.
    """
    cutoff, step = record["noise_cutoff"], record["step"]
    if step * cutoff > _OVERSAMPLED:
        return 0.0
    return _VELOCITY_NOISE * sqrt(max(record["variance"], 0.0) * step * cutoff * cutoff * cutoff)


def bounds_of(region: dict[str, tuple[float, float]]) -> np.ndarray:
    """(8, 2): the region of a fit (lowest and highest value by name) for a record."""
    bounds = np.tile([-np.inf, np.inf], (ROWS, 1))
    for name, (low, high) in region.items():
        if name in REGION_ROWS:
            bounds[REGION_ROWS[name]] = low, high
    return bounds
