"""How far an estimate can be trusted: the one rule for status and faults, live and off line.

    WARMING_UP     filter and model were reset, less than the model's settling time ago (`memory`; 0.2 s at least)
    DEGRADED       within that time a sample was dropped, late (a gap), jumped or was in doubt, the displacement stood
                   still although its sensor is noisy, the model gave no finite force, or the accelerometer of a fusion
                   was missed; a slow channel that the force
                   depends on is silent or holds a value that cannot be, or was so within the model's memory; the
                   displacement is so noisy that its velocity is uncertain by more than 0.05 m/s; or the model was never
                   identified
    EXTRAPOLATING  outside the region that the model was fitted on (for slow channels: now or within the model's
                   memory), or a slow channel that the force depends on is unknown
    GOOD           none of these; what stands first wins

A controller that sets the command itself needs to know whether it may act: ``trusted`` is the same status without what
the command's present value says of the region, because that value is about to be replaced.

Noise is told from motion by the third difference of the raw displacement (for white noise its variance is 20 sigma^2),
where the sampling is at least eight times the filter's cutoff, and carried through the filter: the standard deviation
of the velocity that white noise of sigma leaves behind the filter is 2 pi sigma (pi/3 dt cutoff^3)^(1/2). A third
difference far beyond that noise, and beyond what a wheel does, is an outlier and counts as a jump: a single sample that
is off by some millimetres is no faster than a damper, but the filter makes some 0.1 m/s of it.

A displacement that stands still is what a standing car gives, unless its sensor is noisy: then neighbouring samples
differ at rest as well. A sensor counts as noisy where small changes (a few of the smallest, which is its resolution)
often go to and fro from sample to sample (zigzags), which slow motion does not. How often neighbours are equal is
learnt from small changes; a run of equal values that is less likely than ``_UNLIKELY`` by that is a fault. The share
goes on being learnt until then, so that a sensor that mostly rests on one step of its resolution never comes so far.
"""

from math import pi, sqrt

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.runtime.record import (
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

JUMP_SPEED = 5.0  # m/s, faster than a damper moves
JUMP = 0.001  # m, smaller ones are noise or resolution
JUMP_JERK = 2.5e5  # m/s^3, twice that of a wheel in a pothole; a single outlier of the displacement looks worse
_OUTLIER = 6.0  # standard deviations of the noise, which is no outlier
LATE_STEP = 3.0  # typical steps that make a gap
NOISE = 0.05  # m/s, standard deviation of the velocity
_VELOCITY_NOISE = 2.0 * pi * sqrt(pi / 3.0)
_OVERSAMPLED = 0.125  # largest step times cutoff at which noise is told from motion
_THIRD_DIFFERENCE = 20.0
_FORGET = 0.02  # share of a new sample in the variance of the noise
_FOLLOW = 0.05  # and in the typical step
_SMALL = 5.0  # of the smallest changes, up to which a change is small
_GROW = 1.005  # of the smallest change per sample, so that one that was no step of the sensor is forgotten
_NOISY = 0.01  # share of zigzags among small changes from which on a sensor is noisy
_REMEMBERED = 400.0  # small changes, over which the share of zigzags is learnt
_LEARN = 0.01  # share of a new one at least in that of equal neighbours
_UNLIKELY = 1e-9


@compiled
def watch(own, stamp, value, verdict, suspect, alone, doubt, block, force, status, trusted, given):
    """Judges a block of samples in order of arrival; a block of one is the live case.

    Args:
        own: the damper's record.
        stamp: (n,) int64 ns; ``value``: (n,) m, raw; ``verdict``: (n,) int64, from ``admission.judge``.
        suspect: (n,) uint8, 1 if the sample is in doubt for what its numbers do not show.
        alone: (m,) uint8, 1 if the accelerometer that the motion should come from was missed.
        doubt: (m,) int64 ns for which the sample's slow channels leave the force in doubt; 0 if they are fine.
        block: (8, m) of the samples that are used; ``force``: (m,) N, the model's, perhaps not finite.
        status, trusted: (m,) uint8 output.
        given: (m,) N output: the force, where it is not finite the last finite one (0 before the first).
    """
    counts, settling = own["counts"], own["settling"]
    j = 0
    for i in range(stamp.size):
        counts[verdict[i]] += 1
        if verdict[i] >= DUPLICATE:
            if verdict[i] == NON_FINITE or verdict[i] == INVERSION:
                _fault(own, own["last"], settling)
            continue
        _follow(own, stamp[i], value[i], block[DT, j])
        if alone[j] != 0:
            _fault(own, stamp[i], settling)
        if doubt[j] > 0:
            _fault(own, stamp[i], doubt[j])
        if suspect[i] != 0:
            counts[SUSPECT] += 1
            _fault(own, stamp[i], settling)
        if np.isfinite(force[j]):
            own["given"] = force[j]
        else:
            counts[NOT_FINITE] += 1
            _fault(own, stamp[i], settling)
        given[j] = own["given"]
        _judge(own, stamp[i], block[:, j], status[j : j + 1], trusted[j : j + 1])
        counts[BY_STATUS + status[j]] += 1
        j += 1


@compiled
def _fault(own, stamp, lasts):
    """Degrades the estimates until ``lasts`` ns after a stamp."""
    own["fault"] = stamp
    own["degraded_until"] = max(own["degraded_until"], stamp + lasts)


@compiled
def _follow(own, stamp, value, step):
    """Takes one good sample into account."""
    own["last"] = stamp
    if step <= 0.0:
        own["started"] = own["degraded_until"] = own["outside_until"] = own["command_outside_until"] = stamp
        own["fault"] = stamp - 1
        own["raw"], own["first"], own["second"], own["known"] = value, 0.0, 0.0, 0.0
        own["step"] = own["steps"] = own["variance"] = 0.0
        return
    moved = value - own["raw"]
    # As if the steps were even: motion at a constant speed has no second difference.
    first = moved * own["step"] / step if own["step"] > 0.0 else moved
    second = first - own["first"]
    third = second - own["second"]
    noise = _OUTLIER * sqrt(_THIRD_DIFFERENCE * max(own["variance"], 0.0))
    usual = max(JUMP, JUMP_JERK * own["step"] ** 3, noise)
    has_jumped, is_late, is_outlier = abs(moved) > max(JUMP, JUMP_SPEED * step), False, False
    if own["step"] <= 0.0:
        own["step"] = step
    elif step > LATE_STEP * own["step"]:
        own["counts"][LATE] += 1
        is_late = True
    own["steps"] += 1.0  # the mean of the first, so that a single long one at the start does not hide later gaps
    own["step"] += max(_FOLLOW, 1.0 / own["steps"]) * (min(step, 2.0 * own["step"]) - own["step"])
    if own["known"] < 2.0:  # a third difference needs three good steps
        own["known"] += 1.0
    elif not has_jumped and not is_late:
        is_outlier = abs(third) > usual
        third = min(abs(third), usual)
        own["variance"] += _FORGET * (third * third / _THIRD_DIFFERENCE - own["variance"])
    if has_jumped or is_outlier:
        own["counts"][JUMPS] += 1
    if has_jumped or is_outlier or is_late:
        _fault(own, stamp, own["settling"])
        own["known"] = 0.0
    if _is_stuck(own, moved):
        own["counts"][STUCK] += 1
        _fault(own, stamp, own["settling"])
    own["raw"], own["first"], own["second"] = value, first, second


@compiled
def _is_stuck(own, moved):
    """Takes one change of the raw value; whether the present run of equal values is too long for the sensor's noise."""
    if moved != 0.0:
        own["likelihood"] = 1.0
        grown = _GROW * own["smallest"]
        own["smallest"] = abs(moved) if own["smallest"] <= 0.0 else min(grown, abs(moved))
    if own["likelihood"] < _UNLIKELY and own["zigzag"] > _NOISY:
        return True
    if abs(moved) > _SMALL * own["smallest"] or own["known"] < 2.0:
        return False
    own["small"] = min(own["small"] + 1.0, _REMEMBERED)
    share = 1.0 / (own["small"] + 1.0)
    own["equal"] += max(share, _LEARN) * ((1.0 if moved == 0.0 else 0.0) - own["equal"])
    if moved != 0.0:
        before = own["first"] - own["second"]
        is_zigzag = moved * own["first"] < 0.0 and own["first"] * before < 0.0
        own["zigzag"] += share * ((1.0 if is_zigzag else 0.0) - own["zigzag"])
        return False
    own["likelihood"] *= own["equal"]
    return own["zigzag"] > _NOISY and own["likelihood"] < _UNLIKELY


@compiled
def _judge(own, stamp, column, status, trusted):
    """Status of one sample, and the same without what the command says of the region."""
    outside, command_outside = _outside(own, stamp, column)
    trusted[0] = GOOD
    if stamp - own["started"] < own["settling"]:
        # A model that gives no force does not get better by waiting.
        trusted[0] = DEGRADED if own["fault"] == stamp else WARMING_UP
    elif stamp < own["degraded_until"] or own["identified"] == 0 or velocity_noise(own) > NOISE:
        trusted[0] = DEGRADED
    elif outside:
        trusted[0] = EXTRAPOLATING
    status[0] = EXTRAPOLATING if trusted[0] == GOOD and command_outside else trusted[0]


@compiled
def _outside(own, stamp, column):
    """Whether a sample lies outside the region of the fit; and whether its command alone does."""
    outside = False
    for row in range(COMMAND):
        if column[row] < own["bounds"][row, 0] or column[row] > own["bounds"][row, 1]:
            outside = True
    for row in range(len(SLOW)):
        value = column[COMMAND + row]
        if is_outside(own, row, value):
            until = stamp + own["memory"][row] + 1
            if row == 0 and not np.isnan(value):
                own["command_outside_until"] = max(own["command_outside_until"], until)
            else:
                own["outside_until"] = max(own["outside_until"], until)
    return outside or stamp < own["outside_until"], stamp < own["command_outside_until"]


@compiled
def velocity_noise(own):
    """Standard deviation in m/s of the velocity behind the filter, from the noise of the displacement; 0 if it
    cannot be told."""
    cutoff, step = own["noise_cutoff"], own["step"]
    if step * cutoff > _OVERSAMPLED:
        return 0.0
    return _VELOCITY_NOISE * sqrt(max(own["variance"], 0.0) * step * cutoff * cutoff * cutoff)


def bounds_of(region: dict[str, tuple[float, float]]) -> np.ndarray:
    """(8, 2): the region of a fit (lowest and highest value by name) as a record has it."""
    bounds = np.tile([-np.inf, np.inf], (ROWS, 1))
    for name, (low, high) in region.items():
        if name in REGION_ROWS:
            bounds[REGION_ROWS[name]] = low, high
    return bounds
