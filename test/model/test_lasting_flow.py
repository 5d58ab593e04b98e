"""What leaks through a passage adds up without limit; the force of a damper does not depend on how long it has run."""

import numpy as np
import pytest

from damper_estimator.model import DamperModel, parse_model
from damper_estimator.signals.layout import DT, ROWS, TEMPERATURE, A, T, V, X

RATE, FREQUENCY, SECONDS = 500.0, 2.0, 120.0
PASSAGES = {
    "dashpot": {"damping": 6000.0},
    "check_passage": {"damping_rebound": 1e8, "damping_compression": 5e3},
    "relief_passage": {
        "opening_rebound": 200.0,
        "damping_rebound": 2e3,
        "opening_compression": 1e4,
        "damping_compression": 2e3,
    },
    "warm_leak": {"growth": 1e-5, "reference": 20.0},
}


def stroking() -> np.ndarray:
    """(8, n) a sine of 25 mm for two minutes, at 40 deg C."""
    time = np.arange(round(RATE * SECONDS)) / RATE
    block = np.full((ROWS, time.size), np.nan)
    omega = 2.0 * np.pi * FREQUENCY
    block[T], block[DT] = time, np.diff(time, prepend=0.0)
    block[X], block[V] = 0.025 * np.sin(omega * time), 0.025 * omega * np.cos(omega * time)
    block[A], block[TEMPERATURE] = -(omega**2) * block[X], 40.0
    return block


def leaking(name: str) -> DamperModel:
    """A damper that is stiffer in rebound, behind a passage."""
    path = [{"linear_viscous": {"rebound": 2000.0, "compression": 800.0}}]
    effects = [{name: {**PASSAGES[name], "path": path}}]
    return parse_model({"name": "leaking", "source": "test", "effects": effects}, "test")


def cycles(force: np.ndarray) -> np.ndarray:
    """(cycles, samples) of the force."""
    return force.reshape(round(FREQUENCY * SECONDS), -1)


@pytest.mark.parametrize("name", PASSAGES)
def test_the_last_cycle_is_as_the_second_one(name):
    each = cycles(leaking(name).force(stroking()))
    np.testing.assert_allclose(each[-1], each[1], rtol=1e-6, atol=1e-6 * each[1].max())
    plain = 0.025 * 2.0 * np.pi * FREQUENCY * 2000.0
    assert each[1].max() < 0.99 * plain or each[1].min() > -0.99 * 0.4 * plain, "something leaks"
