"""A gauge whose gain creeps, and a damper that fades: what falls with time has a name that the thermometer supports."""

import numpy as np
import pytest
from roads import road

import damper_estimator as de

RATE, SECONDS = 400.0, 40.0


def recording(name: str, seed: int, gain: float = 0.0, fade: float = 0.0, shown: float | None = None) -> de.Recording:
    """A damper on a road; the gauge's gain creeps to ``gain``, the oil warms up by 10 K and loses ``fade`` of its
    force, and the thermometer, if there is one, shows ``shown`` K of it.
    """
    random, time = np.random.default_rng(seed), np.arange(round(RATE * SECONDS)) / RATE
    x = road(random, time, 9.0)
    v = np.gradient(x, time)
    force = 700.0 * np.arctan(7.0 * v) + 400.0 * v + 60.0 * np.tanh(200.0 * v)
    force *= (1.0 - fade * time / SECONDS) * (1.0 + gain * (1.0 - np.exp(-time / 15.0)))
    warm = None if shown is None else 31.0 + shown * time / SECONDS + 0.05 * random.standard_normal(time.size)
    force += 2.0 * random.standard_normal(time.size)
    return de.Recording.from_arrays(time, x, force=force, temperature=warm, name=name)


def diagnosed(**change):
    """Findings for a model of the sound damper; a thermometer is there in all recordings or in none."""
    model = de.fit(recording("base", 1, shown=change.get("shown")), "viscous_curve").model
    fit, unseen = (recording(name, seed, **change) for name, seed in (("fit", 2), ("unseen", 3)))
    return de.diagnose(fit, model, validate=unseen).diagnosis.findings


@pytest.mark.parametrize("gain", [0.25, -0.2])
def test_a_gain_that_creeps_at_a_constant_temperature_is_the_gauges(gain):
    (found,) = diagnosed(gain=gain, shown=0.0)
    assert (found.phenomenon, found.effect) == ("force_gain_error", "gain_drift")
    assert "temperature_fade" not in found.tied_with


def test_without_a_thermometer_a_fading_force_is_a_warm_damper_or_a_drifting_gauge():
    (found,) = diagnosed(fade=0.3)
    assert {"temperature_fade", "force_gain_error"} == {found.phenomenon, *found.tied_with}


def test_a_damper_that_its_thermometer_shows_to_be_warmer_fades():
    (found,) = diagnosed(fade=0.3, shown=10.0)
    assert found.phenomenon == "temperature_fade" and not found.tied_with
