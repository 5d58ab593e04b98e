"""A constant in the curve, as a gas force, is no pressure difference: nothing scales it, and no oil carries it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from damper_estimator.effects.discovery import all_effects
from damper_estimator.model import DamperModel, parse_model
from damper_estimator.model.element import new_element
from damper_estimator.signals.layout import COMMAND, DT, PRESSURE, ROWS, TEMPERATURE, A, T, V, X

SIZES = {
    "gas_pocket": {"stiffness": 1e6, "limit_rebound": 900.0, "limit_compression": 500.0},
    "rod_side_void": {"stiffness": 1e6, "opening": 200.0, "gas": 1e4},
    "relief_passage": {
        "opening_rebound": 300.0,
        "damping_rebound": 2e3,
        "opening_compression": 200.0,
        "damping_compression": 2e3,
    },
    "check_passage": {"damping_rebound": 1e7, "damping_compression": 5e3},
    "oil_spring": {"stiffness_rebound": 8e5, "stiffness_compression": 3e5},
    "aerated_oil": {"stiffness": 3e6, "travel_rebound": 3e-4, "travel_compression": 1e-4, "pressure": 300.0},
    "command_gain": {"rest": 0.3, "bend": 1.0},
    "position_gain": {"gain": 0.6, "scale": 0.02},
    "late_check": {"passage": 2.0, "time_constant": 0.02},
    "temperature_gain": {"fade": 0.01, "gas": 2.0},
    "viscosity_gain": {"rate": 0.02},
    "warm_leak": {"growth": 1e-5, "reference": 20.0},
    "thixotropy": {"strength": 0.8, "travel": 0.05},
    "direction_gain": {"gain": 0.5, "side": -1.0},
    "dissipation_fade": {"fade": 0.02, "capacity": 10.0},
    "pressure_relief": {"opening_rebound": 200.0, "opening_compression": 150.0},
}
CONSTANTS = st.floats(-4000.0, 4000.0)


def motion(speed: float = 1.0) -> np.ndarray:
    """(8, 2000) at 1 kHz, warming up and with a changing command."""
    time = np.arange(2000) / 1000.0
    block = np.zeros((ROWS, time.size))
    block[T], block[DT, 1:] = time, 0.001
    block[X] = speed * 0.02 * np.sin(12.0 * time)
    block[V] = speed * 0.24 * np.cos(12.0 * time)
    block[A] = -144.0 * block[X]
    block[COMMAND] = 0.5 + 0.5 * np.sin(3.0 * time) ** 2
    block[TEMPERATURE] = 25.0 + 10.0 * time
    block[PRESSURE] = np.nan
    return block


def damper(name: str, constant: float) -> DamperModel:
    """A curve with a constant, and an effect that knows it."""
    curve = {"velocity": [-0.3, -0.1, 0.0, 0.1, 0.3], "force": [constant + f for f in (-600, -350, 0, 400, 900)]}
    model = parse_model({"name": "curve", "source": "test", "effects": [{"viscous_curve": curve}]}, "test")
    return model.with_missing(new_element(all_effects()[name], model.effects, SIZES[name] | {"at_rest": constant}))


def test_all_effects_that_know_the_force_at_rest_are_tried():
    assert set(SIZES) == {
        name for name, effect in all_effects().items() if any(s.name == "at_rest" for s in effect.settings)
    }


@pytest.mark.parametrize("name", SIZES)
@given(constant=CONSTANTS)
def test_a_constant_in_the_curve_is_a_constant_in_the_force(name, constant):
    block = motion()
    alone, shifted = (damper(name, value).force(block) for value in (0.0, constant))
    np.testing.assert_allclose(shifted, alone + constant, atol=1e-5 * alone.std())
    without = damper(name, 0.0).without(name).force(block)
    assert np.std(alone - without) > 1e-3 * np.std(without)


@pytest.mark.parametrize("name", sorted(set(SIZES) - {"temperature_gain"}))  # warm gas pushes harder
@given(constant=CONSTANTS)
def test_a_damper_that_stands_still_gives_its_force_at_rest(name, constant):
    np.testing.assert_allclose(damper(name, constant).force(motion(0.0)), constant, atol=1e-6)
