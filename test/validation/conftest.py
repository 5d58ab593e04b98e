"""Measurements made of functions of time, without a bag."""

import numpy as np
import pytest

from damper_estimator.effects.discovery import find_effect
from damper_estimator.model import make_element
from damper_estimator.model.damper_model import DamperModel
from damper_estimator.signals import Counts, Measurement, default_signals, low_pass
from damper_estimator.signals.kinematics import Differentiator

DAMPING = 1500.0  # N s/m, of the model that the tests run


@pytest.fixture(scope="session")
def viscous() -> DamperModel:
    """F = 1500 N s/m v."""
    element = make_element(find_effect("linear_viscous"), {"rebound": DAMPING, "compression": DAMPING})
    return DamperModel("viscous", "", (element,))


@pytest.fixture(scope="session")
def motion():
    """Random-like displacement (n,) m, even energy from 0.3 to 12 Hz, and its time (n,) s."""

    def make(seconds=40.0, rate=500.0, seed=0, rms=0.01):
        time = np.arange(round(seconds * rate)) / rate
        draw = np.random.default_rng(seed)
        frequency = np.linspace(0.3, 12.0, 40)
        waves = np.sin(2 * np.pi * frequency * time[:, None] + draw.uniform(0, 2 * np.pi, 40)) / frequency**1.5
        x = waves.sum(axis=1)
        return time, rms * x / x.std()

    return make


@pytest.fixture(scope="session")
def measured():
    """Measurement of a displacement and of the force that a function of (kinematics, force before) makes of it.

    ``of`` takes the kinematics and returns the measured damper force (n,) as it would be behind the causal filter.
    ``gauge`` is the raw gauge; ``raw`` the displacement as the model sees it.
    """

    def make(time, displacement, of, gauge=None, cutoff=60.0, band=30.0, max_gap=0.1, **slow):
        stamp = np.round(time * 1e9).astype(np.int64)
        kinematics, verdict = Differentiator(cutoff, max_gap).block(stamp, displacement, **slow)
        force = of(kinematics)
        return Measurement(
            recording="made.mcap",
            damper="front_left",
            kinematics=kinematics,
            force=force,
            judged=kinematics.warm(),
            counts=Counts.of(verdict),
            gauge=force if gauge is None else gauge,
            raw_displacement=displacement,
            cutoff=cutoff,
            band=band,
            signals=default_signals("front_left"),
        )

    return make


@pytest.fixture(scope="session")
def filtered():
    """A signal through the causal filter at 60 Hz, as the measured force is: (kinematics, values) to values."""
    return lambda kinematics, values, cutoff=60.0: low_pass(cutoff, kinematics.dt, values)
