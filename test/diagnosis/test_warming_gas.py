"""Gas that the oil warms: a force that drifts over the recording, which a drifting zero of the gauge hides."""

import numpy as np
import pytest
from roads import road

import damper_estimator as de

RATE, SECONDS = 250.0, 60.0
AREA, PRESSURE, VOLUME = 1.5e-4, 3e6, 6e-5  # m2 of the rod, Pa and m3 of the gas at 20 deg C


def recording(name: str, seed: int, warm: tuple[float, float], gas: bool, thermometer: bool = True) -> de.Recording:
    """A damper with a digressive valve and a gas that obeys p V^1.3 ~ T where it warms; the oil warms up to saturation
    from ``warm[0]`` towards ``warm[1]`` deg C.
    """
    random, time = np.random.default_rng(seed), np.arange(round(RATE * SECONDS)) / RATE
    x = road(random, time, 8.0, size=4e-3, slope=1.8)
    v = np.gradient(x, time)
    oil = warm[0] + (warm[1] - warm[0]) * (1.0 - np.exp(-2.0 * time / SECONDS))
    pressure = PRESSURE * (VOLUME / (VOLUME + AREA * x)) ** 1.3
    if gas:
        pressure = pressure * (oil + 273.15) / 293.15
    force = 250.0 * np.arcsinh(v / 0.06) - AREA * (pressure - 1e5) + 2.0 * random.standard_normal(v.size)
    temperature = oil + 0.05 * random.standard_normal(v.size) if thermometer else None
    return de.Recording.from_arrays(time, x, force=force, temperature=temperature, name=name)


def found(before: tuple[float, float], after: tuple[float, float], gas: bool, thermometer: bool = True):
    base = recording("base", 1, before, gas, thermometer)
    model = de.improve(base, "linear_viscous").model
    fit, unseen = (recording(name, seed, after, gas, thermometer) for name, seed in (("fit", 2), ("unseen", 3)))
    return de.diagnose(fit, model, validate=unseen).diagnosis


def test_gas_that_warms_is_temperature_and_perhaps_the_gauge():
    diagnosis = found((20.0, 21.0), (20.0, 110.0), gas=True)
    first = diagnosis.findings[0]
    assert first.phenomenon == "temperature_fade" and not first.tied_with
    assert first.rmse_after_n < 0.4 * first.rmse_before_n
    assert "zero drifts looks the same" in first.remark


def test_without_a_thermometer_the_force_is_seen_to_move():
    diagnosis = found((20.0, 21.0), (20.0, 110.0), gas=True, thermometer=False)
    assert diagnosis.verdict != "nothing_missing"
    assert "temperature_fade" not in {one.phenomenon for one in diagnosis.findings}


@pytest.mark.parametrize("after", [(20.0, 110.0), (60.0, 30.0)])
def test_a_temperature_that_does_nothing_is_not_named(after):
    assert not found((20.0, 21.0), after, gas=False).findings
