"""Whether the error against the gauge grows, and with which quantity."""

import numpy as np
import pytest

from damper_estimator.node.error_drift import Drift


def grown(temperature, windows=30, speed=0.3, seed=1) -> Drift:
    """A damper whose error grows from 4 % to 12 %; ``temperature`` by window."""
    random, drift = np.random.default_rng(seed), Drift("left", window=0.9, factor=2.0)
    time = np.arange(1000) / 1000.0
    for k in range(windows):
        stamp = ((k * 1.01 + time) * 1e9).astype(np.int64)
        velocity = speed * np.sqrt(2.0) * np.sin(2.0 * np.pi * 5.0 * time)
        measured = 1500.0 * velocity
        residual = measured * (0.04 + 0.08 * k / windows) * (1.0 + 0.02 * random.normal())
        drift.add(stamp, residual, measured, velocity, velocity / 31.0, float(temperature[k]))
    return drift


def test_a_quantity_that_grows_with_the_error_is_named():
    drift = grown(np.linspace(20.0, 60.0, 30))
    assert drift.is_alarm and drift.sentence().endswith("grows with temperature")


@pytest.mark.parametrize(
    "temperature",
    [
        np.full(30, 20.0),  # nearly constant: ranks by position would rise like the error
        np.append(np.full(29, 20.0), 30.0),
        np.where(np.arange(30) < 27, 20.0, 20.5),
        20.0 + np.linspace(0.0, 1.0, 30),
        np.linspace(-0.1, 0.1, 30),
        np.full(30, np.nan),
    ],
)
def test_a_quantity_that_hardly_varies_is_not_named(temperature):
    drift = grown(temperature)
    assert drift.is_alarm and "grows with" not in drift.sentence()
