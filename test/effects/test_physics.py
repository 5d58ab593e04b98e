"""Each effect follows its equation: values computed by hand, and limits."""

import numpy as np
import pytest

from damper_estimator.effects.discovery import find_effect
from damper_estimator.errors import InputError
from damper_estimator.model import make_element
from damper_estimator.model.damper_model import DamperModel
from damper_estimator.signals.layout import COMMAND, DT, ROWS, A, T, V, X


def motion(x=0.0, v=0.0, a=0.0, command=np.nan, dt=0.001):
    """A block from broadcast columns."""
    columns = np.broadcast_arrays(*(np.atleast_1d(np.asarray(c, float)) for c in (x, v, a, command)))
    block = np.full((ROWS, columns[0].size), np.nan)
    block[X], block[V], block[A], block[COMMAND] = columns
    block[DT] = dt
    block[DT, 0] = 0.0
    block[T] = np.cumsum(block[DT])
    return block


def force(name, block, before=(), path=(), **values):
    """Force of one effect after the entries ``before``."""
    return DamperModel("m", "", (*before, make_element(find_effect(name), values, path))).force(block)


def entry(name, **values):
    return make_element(find_effect(name), values)


def test_viscous_curve_passes_its_knots_and_is_straight_between_and_beyond():
    knots = {"velocity": [-1.0, 0.0, 0.5, 2.0], "force": [-600.0, 0.0, 400.0, 1000.0]}
    v = np.array([-2.0, -1.0, -0.5, 0.0, 0.25, 0.5, 1.25, 2.0, 3.0])
    expected = [-1200.0, -600.0, -300.0, 0.0, 200.0, 400.0, 700.0, 1000.0, 1400.0]
    assert force("viscous_curve", motion(v=v), **knots) == pytest.approx(expected)


def test_viscous_curve_needs_rising_knots():
    with pytest.raises(InputError, match="rising"):
        entry("viscous_curve", velocity=[0.0, 0.0], force=[1.0, 2.0])


def test_hydraulics_follow_the_leak_at_low_and_the_blow_off_at_high_speed():
    values = dict(
        leak_rebound=20000.0, preload_rebound=300.0, spring_rebound=500.0, port_rebound=0.0, transition_rebound=8.0
    )
    slow, fast = 0.01, 3.0
    leak = 20000.0 * 15.0**0.25 * slow**1.75
    assert force("leak_blow_off_port", motion(v=slow), **values) == pytest.approx(leak, rel=1e-3)
    assert force("leak_blow_off_port", motion(v=fast), **values) == pytest.approx(300.0 + 500.0 * fast, rel=1e-3)


def test_hydraulics_equal_the_published_formula():
    k, preload, spring, transition, port, v = 9000.0, 250.0, 700.0, 2.5, 120.0, -0.4
    flow = 15.0**0.25 * abs(v) ** 1.75
    leak, blow = k * flow, preload + spring * abs(v)
    published = leak * blow / (leak**transition + blow**transition) ** (1 / transition) + port * flow
    values = dict(
        leak_compression=k,
        preload_compression=preload,
        spring_compression=spring,
        transition_compression=transition,
        port_compression=port,
    )
    assert force("leak_blow_off_port", motion(v=v), **values) == pytest.approx(-published)


def test_gas_pushes_the_rod_out_and_more_so_in_compression():
    x = np.array([-0.05, 0.0, 0.05])
    gas = force("gas_spring", motion(x=x), static_force=300.0, volume=1e-4, rod_area=2e-4)
    assert gas[1] == pytest.approx(-300.0)
    assert gas == pytest.approx(-300.0 * (1e-4 / (1e-4 + 2e-4 * x)) ** 1.4)
    assert abs(gas[0]) - 300.0 > 300.0 - abs(gas[2]) > 0.0


def test_seal_friction_is_viscous_below_the_switch_and_coulombs_above():
    v = np.array([-0.1, -0.007, -0.0035, 0.0, 0.0035, 0.007, 0.1])
    expected = [-40.0, -40.0, -20.0, 0.0, 30.0, 60.0, 60.0]
    assert force("seal_friction", motion(v=v), rebound=60.0, compression=40.0) == pytest.approx(expected)


def test_force_lag_of_a_step_is_exponential_and_of_a_ramp_exact():
    dt, tau = 0.001, 0.004
    n = np.arange(50)
    base = entry("linear_viscous", rebound=1.0, compression=1.0)
    ramp = force("force_lag", motion(v=n * dt, dt=dt), before=(base,), time_constant=tau)
    time = n * dt
    assert ramp == pytest.approx(time - tau + tau * np.exp(-time / tau), abs=1e-12)


def test_command_lag_does_not_change_the_motion_outside_its_path():
    lag = entry("command_lag", time_constant=0.02)
    inside = make_element(find_effect("path"), {}, (lag, entry("coulomb", force=10.0)))
    block = motion(v=1.0, command=np.array([0.0] + [1.0] * 20))
    before = block.copy()
    DamperModel("m", "", (inside,)).force(block)
    assert np.array_equal(block, before, equal_nan=True)


def test_position_gain_is_one_in_the_middle():
    base = entry("linear_viscous", rebound=100.0, compression=100.0)
    x = np.array([0.01, 0.06, -0.04])
    gained = force("position_gain", motion(x=x, v=1.0), before=(base,), gain=0.5, middle=0.01, scale=0.05)
    assert gained == pytest.approx([100.0, 150.0, 150.0])


def test_a_stiff_oil_spring_changes_nothing():
    dashpot = entry("linear_viscous", rebound=2000.0, compression=1500.0)
    t = np.arange(400) * 0.002
    block = motion(x=0.01 * np.sin(15 * t), v=0.15 * np.cos(15 * t), dt=0.002)
    soft = force("oil_spring", block, path=(dashpot,), stiffness_rebound=1e9, stiffness_compression=1e9)
    assert soft == pytest.approx(DamperModel("m", "", (dashpot,)).force(block), abs=1e-3 * 300)


@pytest.mark.parametrize("steps", [400])
def test_oil_spring_and_dashpot_converge_to_the_maxwell_element_at_second_order(steps):
    c, k, omega, time = 2000.0, 5e4, 20.0, 1.0
    errors = []
    for size in (steps, 2 * steps, 4 * steps):
        t = np.linspace(0.0, time, size + 1)
        block = motion(x=0.01 * np.sin(omega * t), v=0.01 * omega * np.cos(omega * t), dt=time / size)
        computed = force("oil_spring", block, path=(entry("linear_viscous", rebound=c, compression=c),),
                    stiffness_rebound=k, stiffness_compression=k)  # fmt: skip
        tau = c / k
        # tau F' + F = c v with the start value of a loaded spring
        steady = c * 0.01 * omega * (np.cos(omega * t) + omega * tau * np.sin(omega * t)) / (1 + (omega * tau) ** 2)
        exact = steady + (c * 0.01 * omega - steady[0]) * np.exp(-t / tau)
        errors.append(np.abs(computed - exact)[-1])
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx([2.0, 2.0], abs=0.15)


def test_series_in_series_adds_the_compliances():
    dashpot = entry("linear_viscous", rebound=2000.0, compression=2000.0)
    t = np.arange(500) * 0.001
    block = motion(x=0.02 * np.sin(12 * t), v=0.24 * np.cos(12 * t), dt=0.001)
    inner = make_element(
        find_effect("oil_spring"), {"stiffness_rebound": 1e5, "stiffness_compression": 1e5}, (dashpot,)
    )
    both = force("oil_spring", block, path=(inner,), stiffness_rebound=1e5, stiffness_compression=1e5)
    one = force("oil_spring", block, path=(dashpot,), stiffness_rebound=5e4, stiffness_compression=5e4)
    assert both == pytest.approx(one, abs=1e-3 * np.abs(one).max())


def test_channel_skew_delays_the_force():
    base = entry("linear_viscous", rebound=1.0, compression=1.0)
    v = np.arange(100) * 0.001
    late = force("channel_skew", motion(v=v, dt=0.001), before=(base,), skew=0.005)
    assert late[10:] == pytest.approx(v[10:] - 0.005)
