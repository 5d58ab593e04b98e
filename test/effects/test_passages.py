"""Passages beside a path, relief and check valve, against the balance of their flows."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from test_form_free_effects import behind
from test_physics import entry, force, motion

from damper_estimator.effects.discovery import find_effect
from damper_estimator.effects.trial import Ranges

VALVE = 5000.0  # N s/m, of the path in `behind`
TIME = np.arange(0.0, 1.0, 1e-3)
VELOCITY = 0.3 * np.sin(2.0 * np.pi * 2.0 * TIME) + 0.1 * np.sin(2.0 * np.pi * 7.0 * TIME)
RELIEF = {
    "opening_rebound": 600.0,
    "damping_rebound": 2000.0,
    "opening_compression": 300.0,
    "damping_compression": 900.0,
}
CHECK = {"damping_rebound": 5e6, "damping_compression": 2e3}
RANGES = Ranges(-0.03, 0.03, speed=0.5, acceleration=20.0, force=500.0, seconds=20.0)


def relief_flow(pressed):
    """m/s through a relief passage, with the leak of a valve that closes almost tightly."""
    opening, slope = (
        RELIEF[f"{name}_{'rebound' if pressed > 0.0 else 'compression'}"] for name in ("opening", "damping")
    )
    size = 1e-4 * min(abs(pressed) / opening, 1.0) + max(abs(pressed) - opening, 0.0) / slope
    return np.copysign(size, pressed)


def check_flow(pressed):
    """m/s through a passage whose valve opens in compression."""
    return pressed / (5e6 if pressed > 0.0 else 2e3)


@pytest.mark.parametrize(
    ("name", "values", "flow"),
    [
        ("relief_passage", RELIEF, relief_flow),
        ("check_passage", CHECK, check_flow),
    ],
)
def test_the_flows_through_passage_and_path_add_up(name, values, flow):
    found = behind(name, VELOCITY, **values)
    expected = [brentq(lambda f, v=v: f / VALVE + flow(f) - v, -1e4, 1e4) for v in VELOCITY]
    assert np.abs(found - VALVE * VELOCITY).max() > 0.2 * np.abs(found).max()  # the passage matters
    assert np.abs(found - expected)[5:].max() < 0.01 * np.abs(expected).max()


@pytest.mark.parametrize(
    ("name", "values", "flow"),
    [
        ("relief_passage", RELIEF, relief_flow),
        ("check_passage", CHECK, check_flow),
    ],
)
def test_a_yield_builds_up_over_what_flows_through_the_gap(name, values, flow):
    """The state is the force of Dahl's yield; the flow of the gap follows from the pressure that both share."""
    most, stiffness, viscous = 900.0, 2e6, 800.0
    path = (entry("linear_viscous", rebound=viscous, compression=viscous),
            entry("dahl", force=most, stiffness=stiffness, exponent=1.0))  # fmt: skip

    def gap(v, yielding):
        return brentq(lambda u: u + flow(yielding + viscous * u) - v, -10.0, 10.0)

    def rate(t, yielding):
        u = gap(np.interp(t, TIME, VELOCITY), yielding[0])
        return [stiffness * u * (1.0 - yielding[0] / most * np.sign(u))]

    steps = {"rtol": 1e-6, "atol": 1e-2, "max_step": 2e-4}
    yielding = solve_ivp(rate, (0.0, TIME[-1]), [0.0], method="LSODA", t_eval=TIME, **steps).y[0]
    expected = yielding + viscous * np.array([gap(v, f) for v, f in zip(VELOCITY, yielding, strict=True)])
    found = force(name, motion(x=np.cumsum(VELOCITY) * 1e-3, v=VELOCITY), path=path, **values)
    error = (found - expected)[20:]
    assert np.sqrt(np.mean(error**2)) < 0.03 * np.std(expected)


def test_what_is_never_opened_changes_nothing():
    opening = dict.fromkeys(("opening_rebound", "opening_compression"), 1e5)
    damping = dict.fromkeys(("damping_rebound", "damping_compression"), 1e6)
    closed = behind("relief_passage", VELOCITY, **opening, **damping)
    assert closed == pytest.approx(VALVE * VELOCITY, abs=0.01 * VALVE * np.abs(VELOCITY).max())


def test_a_check_valve_claims_one_direction():
    tried = find_effect("check_passage").trial(RANGES)
    assert not tried.exclusion({"damping_rebound": 1e6, "damping_compression": 2e3})
    assert "both directions" in tried.exclusion({"damping_rebound": 3e3, "damping_compression": 2e3})


def test_a_relief_passage_claims_only_what_opens():
    tried = find_effect("relief_passage").trial(RANGES)
    assert not tried.exclusion(RELIEF)
    late = {"opening_rebound": 2000.0, "opening_compression": 2500.0}
    assert "beyond the recorded forces" in tried.exclusion(RELIEF | late)
    stiff = {"damping_rebound": 1e5, "damping_compression": 1e5}
    assert "beyond the recorded forces" in tried.exclusion(RELIEF | stiff)
