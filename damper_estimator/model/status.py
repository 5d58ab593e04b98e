"""How far an estimate can be trusted: the one rule for status and faults, live and off line.

    WARMING_UP     less than 0.2 s since the filter or the model started anew
    DEGRADED       in the last 0.2 s a sample was dropped, came late (a gap) or jumped, the model gave no finite force,
                   or the accelerometer of a fusion was missed; or the displacement is so noisy that its velocity is
                   uncertain by more than 0.05 m/s
    EXTRAPOLATING  outside the region that the model was fitted on, or without the command that it was fitted with
    GOOD           none of these; what stands first wins

Noise is told from motion by the third difference of the raw displacement (for white noise its variance is 20 sigma^2),
where the sampling is at least eight times the filter's cutoff, and carried through the filter: the standard deviation
of the velocity that white noise of sigma leaves behind the filter is 2 pi sigma (pi/3 dt cutoff^3)^(1/2).
"""

from math import pi, sqrt

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.signals.admission import DUPLICATE, INVERSION, NON_FINITE
from damper_estimator.signals.kinematics import WARM_UP
from damper_estimator.signals.layout import COMMAND, DT, TEMPERATURE, A, V, X

GOOD, WARMING_UP, EXTRAPOLATING, DEGRADED, STALE = range(5)
# Rows of the block by the name under which a fit records its region of validity.
REGION_ROWS = {"displacement": X, "velocity": V, "acceleration": A, "command": COMMAND, "temperature": TEMPERATURE}

# Integers that are carried: last accepted stamp, stamp of the start, whether there was a fault, and its stamp.
LAST, STARTED, FAULTY, FAULT = range(4)
MARKS = 4
# Numbers that are carried: typical step, last raw value and differences, variance of the noise, last finite force.
STEP, RAW, FIRST, SECOND, KNOWN, VARIANCE, HELD = range(7)
LEVELS = 7
# Counts beyond the verdicts (0 to 6) of ``signals.admission``; then one per status.
JUMPS, LATE, NOT_FINITE = range(NON_FINITE + 1, NON_FINITE + 4)
BY_STATUS = NOT_FINITE + 1
COUNTS = BY_STATUS + STALE + 1

SETTLED = round(WARM_UP * 1e9)  # ns
JUMP_SPEED = 5.0  # m/s, faster than a damper moves
JUMP = 0.001  # m, smaller ones are noise or resolution
LATE_STEP = 3.0  # typical steps that make a gap
NOISE = 0.05  # m/s, standard deviation of the velocity
_VELOCITY_NOISE = 2.0 * pi * sqrt(pi / 3.0)
_OVERSAMPLED = 0.125  # largest step times cutoff at which noise is told from motion
_THIRD_DIFFERENCE = 20.0
_FORGET = 0.02  # share of a new sample in the variance of the noise
_FOLLOW = 0.05  # and in the typical step


@compiled
def watch(cutoff, stamp, value, verdict, alone, block, force, bounds, marks, levels, counts, status, given):
    """Judges a block of samples in arrival order; a block of one is the live case.

    Args:
        cutoff: Hz of the filter, 0 for none, or where its velocity is not used.
        stamp: (n,) int64 ns; ``value``: (n,) m, raw; ``verdict``: (n,) int64, from ``admission.judge``.
        alone: (m,) uint8, 1 where the accelerometer that the motion should come from was missed.
        block: (8, m) of the samples that are used; ``force``: (m,) N, the model's, perhaps not finite.
        bounds: (8, 2) lowest and highest value of each row in the region of the fit; infinite where it has none.
        marks, levels: (4,) int64 and (7,), carried.
        counts: (COUNTS,) int64, added to.
        status: (m,) uint8 output.
        given: (m,) N output: the force, where it is not finite the last finite one (0 before the first).
    """
    j = 0
    for i in range(stamp.size):
        counts[verdict[i]] += 1
        if verdict[i] >= DUPLICATE:
            if verdict[i] == NON_FINITE or verdict[i] == INVERSION:
                marks[FAULTY], marks[FAULT] = 1, marks[LAST]
            continue
        _follow(cutoff, stamp[i], value[i], block[DT, j], marks, levels, counts)
        if alone[j]:
            marks[FAULTY], marks[FAULT] = 1, stamp[i]
        if np.isfinite(force[j]):
            levels[HELD] = force[j]
        else:
            counts[NOT_FINITE] += 1
            marks[FAULTY], marks[FAULT] = 1, stamp[i]
        given[j] = levels[HELD]
        status[j] = _status(cutoff, stamp[i], block[:, j], bounds, marks, levels)
        counts[BY_STATUS + status[j]] += 1
        j += 1


@compiled
def _follow(cutoff, stamp, value, step, marks, levels, counts):
    """Takes one good sample into account."""
    marks[LAST] = stamp
    if step <= 0.0:
        marks[STARTED], marks[FAULTY] = stamp, 0
        levels[RAW], levels[FIRST], levels[SECOND], levels[KNOWN], levels[STEP] = value, 0.0, 0.0, 0.0, 0.0
        levels[VARIANCE] = 0.0
        return
    first = value - levels[RAW]
    second = first - levels[FIRST]
    third = second - levels[SECOND]
    faulty = False
    if abs(first) > JUMP and abs(first) > JUMP_SPEED * step:
        counts[JUMPS] += 1
        faulty = True
    if levels[STEP] <= 0.0:
        levels[STEP] = step
    elif step > LATE_STEP * levels[STEP]:
        counts[LATE] += 1
        faulty = True
    levels[STEP] += _FOLLOW * (min(step, 2.0 * levels[STEP]) - levels[STEP])
    if faulty:
        marks[FAULTY], marks[FAULT] = 1, stamp
        levels[KNOWN] = 0.0
    elif levels[KNOWN] < 2.0:  # a third difference needs three good steps
        levels[KNOWN] += 1.0
    else:
        levels[VARIANCE] += _FORGET * (third * third / _THIRD_DIFFERENCE - levels[VARIANCE])
    levels[RAW], levels[FIRST], levels[SECOND] = value, first, second


@compiled
def _status(cutoff, stamp, column, bounds, marks, levels):
    if stamp - marks[STARTED] < SETTLED:
        # A model that gives no force does not get better by waiting.
        return DEGRADED if marks[FAULTY] and marks[FAULT] == stamp else WARMING_UP
    if marks[FAULTY]:
        if stamp - marks[FAULT] < SETTLED:
            return DEGRADED
        marks[FAULTY] = 0
    if velocity_noise(cutoff, levels) > NOISE:
        return DEGRADED
    for row in range(bounds.shape[0]):
        if column[row] < bounds[row, 0] or column[row] > bounds[row, 1]:
            return EXTRAPOLATING
    # Without the command that it was fitted with a model says nothing; an unknown temperature is no proof of another.
    if np.isnan(column[COMMAND]) and bounds[COMMAND, 0] > -np.inf:
        return EXTRAPOLATING
    return GOOD


@compiled
def velocity_noise(cutoff, levels):
    """Standard deviation in m/s of the velocity behind the filter, from the noise of the displacement; 0 where it
    cannot be told."""
    if levels[STEP] * cutoff > _OVERSAMPLED:
        return 0.0
    return _VELOCITY_NOISE * sqrt(max(levels[VARIANCE], 0.0) * levels[STEP] * cutoff * cutoff * cutoff)


def bounds_of(region: dict[str, tuple[float, float]]) -> np.ndarray:
    """(8, 2): the region of a fit (lowest and highest value by name) as ``watch`` takes it."""
    bounds = np.tile([-np.inf, np.inf], (TEMPERATURE + 2, 1))
    for name, (low, high) in region.items():
        if name in REGION_ROWS:
            bounds[REGION_ROWS[name]] = low, high
    return bounds
