"""Displacement and relative acceleration fused by a Kalman filter: the motion without a low-pass's delay.

States are displacement x, velocity v and the accelerometer's offset b. From sample to sample, with the mean a of the
accelerations at both ends,

    x <- x + dt v + dt^2 / 2 (a - b),      v <- v + dt (a - b),      b <- b

The noise of the acceleration enters x and v as a does, the offset drifts; the displacement is measured with white
noise. A displacement far from the one predicted by the accelerations shows an outlier in one of them: the filter is
reset. Source: R. E. Kalman, A new approach to linear filtering and prediction problems, J. Basic Eng. 82 (1960).
"""

from dataclasses import astuple, dataclass
from math import sqrt

import numpy as np

from damper_estimator.compiled import compiled

# State: whether it runs, x, v, b, the acceleration before, and the covariance's upper triangle.
RUNS, PLACE, SPEED, OFFSET, BEFORE, XX, XV, XB, VV, VB, BB = range(11)
FUSION_SIZE = 11
NOISES = 3
_START_SPEED = 0.1  # m/s, standard deviation of the velocity at a start
_START_OFFSET = 1.0  # m/s^2, standard deviation of the offset at a start
_ABSURD = 1e4  # m/s^2, beyond any suspension
_FAR, _SLACK = 6.0, 1e-3  # standard deviations, plus m


@dataclass(frozen=True)
class Fusion:
    """Noise of the sensors."""

    displacement_noise: float = 2e-5  # m rms
    acceleration_noise: float = 0.3  # m/s^2 rms
    offset_drift: float = 0.01  # m/s^2 after a second

    def noises(self) -> np.ndarray:
        """(3,) for `fuse`."""
        return np.array(astuple(self))


@compiled
def fuse(noises, dt, raw, acceleration, state, x, v, a, alone):
    """Replaces a low-pass's motion by the fused one; a block of one is the live case.

    Args:
        noises: (3,) as the fields of `Fusion`.
        dt: (n,) s; 0 resets.
        raw: (n,) m; ``acceleration``: (n,) m/s^2, measured acceleration, NaN if missing.
        state: (FUSION_SIZE,), kept from block to block.
        x, v, a: (n,) the low-pass's displacement, velocity and acceleration, overwritten.
        alone: (n,) uint8 output, 1 if the acceleration was missing or a sensor had an outlier, and the low-pass's
            motion stays.
    """
    for i in range(raw.size):
        alone[i] = 0 if abs(acceleration[i]) < _ABSURD else 1  # NaN is not
        if alone[i] == 0 and (dt[i] <= 0.0 or state[RUNS] == 0.0):
            _begin(noises, raw[i], v[i], acceleration[i], state)
        elif alone[i] == 0:
            _advance(noises, dt[i], acceleration[i], state)
            off = abs(raw[i] - state[PLACE])
            if off < _FAR * sqrt(state[XX] + noises[0] ** 2) + _SLACK:
                _correct(noises, raw[i], state)
            else:
                alone[i] = 1
        if alone[i]:
            state[RUNS] = 0.0
            continue
        x[i], v[i], a[i] = state[PLACE], state[SPEED], acceleration[i] - state[OFFSET]


@compiled
def _begin(noises, raw, speed, acceleration, state):
    """Starts at the raw displacement and the low-pass's velocity, with unknown offset."""
    state[:] = 0.0
    state[RUNS], state[PLACE], state[SPEED], state[BEFORE] = 1.0, raw, speed, acceleration
    state[XX], state[VV], state[BB] = noises[0] ** 2, _START_SPEED**2, _START_OFFSET**2


@compiled
def _advance(noises, dt, acceleration, state):
    """Predicts the motion over one step, and its covariance."""
    push = 0.5 * (state[BEFORE] + acceleration) - state[OFFSET]
    state[BEFORE] = acceleration
    h = 0.5 * dt * dt
    state[PLACE] += dt * state[SPEED] + h * push
    state[SPEED] += dt * push
    xx, xv, xb, vv, vb, bb = state[XX], state[XV], state[XB], state[VV], state[VB], state[BB]
    noise = noises[1] ** 2
    state[XX] = xx + dt * dt * vv + h * h * bb + 2.0 * (dt * xv - h * xb - dt * h * vb) + h * h * noise
    state[XV] = xv + dt * vv - (h + dt * dt) * vb - dt * xb + dt * h * (bb + noise)
    state[XB] = xb + dt * vb - h * bb
    state[VV] = vv - 2.0 * dt * vb + dt * dt * (bb + noise)
    state[VB] = vb - dt * bb
    state[BB] = bb + noises[2] ** 2 * dt


@compiled
def _correct(noises, raw, state):
    """Corrects the motion by the measured displacement."""
    xx, xv, xb = state[XX], state[XV], state[XB]
    total = xx + noises[0] ** 2
    off = (raw - state[PLACE]) / total
    state[PLACE] += xx * off
    state[SPEED] += xv * off
    state[OFFSET] += xb * off
    state[XX] -= xx * xx / total
    state[XV] -= xx * xv / total
    state[XB] -= xx * xb / total
    state[VV] -= xv * xv / total
    state[VB] -= xv * xb / total
    state[BB] -= xb * xb / total
