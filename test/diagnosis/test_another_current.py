"""A driver with a dead band or another gain: what the model makes of the command is right, the current is another."""

import numpy as np
import pytest
from roads import road

import damper_estimator as de

RATE, SECONDS = 300.0, 24.0


def recording(name: str, seed: int, gain: float = 1.0, dead: float = 0.0) -> de.Recording:
    """A magneto-rheological damper on a road; its command changes every second and is not quite the current."""
    random, time = np.random.default_rng(seed), np.arange(round(RATE * SECONDS)) / RATE
    x = road(random, time, 9.0)
    v = np.gradient(x, time)
    command = random.uniform(0.2, 2.0, round(SECONDS) + 1)[time.astype(int)]
    current = np.maximum(gain * command - dead, 0.0)
    force = (80.0 + 900.0 * np.tanh(0.5 * current)) * np.tanh(v / 0.02) + 500.0 * v
    force += 2.0 * random.standard_normal(time.size)
    return de.Recording.from_arrays(time, x, force=force, command=command, name=name)


@pytest.fixture(scope="module")
def model():
    """A user's model of the damper with its old driver."""
    return de.fit(recording("base", 1), "mr_damper_current").model


@pytest.mark.parametrize("change", [{"dead": 0.3}, {"gain": 0.75}, {"gain": 1.25}], ids=str)
def test_another_current_is_found_in_a_model_that_follows_the_command(change, model):
    fit, unseen = (recording(name, seed, **change) for name, seed in (("fit", 2), ("unseen", 3)))
    found = de.diagnose(fit, model, validate=unseen).diagnosis.findings
    assert {one.phenomenon for one in found} == {"current"} and not found[0].tied_with
    assert found[0].rmse_after_n < 0.4 * found[0].rmse_before_n


def test_the_old_driver_is_not_blamed(model):
    assert not de.diagnose(recording("fit", 2), model, validate=recording("unseen", 3)).diagnosis.findings
