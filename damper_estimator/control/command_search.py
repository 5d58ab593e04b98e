"""Searches the command for a desired force on a copy of a model's state (compiled).

The force over the command, F(s) with s = (command - lowest) / (highest - lowest) from 0 to 1, is known at both ends;
in between, a cubic with the shape of the previous sample gives the first trial, cubics through the results the next
ones. Beyond the forces of both ends the damper is at a limit, unless F has an extremum inside: a trial close to the
better end, or at the last extremum, reveals it, and parabolas follow it. A dip narrower than a twentieth of the range
is missed, as is a second extremum.
"""

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.model import chain
from damper_estimator.signals.layout import COMMAND, DT, A, T, V, X

# Indices of the results; forces in N.
FORCE, EXPECTED, CURRENT, LOWEST, HIGHEST, SLOPE_CURRENT, SLOPE_VELOCITY, EVALUATIONS, REACHED = range(9)
RESULTS = 9
# Indices of the memory between samples: largest difference of the ends so far, last command, shape of F(s), and the
# position of an extremum between the ends (0: none).
SPAN, LAST, BEND, TWIST, EXTREMUM = range(5)
MEMORY = 5

CLOSE = 0.007
"""Tolerance of the search, relative to the difference of both ends' forces."""
FLAT = 1e-3
"""Relative to the largest difference so far: below it the command has no influence at this motion."""
NARROW = 0.5
"""Relative to the largest difference so far: below it a desired force out of reach gets only a share of the current,
because a slow coil keeps its field beyond the reversal; the share falls with the difference (docs/control.md)."""
SPEED = 1e-4
"""m/s, difference behind dF/dv."""
_NEAR_END = 0.05
_TRIALS = 12


@compiled
def force_at(machine, sample, command, state, trial):
    """Force in N of one sample (8, 1) under a command, from a copy of the state."""
    kernels, table, parameters, settings, motions, forces, solvers, trace = machine
    trial[:] = state
    sample[COMMAND, 0] = command
    chain.run(kernels, table, parameters, settings, sample, motions, forces, trial, solvers, trace)
    return forces[0, 0]


@compiled
def look_ahead(sample, horizon, lead, ahead):
    """Writes a sample to ``ahead`` (8, 1): a step of ``horizon`` s, the motion after ``lead`` s, acceleration held."""
    ahead[:, 0] = sample[:, 0]
    ahead[T, 0] = sample[T, 0] + horizon
    ahead[DT, 0] = horizon
    ahead[X, 0] = sample[X, 0] + lead * (sample[V, 0] + 0.5 * lead * sample[A, 0])
    ahead[V, 0] = sample[V, 0] + lead * sample[A, 0]


@compiled
def advance(machine, sample, state):
    """Advances the state by a sample (8, 1), from zero if its step is 0; returns the force in N."""
    kernels, table, parameters, settings, motions, forces, solvers, trace = machine
    if sample[DT, 0] <= 0.0:
        state[:] = 0.0
    chain.run(kernels, table, parameters, settings, sample, motions, forces, state, solvers, trace)
    return forces[0, 0]


@compiled
def invert(
    kernels, table, parameters, settings, motions, forces, solvers, trace, sample, is_new, ahead, state, trial, limits,
    reach, wanted, with_slope, memory, out,
):  # fmt: skip
    """Processes a sample and finds the command.

    Args:
        kernels, table, parameters, settings, motions, forces, solvers, trace: as ``chain.run`` takes them, for one
            sample; combined to one tuple here, because passing a tuple from Python takes 50 us.
        sample, ahead: (8, 1); the second is overwritten.
        is_new: whether the sample is new; another desired force at the same sample uses the same state.
        state: (z,), moved on by the sample alone; ``trial``: (z,) work space.
        limits: (2,) lowest and highest command.
        reach: (2,) s, horizon and lead of ``look_ahead``.
        wanted: N; NaN if there is no desired force.
        with_slope: whether to compute the slope over velocity.
        memory: (MEMORY,), carried.
        out: (RESULTS,), receives the answer.
    """
    machine = (kernels, table, parameters, settings, motions, forces, solvers, trace)
    if is_new:
        out[FORCE] = advance(machine, sample, state)
    look_ahead(sample, reach[0], reach[1], ahead)
    low = force_at(machine, ahead, limits[0], state, trial)
    high = force_at(machine, ahead, limits[1], state, trial)
    out[EVALUATIONS] = 3.0 if is_new else 2.0
    out[LOWEST], out[HIGHEST] = min(low, high), max(low, high)
    memory[SPAN] = max(memory[SPAN], abs(high - low))
    out[EXPECTED] = out[SLOPE_VELOCITY] = np.nan
    tolerance = max(CLOSE * abs(high - low), 1e-4 * memory[SPAN])
    if np.isfinite(low + high + wanted):
        _search(machine, ahead, state, trial, limits, wanted, tolerance, low, high, memory, out)
    else:
        out[CURRENT], out[SLOPE_CURRENT] = np.nan, (high - low) / (limits[1] - limits[0])
    out[REACHED] = 1.0 if abs(out[EXPECTED] - wanted) <= max(tolerance, FLAT * memory[SPAN]) else 0.0
    if with_slope:
        _velocity_slope(machine, ahead, state, trial, out, sample[COMMAND, 0])


@compiled
def _search(machine, ahead, state, trial, limits, wanted, tolerance, low, high, memory, out):
    """Chooses the method by the forces at both ends."""
    if wanted < out[LOWEST] - tolerance or wanted > out[HIGHEST] + tolerance:
        _beyond(machine, ahead, state, trial, limits, wanted, tolerance, low, high, memory, out)
    elif abs(high - low) <= FLAT * memory[SPAN]:
        # Every command gives this force: keeping the last one avoids chatter.
        last = memory[LAST] if np.isfinite(memory[LAST]) else limits[0]
        _answer(limits, (last - limits[0]) / (limits[1] - limits[0]), low, high - low, memory, out)
    else:
        _between(machine, ahead, state, trial, limits, wanted, tolerance, 0.0, low, 1.0, high, memory, out)


@compiled
def _velocity_slope(machine, ahead, state, trial, out, command):
    """dF/dv at the chosen command, or at the present one if none was chosen."""
    chosen = np.isfinite(out[CURRENT])
    if not chosen:
        out[EXPECTED] = force_at(machine, ahead, command, state, trial)
        out[EVALUATIONS] += 1.0
    ahead[V, 0] += SPEED
    force = force_at(machine, ahead, out[CURRENT] if chosen else command, state, trial)
    out[EVALUATIONS] += 1.0
    out[SLOPE_VELOCITY] = (force - out[EXPECTED]) / SPEED


@compiled
def _answer(limits, share, force, slope, memory, out):
    """Writes the command at a share of the range, the force there and dF/ds."""
    share = min(max(share, 0.0), 1.0)
    out[CURRENT] = limits[0] + share * (limits[1] - limits[0])
    out[EXPECTED] = force
    out[SLOPE_CURRENT] = slope / (limits[1] - limits[0])
    memory[LAST] = out[CURRENT]


@compiled
def _try(machine, ahead, state, trial, limits, share, out):
    """Force at a share of the range; counts the evaluation and extends the known interval."""
    force = force_at(machine, ahead, limits[0] + share * (limits[1] - limits[0]), state, trial)
    out[EVALUATIONS] += 1.0
    out[LOWEST], out[HIGHEST] = min(out[LOWEST], force), max(out[HIGHEST], force)
    return force


@compiled
def _rise(t, bend, twist):
    """The shape of F between both ends: t + t (t - 1) (bend + twist t), 0 at 0 and 1 at 1."""
    return t + t * (t - 1.0) * (bend + twist * t)


@compiled
def _place(part, bend, twist, a, b):
    """Where the shape has the value ``part`` between a and b; NaN if it is not reached there."""
    low, high = _rise(a, bend, twist) - part, _rise(b, bend, twist) - part
    if low * high > 0.0:
        return np.nan
    for _ in range(20):
        middle = 0.5 * (a + b)
        value = _rise(middle, bend, twist) - part
        if (value > 0.0) == (high > 0.0):
            b = middle
        else:
            a = middle
    return 0.5 * (a + b)


@compiled
def _between(machine, ahead, state, trial, limits, wanted, tolerance, start, force_start, end, force_end, memory, out):
    """The desired force lies between those at the shares start and end: cubics, bisection if they fail.

    The shape of F over the whole range is remembered from the previous sample and updated by the last two trials.
    """
    whole = abs(end - start) == 1.0
    bend, twist = (memory[BEND], memory[TWIST]) if whole else (0.0, 0.0)
    rise, width = force_end - force_start, end - start
    part = (wanted - force_start) / rise
    a, b = 0.0, 1.0
    t, force = (0.0, force_start) if abs(force_start - wanted) < abs(force_end - wanted) else (1.0, force_end)
    before, before_height = 0.0, 0.0
    count = 0
    while abs(force - wanted) > tolerance and count < _TRIALS:
        t = _place(part, bend, twist, a, b) if count % 4 < 3 else np.nan
        margin = 0.01 * (b - a)
        t = min(max(t, a + margin), b - margin) if np.isfinite(t) else 0.5 * (a + b)
        force = _try(machine, ahead, state, trial, limits, start + t * width, out)
        height = ((force - force_start) / rise - t) / (t * (t - 1.0))
        if count > 0 and abs(t - before) > 1e-3:
            twist = (height - before_height) / (t - before)
        bend = height - twist * t
        before, before_height = t, height
        if (force > wanted) == (rise > 0.0):
            b = t
        else:
            a = t
        count += 1
    if whole and count > 0:
        memory[BEND], memory[TWIST] = min(max(bend, -3.0), 3.0), min(max(twist, -3.0), 3.0)
    slope = rise / width * (1.0 + (2.0 * t - 1.0) * (bend + twist * t) + t * (t - 1.0) * twist)
    _answer(limits, start + t * width, force, slope, memory, out)


@compiled
def _peak(a, force_a, m, force_m, b, force_b):
    """Place and height of the extremum of the parabola through three points; NaN if it has no maximum."""
    left, right = (force_m - force_a) / (m - a), (force_b - force_m) / (b - m)
    bend = (right - left) / (b - a)
    if not bend < 0.0:
        return np.nan, np.nan
    place = 0.5 * (a + m - left / bend)
    return place, force_a + (place - a) * (left + bend * (place - m))


@compiled
def _beyond(machine, ahead, state, trial, limits, wanted, tolerance, low, high, memory, out):
    """The desired force lies beyond both ends: the nearer end, or an extremum inside if there is one.

    If the command has little effect at this motion and the better end is the stronger current, only a share of it.
    """
    sign = 1.0 if wanted > max(low, high) else -1.0
    at_low = sign * low >= sign * high
    useful = abs(high - low) / (NARROW * memory[SPAN])
    if useful < 1.0 and abs(limits[0 if at_low else 1]) > abs(limits[1 if at_low else 0]):
        share = 1.0 - useful if at_low else useful
        force = _try(machine, ahead, state, trial, limits, share, out)
        _answer(limits, share, force, high - low, memory, out)
        return
    # Seen from the better end, heights upwards: a is on the better end's side of the best point m, b on the other's.
    start, way = (0.0, 1.0) if at_low else (1.0, -1.0)
    top, goal = sign * (low if at_low else high), sign * wanted
    a, height_a, b, height_b = 0.0, top, 1.0, sign * (high if at_low else low)
    remembered = abs(memory[EXTREMUM] - start)
    m = remembered if memory[EXTREMUM] > 0.0 and _NEAR_END < remembered < 1.0 - _NEAR_END else _NEAR_END
    height_m = sign * _try(machine, ahead, state, trial, limits, start + way * m, out)
    slope = (height_m - top) / m
    count = 0
    while count < _TRIALS and height_m < goal:
        place, height = _peak(a, height_a, m, height_m, b, height_b)
        if not height > max(height_m, top) + tolerance or not a < place < b:
            break
        margin = 0.02 * (b - a)
        if abs(place - m) < margin:
            place = m + (0.38 * (b - m) if b - m > m - a else -0.38 * (m - a))
        place = min(max(place, a + margin), b - margin)
        height = sign * _try(machine, ahead, state, trial, limits, start + way * place, out)
        count += 1
        if height > height_m:
            if place > m:
                a, height_a = m, height_m
            else:
                b, height_b = m, height_m
            m, height_m = place, height
        elif place > m:
            b, height_b = place, height
        else:
            a, height_a = place, height
    if height_m <= top + tolerance:
        memory[EXTREMUM] = 0.0
        _answer(limits, start, sign * top, way * sign * slope, memory, out)
        return
    memory[EXTREMUM] = start + way * m
    if height_m <= goal:
        _answer(limits, start + way * m, sign * height_m, 0.0, memory, out)
        return
    _between(
        machine, ahead, state, trial, limits, wanted, tolerance, start, sign * top, start + way * m, sign * height_m,
        memory, out,
    )  # fmt: skip
