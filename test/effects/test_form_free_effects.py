"""Effects of any form: surfaces, Maxwell slip, pockets of gas; values computed by hand, and limits."""

import numpy as np
import pytest
from test_physics import entry, force, motion

from damper_estimator.effects.discovery import find_effect
from damper_estimator.signals.layout import TEMPERATURE

TABLE = dict(speed=[0.1, 0.5], middle=0.0, reach=0.02)


def surface(x, v, **values):
    zero = [0.0, 0.0]
    names = ("extended_rebound", "extended_compression", "compressed_rebound", "compressed_compression")
    return force("position_surface", motion(x=x, v=v), **TABLE, **{name: values.get(name, zero) for name in names})


def test_position_surface_acts_at_its_end_and_in_its_direction_only():
    x, v = np.array([0.02, 0.02, -0.02, -0.02, 0.0]), np.array([0.1, -0.1, 0.1, -0.1, 0.1])
    found = surface(x, v, extended_rebound=[50.0, 90.0])
    assert found == pytest.approx([50.0, 0.0, 0.0, 0.0, 0.0])
    found = surface(x, v, compressed_compression=[-30.0, -70.0])
    assert found == pytest.approx([0.0, 0.0, 0.0, -30.0, 0.0])


def test_position_surface_is_straight_between_knots_held_beyond_the_ends_and_zero_at_rest():
    v = np.array([0.0, 0.05, 0.3, 0.9])
    assert surface(0.01, v, extended_rebound=[50.0, 90.0]) == pytest.approx([0.0, 12.5, 35.0, 45.0])
    assert surface(0.05, v, extended_rebound=[50.0, 90.0]) == pytest.approx([0.0, 25.0, 70.0, 90.0])


def test_temperature_surface_is_zero_where_the_model_holds_and_without_a_thermometer():
    values = dict(speed=[0.2, 0.4], reference=30.0, span=10.0, gas=5.0, rebound=[-40.0, 0.0], compression=[60.0, 0.0])
    block = motion(v=np.array([0.2, -0.2, 0.0]))
    assert not force("temperature_surface", block, **values).any()
    for celsius, share in ((30.0, 0.0), (40.0, 1.0), (25.0, -0.5)):
        block[TEMPERATURE] = celsius
        expected = share * np.array([-35.0, 65.0, 5.0])
        assert force("temperature_surface", block, **values) == pytest.approx(expected)


def test_command_surface_depends_on_the_size_of_the_command():
    values = dict(speed=[0.1, 0.2], reference=0.5, span=1.0, rebound=[100.0, 0.0], compression=[-80.0, 0.0])
    block = motion(v=np.array([0.1, 0.1, -0.1, 0.1]), command=np.array([1.5, -1.5, 1.5, 0.0]))
    assert force("command_surface", block, **values) == pytest.approx([100.0, 100.0, -80.0, -50.0])
    assert not force("command_surface", motion(v=0.1), **values).any()


def test_maxwell_slip_follows_masing_after_a_reversal():
    x = np.concatenate([np.linspace(0.0, 5e-3, 500), np.linspace(5e-3, -5e-3, 1000)])
    found = force("maxwell_slip", motion(x=x), travel=[1e-3, 2e-3], force=[30.0, 50.0])
    assert found[499] == pytest.approx(80.0)
    # Back by twice the travel of an element it slides the other way: the loop is the first curve, doubled.
    back = {travel: found[499 + np.argmin(np.abs(x[499:] - (5e-3 - travel)))] for travel in (2e-3, 4e-3)}
    assert back[2e-3] == pytest.approx(80.0 - 2.0 * (30.0 + 25.0), abs=0.5)
    assert back[4e-3] == pytest.approx(-80.0, abs=0.5)


def test_maxwell_slip_with_short_travels_is_dry_friction_that_dissipates():
    t = np.arange(0.0, 2.0, 1e-3)
    x, v = 0.01 * np.sin(6.0 * t), 0.06 * np.cos(6.0 * t)
    found = force("maxwell_slip", motion(x=x, v=v), travel=[1e-6, 1e-5], force=[15.0, 25.0])
    sliding = (np.abs(v) > 0.005) & (t > 0.0)
    assert found[sliding] == pytest.approx(40.0 * np.sign(v[sliding]))
    assert np.sum(found * v) > 0.0


def behind(effect, v, **values):
    """Force of a viscous damper behind a compliance, at 1 kHz."""
    path = (entry("linear_viscous", rebound=5000.0, compression=5000.0),)
    return force(effect, motion(x=np.cumsum(v) * 1e-3, v=v), path=path, **values)


def test_a_gas_pocket_with_distant_limits_is_the_oil_alone():
    v = 0.3 * np.sin(30.0 * np.arange(0.0, 1.0, 1e-3))
    found = behind("gas_pocket", v, stiffness=1e6, limit_rebound=1e6, limit_compression=1e6)
    oil = behind("oil_spring", v, stiffness_rebound=1e6, stiffness_compression=1e6)
    assert found == pytest.approx(oil, abs=0.01 * np.abs(oil).max())


def test_a_gas_pocket_limits_one_direction_and_takes_travel_from_the_other():
    v = 0.3 * np.sin(30.0 * np.arange(0.0, 1.0, 1e-3))
    whole = behind("gas_pocket", v, stiffness=4e6, limit_rebound=1e6, limit_compression=1e6)
    found = behind("gas_pocket", v, stiffness=4e6, limit_rebound=1e6, limit_compression=500.0)
    assert found.min() > -500.0 > whole.min()
    # After compression the pocket closes first: rebound starts without force.
    later = np.flatnonzero((v[:-1] <= 0.0) & (v[1:] > 0.0))[1] + 15
    assert whole[later] > 0.2 * whole.max() > found[later]


@pytest.mark.parametrize("rate", [200.0, 500.0, 1000.0])
def test_a_compliance_hardly_depends_on_the_rate(rate):
    path = (entry("linear_viscous", rebound=8000.0, compression=8000.0),)

    def run(rate):
        t, omega = np.arange(0.0, 1.0, 1.0 / rate), 2.0 * np.pi * 8.0
        block = motion(x=0.01 * np.sin(omega * t), v=0.01 * omega * np.cos(omega * t), dt=1.0 / rate)
        return t, force("oil_spring", block, path=path, stiffness_rebound=5e6, stiffness_compression=5e6)

    time, fine = run(20_000.0)
    at, coarse = run(rate)
    error = coarse[at > 0.2] - np.interp(at[at > 0.2], time, fine)
    assert np.abs(error).max() < 0.01 * np.abs(fine).max()


def test_filled_rubber_builds_up_half_of_its_friction_over_its_travel_and_masing_doubles_the_loop():
    values = dict(stiffness=1e6, dry=100.0, travel=1e-4)
    d = np.concatenate([[0.0], np.linspace(0.0, 0.05, 2000)[1:], np.linspace(0.05, 0.0, 2000)[1:]])
    # The effect's own force over its deflection: a path so stiff that all motion goes into the mount.
    kernel = find_effect("filled_rubber").kernel
    found, state = np.zeros(d.size), np.zeros(5)
    kernel(np.array(list(values.values())), np.zeros(0), motion(x=d), state, found)
    friction = found - 1e6 * d
    rising, falling = d[:2000], np.abs(d[2000:] - 0.05)
    assert np.interp(1e-4, rising, friction[:2000]) == pytest.approx(50.0, rel=0.02)
    assert friction[1999] == pytest.approx(100.0, rel=0.01)
    # From full friction the other way: half of the change of 200 N over twice the travel.
    assert np.interp(2e-4, falling, friction[2000:]) == pytest.approx(0.0, abs=3.0)


def test_filled_rubber_loses_energy_in_every_cycle():
    v = 0.3 * np.sin(30.0 * np.arange(0.0, 2.0, 1e-3))
    plain = behind("oil_spring", v, stiffness_rebound=2e6, stiffness_compression=2e6)
    filled = behind("filled_rubber", v, stiffness=2e6, dry=200.0, travel=5e-5)
    assert np.isfinite(filled).all() and np.abs(filled - plain).max() > 5.0
    assert np.sum(filled * v) > 0.0
