"""Third-order Butterworth low-pass that yields displacement, velocity and acceleration at once.

    y''' = w^3 (u - y) - 2 w^2 y' - 2 w y'',      w = 2 pi cutoff

In state-variable form the three states are the filtered displacement and its exact first and second derivative. The
input u is linear between samples, so the response to each step is known in closed form (poles -w and
w (-1 +- j sqrt 3) / 2) and exact for every step, however uneven the steps are.

Source: Carrera Akutain et al., section 4 (third-order Butterworth, then derivatives).
"""

from collections.abc import Iterable
from itertools import islice
from math import cos, exp, pi, sin, sqrt

import numpy as np

from damper_estimator.compiled import compiled

STATE_SIZE = 4  # y, y'/w, y''/w^2, last raw value
LEAST_RATE = 2.5  # samples in a period of the cutoff
_HALF_ROOT_3 = sqrt(3.0) / 2.0
_AT_A_TIME = 8  # columns that are filtered together


@compiled
def differentiate(cutoff, dt, raw, state, x, v, a):
    """Filters a block in place; a block of one is the live case, so both agree bit for bit.

    Args:
        cutoff: Hz; 0 is the papers' unfiltered mode: x is the raw value, v its backward difference, a is zero.
        dt: (n,) s; 0 restarts the filter at rest on that sample.
        raw: (n,) displacement, finite.
        state: (4,) kept from block to block.
        x, v, a: (n,) outputs, displacement and its first and second derivative.
    """
    w = 2.0 * pi * cutoff
    known_step = 0.0
    decay = envelope = cosine = sine = 0.0
    for i in range(raw.size):
        u = raw[i]
        step = dt[i]
        if step <= 0.0:
            x[i], v[i], a[i] = u, 0.0, 0.0
            state[0], state[1], state[2], state[3] = u, 0.0, 0.0, u
            continue
        if cutoff <= 0.0:
            x[i], v[i], a[i] = u, (u - state[3]) / step, 0.0
            state[0] = state[3] = u
            continue
        if step != known_step:
            known_step = step
            angle = w * step
            decay = exp(-angle)
            envelope = exp(-0.5 * angle)
            cosine = envelope * cos(_HALF_ROOT_3 * angle)
            sine = envelope * sin(_HALF_ROOT_3 * angle)
        # Deviation from the ramp response y = u - 2 u'/w, in units of w t, split into the three modes.
        slope = (u - state[3]) / (w * step)
        e0 = state[0] - state[3] + 2.0 * slope
        e1 = state[1] - slope
        e2 = state[2]
        m = (e0 + e1 + e2) * decay
        b0 = -(e1 + e2)
        c0 = (2.0 * e0 + 3.0 * e1 + e2) / (2.0 * _HALF_ROOT_3)
        b1 = -0.5 * b0 + _HALF_ROOT_3 * c0
        c1 = -0.5 * c0 - _HALF_ROOT_3 * b0
        b2 = -0.5 * b1 + _HALF_ROOT_3 * c1
        c2 = -0.5 * c1 - _HALF_ROOT_3 * b1
        state[0] = m + b0 * cosine + c0 * sine + u - 2.0 * slope
        state[1] = -m + b1 * cosine + c1 * sine + slope
        state[2] = m + b2 * cosine + c2 * sine
        state[3] = u
        x[i], v[i], a[i] = state[0], w * state[1], w * w * state[2]


@compiled
def _filter_columns(cutoff, dt, values, backward):
    """The filter over every column of values (n, k) in place, from the first sample or ``backward`` from the last.

    Several columns together fill the processor's vectors. What a step does to a column's deviation from the ramp
    response is one matrix for all: the closed form of ``differentiate``, multiplied out.
    """
    w = 2.0 * pi * cutoff
    size, count = values.shape
    known_step = per_step = 0.0
    y0 = y1 = y2 = v0 = v1 = v2 = a0 = a1 = a2 = 0.0
    y, v, a, last = np.zeros(count), np.zeros(count), np.zeros(count), np.zeros(count)  # y: output less raw value
    for r in range(size):
        i = size - 1 - r if backward else r
        step = dt[i] if not backward else dt[i + 1] if r > 0 else 0.0
        if step <= 0.0 or r == 0:
            for k in range(count):
                y[k], v[k], a[k], last[k] = 0.0, 0.0, 0.0, values[i, k]
            continue
        if step != known_step:
            known_step = step
            per_step = 1.0 / (w * step)
            angle = w * step
            decay, envelope = exp(-angle), exp(-0.5 * angle)
            cosine = envelope * cos(_HALF_ROOT_3 * angle)
            sine = envelope * sin(_HALF_ROOT_3 * angle) / (2.0 * _HALF_ROOT_3)
            y0, y1, y2 = decay + 2.0 * sine, decay - cosine + 3.0 * sine, decay - cosine + sine
            v0, v1, v2 = cosine - decay - sine, 2.0 * cosine - decay, cosine - decay + sine
            a0, a1, a2 = decay - cosine - sine, decay - cosine - 3.0 * sine, decay - 2.0 * sine
        for k in range(count):
            u = values[i, k]
            slope = per_step * (u - last[k])
            e0, e1, e2 = y[k] + 2.0 * slope, v[k] - slope, a[k]
            y[k] = y0 * e0 + y1 * e1 + y2 * e2 - 2.0 * slope
            v[k] = v0 * e0 + v1 * e1 + v2 * e2 + slope
            a[k] = a0 * e0 + a1 * e1 + a2 * e2
            last[k] = u
            values[i, k] = y[k] + u


def low_pass(cutoff: float, dt: np.ndarray, raw: np.ndarray) -> np.ndarray:
    """The causal low-pass of a whole signal: (n,) in, (n,) out; starts at rest, and restarts where ``dt`` is 0."""
    x, (v, a) = np.empty(raw.size), np.empty((2, raw.size))  # x separately: only x is kept
    at_rest = np.array([raw[0], 0.0, 0.0, raw[0]]) if raw.size else np.zeros(STATE_SIZE)
    differentiate(cutoff, dt, np.ascontiguousarray(raw, float), at_rest, x, v, a)
    return x


def low_pass_zero_phase(cutoff: float, dt: np.ndarray, raw: np.ndarray) -> np.ndarray:
    """The same filter forward and backward over each stretch between restarts: no delay, twice the attenuation.

    A cutoff of 0 leaves the signal unchanged. Shapes: (n,) in, (n,) out; or (n, k) in and out, a signal per column.
    """
    values = np.array(raw, float, order="C")
    _both_ways(cutoff, dt, values[:, None] if values.ndim == 1 else values)
    return values


def columns_zero_phase(cutoff: float, dt: np.ndarray, columns: Iterable[np.ndarray], picks: np.ndarray) -> np.ndarray:
    """(r, k) several signals (n,) through ``low_pass_zero_phase``, at the samples ``picks`` (r,).

    Filtered some at a time: all together need much memory, one by one much time.
    """
    columns, found = iter(columns), [np.zeros((picks.size, 0))]
    while some := list(islice(columns, _AT_A_TIME)):
        values = np.stack(some, axis=1)
        _both_ways(cutoff, dt, values)
        found.append(values[picks])
    return np.hstack(found)


def _both_ways(cutoff: float, dt: np.ndarray, values: np.ndarray) -> None:
    """Forward and backward over columns (n, k), in place; backward a stretch begins just before the next restart."""
    if cutoff > 0.0:
        _filter_columns(cutoff, dt, values, False)
        _filter_columns(cutoff, dt, values, True)


def delay_seconds(cutoff: float) -> float:
    """Delay of slow signals through the filter, 2 / w: 5.3 ms at 60 Hz; 0 in the unfiltered mode."""
    return 1.0 / (pi * cutoff) if cutoff > 0.0 else 0.0
