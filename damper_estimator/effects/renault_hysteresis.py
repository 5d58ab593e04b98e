"""Bouc-Wen hysteresis with a switch in fast compression and a compensation of its share in the peaks.

    F = s(v) alpha z - c(v),      z as in ``bouc_wen_shifted``
    s(v) = 1 above -v_off, 0 below -(v_off + w), straight between
    c(v): table of s alpha z at the peak velocities of sines, which the measured viscous curve already includes

alpha in N, delta, beta, gamma in 1/m, mu, v_off and w in m/s. Switch and compensation follow from the parameters of the
hysteresis, so the three are one effect. The table is the result of running the hysteresis through sines of one
frequency (setting), second cycle. States: z and the last displacement; first order in the step. Source: Gao et al.,
section 3.1.3; the values of figures 9 and 10 are not published.
"""

from math import cos, pi, sin

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.effects.bouc_wen import saturation
from damper_estimator.effects.bouc_wen_shifted import SHIFTED_PARAMETERS, shifted
from damper_estimator.effects.contract import Effect, Setting, Values, number
from damper_estimator.signals.layout import DT, V, X

_STEPS = 100  # per cycle; the loop is steady after one and a half cycles


@compiled
def opening(v, switch, width):
    """The switch: 1 open, 0 shut in fast compression."""
    return min(max((v + switch + width) / width, 0.0), 1.0)


@compiled
def peak_forces(parameters, velocities, frequency, switch, width):
    """Forces of switch and hysteresis at the rebound and compression peaks of sines of the given peak velocities."""
    omega = 2.0 * pi * frequency
    dt = 1.0 / (frequency * _STEPS)
    peaks = np.zeros((2, velocities.size))
    if parameters[0] == 0.0:
        return peaks
    saturated = saturation(parameters[1], parameters[2], parameters[3], parameters[4])
    for k in range(velocities.size):
        z, last = 0.0, 0.0
        amplitude = velocities[k] / omega
        for i in range(1, _STEPS + _STEPS // 2 + 1):
            x = amplitude * sin(omega * i * dt)
            z = shifted(z, x - last, dt, saturated, parameters)
            last = x
            velocity = velocities[k] * cos(omega * i * dt)
            hysteresis = opening(velocity, switch, width) * parameters[0] * z
            if i == _STEPS:
                peaks[0, k] = hysteresis
            elif i == _STEPS + _STEPS // 2:
                peaks[1, k] = hysteresis
    return peaks


def prepare(parameters: Values, settings: Values) -> np.ndarray:
    """The switch, then the compensation as a table over velocity, knots first."""
    # The switch bends the curve, so both its ends are knots.
    switch, width = number(settings, "switch"), number(settings, "width")
    ends = [switch, switch + width]
    speeds = np.unique(np.concatenate([settings["velocity"], ends]))
    speeds = speeds[speeds > 0.0]
    fitted = np.array([number(parameters, name) for name in parameters])
    rebound, compression = peak_forces(fitted, speeds, number(settings, "frequency"), switch, width)
    knots = np.concatenate([-speeds[::-1], [0.0], speeds])
    table = np.concatenate([compression[::-1], [0.0], rebound])
    return np.concatenate([[switch, width, knots.size], knots, table])


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += s(v) alpha z - c(v)."""
    count = int(settings[2])
    knots, table = settings[3 : 3 + count], settings[3 + count : 3 + 2 * count]
    saturated = saturation(parameters[1], parameters[2], parameters[3], parameters[4])
    for i in range(force.size):
        x, v, dt = kinematics[X, i], kinematics[V, i], kinematics[DT, i]
        if dt <= 0.0:
            state[0] = 0.0
        else:
            state[0] = shifted(state[0], x - state[1], dt, saturated, parameters)
        state[1] = x
        compensation = np.interp(v, knots, table)
        force[i] += opening(v, settings[0], settings[1]) * parameters[0] * state[0] - compensation


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="hysteresis",
    parameters=SHIFTED_PARAMETERS,
    settings=(
        Setting("switch", "m/s", 0.2, "compression speed beyond which the hysteresis closes", lower=0.0),
        Setting("width", "m/s", 0.05, "width of the switch", lower=1e-4),
        Setting("frequency", "Hz", 1.5, "frequency of the sines behind the compensation", lower=0.01),
        Setting(
            "velocity", "m/s", (0.02, 0.05, 0.1, 0.2, 0.4, 0.7, 1.2), "peak velocities of these sines",
            lower=1e-4, increasing=True,
        ),
    ),
    prepare=prepare,
    states=2,
    order=1,
    shows="the F-v loop is open in rebound and slow compression and closed in fast compression",
    separate="the same peak velocity at two frequencies",
    trial=None,
)  # fmt: skip
