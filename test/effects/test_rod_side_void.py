"""A void behind the piston of a monotube damper, against the balance of its chambers."""

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid, solve_ivp
from test_form_free_effects import behind

from damper_estimator.effects.discovery import find_effect
from damper_estimator.effects.trial import Ranges

AREA = 1.5e-3  # m^2
GAS_PRESSURE, GAS_VOLUME = 3e5, 2e-4  # Pa, m^3
VALVE = 5000.0  # N s/m, of the path in `behind`
OIL = 4e6  # N/m

VALUES = {
    "stiffness": OIL,
    "opening": GAS_PRESSURE * AREA,
    "gas": GAS_PRESSURE * AREA**2 / GAS_VOLUME,
}


def monotube(time, velocity, rod=0.0):
    """(n,) N: the force of both chambers' pressures; the one behind the piston does not fall below zero.

    A rod with this share of the piston's area leaves the gas more room as the damper extends.

    The state is the oil in the rod-side chamber beyond that which fills it without pressure, m^3; negative: a void.
    """
    stiffness = OIL / AREA**2  # Pa/m^3
    full = GAS_PRESSURE / stiffness

    displacement = cumulative_trapezoid(velocity, time, initial=0.0)

    def pressures(t, oil):
        volume = GAS_VOLUME + oil - full + rod * AREA * np.interp(t, time, displacement)
        return GAS_PRESSURE * GAS_VOLUME / volume, stiffness * np.maximum(oil, 0.0)

    def rate(t, oil):
        below, above = pressures(t, oil)
        return AREA * np.interp(t, time, velocity) + AREA**2 / VALVE * (below - above)

    steps = {"rtol": 1e-8, "atol": 1e-12, "max_step": 2e-4}
    oil = solve_ivp(rate, (time[0], time[-1]), [full], method="LSODA", t_eval=time, **steps).y[0]
    below, above = pressures(time, oil)
    return AREA * (above - below)


@pytest.mark.parametrize(("amplitude", "frequency"), [(0.02, 2.5), (0.01, 4.0), (0.03, 1.0)])
def test_it_is_the_balance_of_a_monotube_damper(amplitude, frequency):
    time = np.arange(0.0, 2.0, 1e-3)
    velocity = 2.0 * np.pi * frequency * amplitude * np.sin(2.0 * np.pi * frequency * time)
    expected = monotube(time, velocity)
    found = behind("rod_side_void", velocity, **VALUES)
    rigid = VALVE * velocity
    assert np.abs(expected - rigid).max() > 0.25 * np.abs(rigid).max()  # the void matters
    far = np.abs(found - expected) > 0.03 * np.abs(rigid).max()
    assert np.mean(far) < 0.02  # where the void closes, with a jump, a few milliseconds early or late


@pytest.mark.parametrize("rod", [0.1, 0.25])
def test_the_further_it_is_extended_the_earlier_it_cavitates(rod):
    """Long slow strokes with short fast ones on them."""
    time = np.arange(0.0, 4.0, 1e-3)
    velocity = 0.12 * np.sin(2.0 * np.pi * 0.5 * time) + 0.25 * np.sin(2.0 * np.pi * 4.0 * time)
    expected, without = monotube(time, velocity, rod), monotube(time, velocity)
    # The pressures at rest follow the gas on both sides of the piston, so that their difference is the valves' alone.
    found = behind("rod_side_void", velocity, **VALUES, rod=rod)
    error, effect = (float(np.sqrt(np.mean((one - expected) ** 2))) for one in (found, without))
    assert effect > 0.03 * np.abs(expected).max()  # the rod matters
    assert error < 0.35 * effect
    extended = cumulative_trapezoid(velocity, time, initial=0.0) > 0.04
    assert found[extended].min() > found[~extended].min() + 0.5 * rod * VALUES["gas"] * 0.04


def test_below_its_force_it_is_the_oil_alone():
    velocity = 0.3 * np.sin(30.0 * np.arange(0.0, 1.0, 1e-3))
    found = behind("rod_side_void", velocity, stiffness=1e6, opening=1e6, gas=1e4)
    oil = behind("oil_spring", velocity, stiffness_rebound=1e6, stiffness_compression=1e6)
    assert found == pytest.approx(oil, abs=1e-6 * np.abs(oil).max())


def test_what_does_not_pass_the_piston_passes_it_later():
    velocity = 0.3 * np.sin(2.0 * np.pi * 2.5 * np.arange(0.0, 2.0, 1e-3))
    rigid, found = VALVE * velocity, behind("rod_side_void", velocity, **VALUES)
    falling = (velocity < -0.2) & (np.gradient(velocity) < 0.0)
    assert np.all(found[falling] > 0.6 * rigid[falling])  # less compression force while the void grows
    late = (velocity > 0.0) & (velocity < 0.1) & (np.gradient(velocity) > 0.0)
    late[:400] = False
    assert np.all(found[late] < -VALUES["opening"])  # and still compression force after the reversal
    passed = np.sum(found[400:]) * 1e-3 / VALVE
    assert abs(passed) < 0.02 * 2.0 * 0.3 / (2.0 * np.pi * 2.5)  # of the stroke, over four periods


def test_it_claims_only_a_void():
    ranges = Ranges(-0.03, 0.03, speed=0.5, acceleration=20.0, force=500.0, seconds=20.0)
    tried = find_effect("rod_side_void").trial(ranges)
    assert not tried.exclusion({"stiffness": 2e6, "opening": 600.0, "gas": 1e4})
    assert "beyond the recorded forces" in tried.exclusion({"stiffness": 2e6, "opening": 2000.0, "gas": 1e4})
    assert tried.limits["gas"][1] < 0.5 * tried.limits["stiffness"][0]  # otherwise oil that is softer in compression
