"""A simulated linear damper with an additional force, for the tests of planning."""

import numpy as np

import damper_estimator as de


def recorded(extra, seconds=12.0, seed=0, rate=500.0, name="old", scale=1.0):
    """A recording of a linear damper with ``extra(x, v)`` N added, and 4 N of noise."""
    rng = np.random.default_rng(seed)
    time = np.arange(round(seconds * rate)) / rate
    phases = rng.uniform(0.0, 6.0, 8)
    x = (
        0.008
        * scale
        * sum(np.sin(2 * np.pi * f * time + p) / f for f, p in zip(np.linspace(0.7, 9.0, 8), phases, strict=True))
    )
    return measured(time, x, extra, rng, name)


def measured(time, x, extra, rng, name):
    """What is measured on a motion (n,)."""
    v = np.gradient(x, time)
    force = 1500.0 * v + extra(x, v) + 4.0 * rng.standard_normal(time.size)
    return de.Recording.from_arrays(time, x + 5e-6 * rng.standard_normal(time.size), force=force, name=name)


def gas(x, v):
    """A gas spring in a small volume, N."""
    return 150.0 - 150.0 / (1.0 + 25.0 * x) ** 1.4
