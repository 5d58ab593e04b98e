"""Loops and measurements by formula, as reference for the characterization."""

import numpy as np

from damper_estimator.characterization.loops import PHASES, Loop
from damper_estimator.signals import Counts, Kinematics, Measurement, default_signals
from damper_estimator.signals.layout import COMMAND, DT, PRESSURE, ROWS, A, T, V, X


def sine(time, frequency, amplitude):
    """Displacement, velocity and acceleration of a sine that starts at its lower reversal."""
    w = 2.0 * np.pi * frequency
    return -amplitude * np.cos(w * time), amplitude * w * np.sin(w * time), amplitude * w**2 * np.cos(w * time)


def branches(rising, falling):
    """Force over relative speed u, given for rising and falling speed; odd: the same in both directions."""

    def force(u, a):
        direction = np.where(u == 0.0, np.sign(a), np.sign(u))
        return direction * np.where(direction * a > 0.0, rising(np.abs(u)), falling(np.abs(u)))

    return force


def two_lines(knee, at_knee, top):
    """0 at rest, ``at_knee`` at the knee, ``top`` at peak speed."""
    return lambda u: np.interp(u, [0.0, knee, 1.0], [0.0, at_knee, top])


def lines(*pairs):
    """Linear between (u, force) pairs."""
    return lambda u: np.interp(u, *zip(*pairs, strict=True))


SHAPES = {
    0: branches(lines((0, 0), (1, 1000)), lines((0, 0), (1, 1000))),
    1: branches(two_lines(0.4, 700, 1000), two_lines(0.4, 700, 1000)),
    2: branches(two_lines(0.6, 900, 1000), two_lines(0.3, 450, 1000)),
    3: branches(lines((0, -400), (0.5, 800), (1, 1000)), lines((0, 400), (0.15, 660), (1, 1000))),
    4: branches(two_lines(0.1, 950, 1000), two_lines(0.1, 950, 1000)),
    5: branches(lines((0, -400), (0.5, 950), (1, 1000)), lines((0, 400), (0.15, 500), (1, 1000))),
    6: branches(two_lines(0.3, 450, 1000), two_lines(0.6, 900, 1000)),
}
"""The seven types by formula: force in N over relative speed, with the speed rising and falling."""


def loop_of(shape, frequency=2.0, amplitude=0.02, rebound=1.0, compression=1.0, noise=0.0, offset=0.0, seed=0):
    """A mean loop whose force is a shape, scaled by direction."""
    time = np.arange(PHASES) / PHASES / frequency
    x, v, a = sine(time, frequency, amplitude)
    force = offset + np.where(v > 0, rebound, compression) * shape(v / np.abs(v).max(), a)
    force = force + noise * np.abs(force).max() * np.random.default_rng(seed).standard_normal(PHASES)
    return Loop(frequency, amplitude, np.nan, np.nan, x, v, a, force, np.zeros(PHASES), 0.0, 10, True, ("made",))


def measurement_of(kinematic_columns, force, rate, command=np.nan, pressure=np.nan, name="made.mcap"):
    """A measurement with the given displacement, velocity, acceleration and force, all judged from 0.2 s on."""
    x, v, a = kinematic_columns
    block = np.empty((ROWS, x.size))
    block[T] = np.arange(x.size) / rate
    block[DT] = np.r_[0.0, np.full(x.size - 1, 1.0 / rate)]
    block[X], block[V], block[A] = x, v, a
    block[6] = np.nan
    block[COMMAND], block[PRESSURE] = command, pressure
    stamp = np.round(1e9 * block[T]).astype(np.int64)
    kinematics = Kinematics(stamp, block)
    return Measurement(
        recording=name, damper="damper", kinematics=kinematics, force=force, judged=kinematics.warm(),
        counts=Counts(), gauge=force, raw_displacement=x, cutoff=60.0, band=30.0, signals=default_signals("damper"),
    )  # fmt: skip


def sine_test(law, frequency=2.0, amplitude=0.02, seconds=6.0, rate=500.0, noise=0.0, seed=0, **more):
    """A sine test of a damper whose force is ``law(x, v, a)``."""
    motion = sine(np.arange(round(seconds * rate)) / rate, frequency, amplitude)
    force = law(*motion)
    force = force + noise * np.abs(force).max() * np.random.default_rng(seed).standard_normal(force.size)
    return measurement_of(motion, force, rate, **more)
