"""A fluid whose structure breaks down in motion, by other laws than those of the effect."""

import numpy as np
import pytest

import damper_estimator as de

RATE, SECONDS = 500.0, 40.0


def motion(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Time and displacement (n,): stretches of fast and of slow sines, of several seconds each."""
    random, time = np.random.default_rng(seed), np.arange(round(RATE * SECONDS)) / RATE
    knots = np.arange(0.0, SECONDS + 4.0, 4.0)
    size = np.interp(time, knots, random.permutation(np.geomspace(1.5e-3, 25e-3, knots.size)))
    return time, size * np.sin(2.0 * np.pi * np.cumsum(1.5 + 0.8 * np.sin(0.37 * time)) / RATE)


def recording(name: str, seed: int, recovery: float | None = None) -> de.Recording:
    """A digressive damper; its fluid breaks with a power of the velocity and grows the slower the less is broken."""
    time, x = motion(seed)
    v = np.gradient(x, time)
    force = 900.0 * np.arctan(6.0 * v) + 500.0 * v
    if recovery is not None:
        share, states = 0.5, np.empty(v.size)
        for i, speed in enumerate(np.abs(v)):
            share += ((1.0 - share) * speed**0.6 / 0.5 - share**1.5) / (recovery * RATE)
            states[i] = share
        force *= 1.0 + 1.2 * (np.median(states) - states)
    noise = np.random.default_rng([seed, 1]).standard_normal(v.size)
    return de.Recording.from_arrays(time, x, force=force + 2.0 * noise, name=name)


@pytest.fixture(scope="module")
def model():
    """A user's model of the damper before the fluid changed."""
    return de.fit(recording("base", 1), "viscous_curve").model


@pytest.mark.parametrize("recovery", [0.8, 3.0])
def test_force_that_falls_with_recent_motion_is_a_hysteresis(recovery, model):
    fit, unseen = (recording(name, seed, recovery) for name, seed in (("fit", 2), ("unseen", 3)))
    found = de.diagnose(fit, model, validate=unseen).diagnosis
    assert found.findings[0].phenomenon == "hysteresis" and not found.findings[0].tied_with
    assert found.findings[0].rmse_after_n < 0.6 * found.findings[0].rmse_before_n


def test_without_a_change_no_fluid_is_blamed(model):
    assert not de.diagnose(recording("fit", 2), model, validate=recording("unseen", 3)).diagnosis.findings
