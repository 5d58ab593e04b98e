"""A check valve that leaks is a change of one direction, also where the oil is compressible and the force lags."""

import numpy as np
import pytest
from roads import road

import damper_estimator as de
from damper_estimator.effects.discovery import find_effect
from damper_estimator.model.element import new_element

RATE, SECONDS, STEPS = 500.0, 30.0, 8
STIFFNESS = 4e5  # N/m, of the oil


def recording(name: str, seed: int, leak: float = 0.0, softer: float = 1.0) -> de.Recording:
    """A damper on a road whose pressure follows the flow through a bleed and a relief valve. In rebound a hole passes
    ``leak`` m/s per root of a newton as well, or both pass ``softer`` times the flow.
    """
    random, time = np.random.default_rng(seed), np.arange(round(RATE * SECONDS)) / RATE
    x = road(random, time, 12.0, size=4e-3, slope=1.8)
    pressure, force = 0.0, np.empty_like(x)
    for i, speed in enumerate(np.gradient(x, time)):
        for _ in range(STEPS):
            flow = pressure / 4000.0 + np.sign(pressure) * max(abs(pressure) - 600.0, 0.0) / 1200.0
            if pressure > 0.0:
                flow = softer * flow + leak * np.sqrt(pressure)
            pressure += STIFFNESS * (speed - flow) / RATE / STEPS
        force[i] = pressure
    return de.Recording.from_arrays(time, x, force=force + 2.0 * random.standard_normal(x.size), name=name)


@pytest.fixture(scope="module")
def model():
    """A user's model of the sound damper, with its oil."""
    start = de.load_model("carrera_akutain")
    oil = new_element(find_effect("oil_spring"), start.effects, {})
    return de.fit(recording("base", 1), start.with_effect(oil)).model


@pytest.mark.parametrize("change", [{"leak": 0.003}, {"leak": 0.008}, {"softer": 1.4}], ids=str)
def test_what_leaks_in_one_direction_is_an_asymmetry_and_depends_on_no_position(change, model):
    fit, unseen = (recording(name, seed, **change) for name, seed in (("fit", 2), ("unseen", 3)))
    found = de.diagnose(fit, model, validate=unseen).diagnosis.findings
    assert [one.phenomenon for one in found] == ["asymmetry"] and not found[0].tied_with
    assert found[0].rmse_after_n < 0.25 * found[0].rmse_before_n
