"""Oil with free gas, against the volumes of oil and bubbles in the loaded chamber."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from test_form_free_effects import behind

from damper_estimator.effects.discovery import find_effect
from damper_estimator.effects.trial import Ranges

AREA = 1.2e-3  # m^2
REST = 4e5  # Pa
LIQUID, MODULUS = 1.5e-4, 1.4e9  # m^3, Pa
VALVE = 5000.0  # N s/m, of the path in `behind`
VALUES = {"stiffness": AREA**2 * MODULUS / LIQUID, "pressure": AREA * REST}


def pressure(deflection, bubbles):
    """Pa, of a chamber whose oil and bubbles, m^3 at rest, are compressed by a part of the piston's travel, m."""

    def excess(p):
        return LIQUID * (p - REST) / MODULUS + bubbles * (1.0 - REST / p) - AREA * abs(deflection)

    return brentq(excess, REST, REST + MODULUS, xtol=1e-3)


def damper(time, velocity, bubbles):
    """(n,) N, with bubbles in both chambers: what is not taken by the loaded one passes the valve."""

    def force(deflection):
        return np.sign(deflection) * AREA * (pressure(deflection, bubbles) - REST)

    def rate(t, deflection):
        return np.interp(t, time, velocity) - force(deflection[0]) / VALVE

    steps = {"rtol": 1e-7, "atol": 1e-10, "max_step": 1e-3}
    found = solve_ivp(rate, (time[0], time[-1]), [0.0], method="LSODA", t_eval=time, **steps).y[0]
    return np.array([force(one) for one in found])


@pytest.mark.parametrize("bubbles", [5e-7, 2e-6])
def test_it_is_the_balance_of_a_chamber_with_bubbles(bubbles):
    time = np.arange(0.0, 0.8, 1e-3)
    velocity = 0.3 * np.sin(2.0 * np.pi * 5.0 * time)
    expected, travel = damper(time, velocity, bubbles), bubbles / AREA
    found = behind("aerated_oil", velocity, **VALUES, travel_rebound=travel, travel_compression=travel)
    assert np.abs(expected - VALVE * velocity).max() > 0.1 * VALVE * 0.3  # the bubbles matter
    assert found == pytest.approx(expected, abs=0.01 * VALVE * 0.3)


def test_without_gas_it_is_the_oil_alone():
    velocity = 0.3 * np.sin(30.0 * np.arange(0.0, 1.0, 1e-3))
    found = behind("aerated_oil", velocity, stiffness=1e6, pressure=500.0, travel_rebound=0.0, travel_compression=0.0)
    oil = behind("oil_spring", velocity, stiffness_rebound=1e6, stiffness_compression=1e6)
    assert found == pytest.approx(oil, abs=1e-6 * np.abs(oil).max())


@pytest.mark.parametrize(("side", "other", "sign"), [("rebound", "compression", 1.0), ("compression", "rebound", -1.0)])
def test_gas_in_one_chamber_leaves_the_other_direction_alone(side, other, sign):
    velocity = 0.3 * np.sin(30.0 * np.arange(0.0, 1.0, 1e-3))
    found = behind("aerated_oil", velocity, **VALUES, **{f"travel_{side}": 5e-4, f"travel_{other}": 0.0})
    late = np.abs(found - VALVE * velocity)
    loaded, unloaded = sign * velocity > 0.05, sign * velocity < -0.15  # where the bubbles have closed again
    assert late[loaded].max() > 5.0 * late[unloaded].max()


def test_it_claims_only_oil_that_becomes_stiffer():
    ranges = Ranges(-0.03, 0.03, speed=0.5, acceleration=20.0, force=500.0, seconds=20.0)
    tried = find_effect("aerated_oil").trial(ranges)
    some = {"stiffness": 5e6, "travel_rebound": 3e-4, "travel_compression": 0.0, "pressure": 400.0}
    assert not tried.exclusion(some)
    assert "without gas" in tried.exclusion(some | {"travel_rebound": 1e-6})
    assert "without gas" in tried.exclusion(some | {"pressure": 5e4})
