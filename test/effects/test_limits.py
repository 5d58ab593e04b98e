"""Limits in which one effect must equal another, or a known form."""

import numpy as np
import pytest
from motions import entry, force, sweep
from scipy.interpolate import PchipInterpolator, RegularGridInterpolator

from damper_estimator.effects.discovery import find_effect
from damper_estimator.signals.layout import COMMAND, DT, ROWS, A, T, V, X

DASHPOT = {"rebound": 2000.0, "compression": 1500.0}


@pytest.mark.parametrize("name", ["kwok", "guo", "cesmeci"])
def test_sigmoids_saturate_and_without_hysteresis_are_odd_in_velocity(name):
    block = sweep(amplitude=1.0, frequency=5.0)
    computed = force(block, entry(name, force=100.0, damping=50.0, hysteresis=0.0))
    limit = 100.0 * (np.pi / 2 if name == "cesmeci" else 1.0)
    assert np.abs(computed).max() == pytest.approx(limit, rel=0.01)
    assert np.sign(computed[np.abs(block[V]) > 0.1]) == pytest.approx(np.sign(block[V][np.abs(block[V]) > 0.1]))


def test_kwok_and_guo_without_hysteresis_are_the_same_and_a_steep_one_is_coulombs():
    block = sweep()
    kwok, guo = (force(block, entry(n, force=80.0, damping=500.0, hysteresis=0.0)) for n in ("kwok", "guo"))
    assert kwok == pytest.approx(guo, abs=1e-9)
    assert kwok == pytest.approx(force(block, entry("coulomb", force=80.0, transition=0.002)), abs=1e-9)


def test_guos_loop_opens_with_displacement_and_cesmecis_with_acceleration():
    """At zero velocity: by h x in the one, by h sgn(a) in the other."""
    block = sweep()
    turning = np.argmax(block[X])
    guo = force(block, entry("guo", force=100.0, hysteresis=20.0))
    assert guo[turning] == pytest.approx(100.0 * np.tanh(20.0 * 0.03), rel=1e-3)
    cesmeci = force(block, entry("cesmeci", force=100.0, hysteresis=-0.4))
    assert cesmeci[turning] == pytest.approx(100.0 * np.arctan(0.4), rel=1e-2)


@pytest.mark.parametrize("name", ["squash_displacement", "squash_stroke_side", "squash_acceleration_sign"])
def test_squashes_stay_below_their_height_and_reach_half_of_it_at_unit_argument(name):
    block = sweep(amplitude=2.0)
    computed = force(block, entry(name, force=200.0, damping=10.0, **{find_effect(name).parameters[2].name: 0.0}))
    assert np.abs(computed).max() < 200.0
    at_one = np.argmin(np.abs(block[V] - 0.1))
    assert computed[at_one] == pytest.approx(200.0 * 10 * block[V][at_one] / (1 + abs(10 * block[V][at_one])))


def test_semi_active_force_vanishes_without_current_and_grows_with_it():
    forces = [force(sweep(command=c), entry("semi_active_squash")) for c in (np.nan, 0.0, 0.5, 1.0)]
    assert not forces[0].any() and not forces[1].any()
    assert np.abs(forces[3]).max() > 2.0 * np.abs(forces[2]).max() > 0.0


def test_coil_lag_reaches_the_command_and_starts_on_it():
    block = sweep(command=1.0)
    lagged = force(block, entry("command_lag"), entry("semi_active_squash"))
    assert np.array_equal(lagged, force(block, entry("semi_active_squash")))
    block[COMMAND, :100] = 0.0
    late = force(block, entry("command_lag", time_constant=0.02), entry("semi_active_squash"))
    plain = force(block, entry("semi_active_squash"))
    assert np.abs(late[110]) < 0.9 * np.abs(plain[110])
    assert late[400:] == pytest.approx(plain[400:], rel=1e-5, abs=1e-3)


def test_stribeck_without_excess_is_coulomb():
    block = sweep()
    assert force(block, entry("stribeck", force=70.0, excess=0.0, transition=0.01)) == pytest.approx(
        force(block, entry("coulomb", force=70.0, transition=0.01)), abs=1e-9
    )


def test_lugre_without_excess_and_damping_is_dahl():
    block = sweep(rate=20000)
    lugre = force(block, entry("lugre", force=60.0, excess=0.0, stiffness=5e4, viscous=0.0))
    dahl = force(block, entry("dahl", force=60.0, stiffness=5e4, exponent=1.0))
    assert lugre == pytest.approx(dahl, abs=0.2)


def test_smooth_curve_is_scipys_pchip_between_its_knots():
    v = np.array([-1.0, -0.3, -0.1, 0.0, 0.05, 0.4, 1.0])
    f = np.array([-900.0, -500.0, -250.0, 0.0, 180.0, 180.0, 700.0])
    block = sweep(amplitude=0.06, frequency=2.5)
    computed = force(block, entry("smooth_curve", velocity=v.tolist(), force=f.tolist()))
    inner = (block[V] >= v[1]) & (block[V] <= v[-2])
    assert computed[inner] == pytest.approx(PchipInterpolator(v, f)(block[V][inner]), abs=1e-9)


def test_force_surface_is_bilinear():
    v, a = np.array([-0.5, -0.1, 0.0, 0.2, 0.5]), np.array([-8.0, 0.0, 3.0, 8.0])
    grid = np.random.default_rng(0).normal(0.0, 300.0, (v.size, a.size))
    block = sweep()
    computed = force(
        block, entry("force_surface", velocity=v.tolist(), acceleration=a.tolist(), force=grid.ravel().tolist())
    )
    points = np.stack([block[V].clip(-0.5, 0.5), block[A].clip(-8.0, 8.0)], axis=1)
    assert computed == pytest.approx(RegularGridInterpolator((v, a), grid)(points), abs=1e-9)


@pytest.mark.parametrize(("name", "values"), [
    ("oil_spring", {"stiffness_rebound": 1e9, "stiffness_compression": 1e9}),
    ("rubber_mount", {"stiffness": 1e9, "loss": 0.0}),
    ("joint_play", {"stiffness": 1e9, "play": 0.0}),
])  # fmt: skip
def test_rigid_joints_change_nothing(name, values):
    block = sweep()
    plain = force(block, entry("linear_viscous", **DASHPOT))
    assert force(block, entry(name, (entry("linear_viscous", **DASHPOT),), **values)) == pytest.approx(plain, abs=0.5)


def test_a_joint_with_play_moves_without_force_between_its_ends():
    block = sweep(rate=5000)
    computed = force(block, entry("joint_play", (entry("coulomb", force=200.0),), stiffness=5e6, play=0.002))
    settled = block[T] > 0.3
    loose = np.abs(computed[settled]) < 10.0
    travel = np.abs(block[V][settled])[loose].sum() / 5000 / 2.8  # crossings in 0.7 s at 2 Hz
    assert travel == pytest.approx(0.002, rel=0.15)


def test_fade_is_zero_at_the_reference_and_linear_around_it():
    for theta, share in ((40.0, 1.0), (60.0, 0.9), (20.0, 1.1)):
        block = sweep(temperature=theta)
        plain = force(block, entry("linear_viscous", **DASHPOT))
        assert force(block, entry("linear_viscous", **DASHPOT), entry("temperature_gain", fade=0.005)) == pytest.approx(
            share * plain
        )
    block = sweep()
    assert np.array_equal(
        force(block, entry("linear_viscous"), entry("temperature_gain", fade=0.01)),
        force(block, entry("linear_viscous")),
    )


def test_end_stops_are_zero_inside_and_progressive_beyond():
    block = sweep(amplitude=0.06)
    computed = force(
        block, entry("end_stop", bump_stiffness=1e6, bump_position=-0.05, top_out_stiffness=2e6, top_out_position=0.04)
    )
    inside = (block[X] > -0.05) & (block[X] < 0.04)
    assert not computed[inside].any()
    assert computed.min() == pytest.approx(-1e6 * 0.01**2) and computed.max() == pytest.approx(2e6 * 0.02**2)


def test_hydraulic_stops_are_zero_inside_never_drive_and_let_the_rod_return():
    block = sweep(amplitude=0.06)
    stops = {"bump_damping": 3000.0, "bump_position": -0.05, "rebound_damping": 5000.0, "rebound_position": 0.04}
    computed = force(block, entry("hydraulic_stop", **stops, way_back=0.2, depth=0.01))
    x, v = block[X], block[V]
    assert (
        not computed[(x > -0.05) & (x < 0.04)].any()
        and (computed * v >= 0.0).all()
        and computed.max() > 100.0 > -100.0 > computed.min()
    )
    free = force(block, entry("hydraulic_stop", **stops, way_back=0.0, depth=0.01))
    assert not free[(x < -0.05) & (v > 0.0)].any() and not free[(x > 0.04) & (v < 0.0)].any()
    both = force(block, entry("hydraulic_stop", **stops, way_back=1.0, depth=0.01))
    assert computed == pytest.approx(0.8 * free + 0.2 * both)
    orifice = force(block, entry("hydraulic_stop", **stops, way_back=1.0, depth=0.01, speed=0.2))
    assert orifice == pytest.approx(both * np.abs(block[V]) / 0.2)


@pytest.mark.parametrize("side", [-1.0, 0.0, 0.4, 1.0])
def test_a_direction_curve_changes_each_direction_by_its_share(side):
    block = sweep()
    computed = force(block, entry("direction_curve", speed=(0.1, 0.3), force=(40.0, 160.0), side=side))
    even = np.interp(np.abs(block[V]), [0.0, 0.1, 0.3], [0.0, 40.0, 160.0])
    even += np.maximum(np.abs(block[V]) - 0.3, 0.0) * 600.0
    assert computed == pytest.approx(np.where(block[V] > 0.0, 1.0 + side, 1.0 - side) * even)


def test_isothermal_gas_follows_boyle():
    block = sweep()
    computed = force(block, entry("gas_spring", static_force=300.0, volume=1e-4, rod_area=2e-4, exponent=1.0))
    assert computed * (1e-4 + 2e-4 * block[X]) == pytest.approx(np.full(computed.size, -300.0 * 1e-4))


def test_gates_of_both_directions_add_up_to_the_whole():
    block = sweep()
    half = [
        entry("path", (entry("linear_motion", damping=c), entry("direction_gate", direction=d)))
        for c, d in ((2000.0, 1.0), (1500.0, -1.0))
    ]
    assert force(block, *half) == pytest.approx(force(block, entry("linear_viscous", **DASHPOT)), abs=1e-9)


def test_quadratic_gas_equals_the_isentropic_one_to_second_order():
    block = sweep(amplitude=0.005)
    f, volume, area, n = 300.0, 1.5e-4, 1.5e-4, 1.4
    gas = force(block, entry("gas_spring", static_force=f, volume=volume, rod_area=area, exponent=n))
    r = area / volume
    series = entry("quadratic_gas", constant=-f, slope=f * n * r, square=-f * n * (n + 1) / 2 * r**2)
    assert force(block, series) == pytest.approx(gas, abs=1e-3)


def test_inertia_follows_newton():
    block = sweep()
    assert force(block, entry("inertia", mass=2.5)) == pytest.approx(2.5 * block[A])


def test_a_weak_force_does_not_cavitate():
    block = sweep()
    plain = force(block, entry("linear_viscous", **DASHPOT))
    assert np.array_equal(
        force(block, entry("linear_viscous", **DASHPOT), entry("cavitation_limit", limit=5000.0)), plain
    )


def test_a_relief_with_exponent_one_is_a_straight_loss_and_others_follow_a_power():
    block = sweep(amplitude=0.1)
    values = {"softening_rebound": 400.0, "opening_rebound": 0.2, "softening_compression": 0.0}
    far = block[V] > 0.6
    for exponent in (0.5, 1.0, 2.0):
        loss = -force(block, entry("relief", **values, exponent=exponent))
        past = (block[V][far] - 0.2) / 0.2
        # The offset of the rounded knee is 0.5 % of the opening speed.
        assert loss[far] == pytest.approx(400.0 * 0.2 * past**exponent, rel=0.03)
        assert np.abs(loss[block[V] <= 0.0]).max() == 0.0
        assert np.all(np.diff(loss[np.argsort(block[V])]) >= -1e-9)


@pytest.mark.parametrize(("check", "free"), [(1.0, -1.0), (-1.0, 1.0)])
def test_ports_with_a_check_valve_pass_oil_in_one_direction_only(check, free):
    block = sweep()
    plain = force(block, entry("linear_viscous", **DASHPOT))
    groove = {"share": 0.3, "middle": 0.0, "half_length": 0.02, "opening": 0.2}
    checked = force(block, entry("bypass_groove", **groove, check=check), entry("linear_viscous", **DASHPOT))
    unaffected = np.sign(block[V]) == free
    assert np.array_equal(checked[unaffected], plain[unaffected])
    both = force(block, entry("bypass_groove", **{**groove, "share": 0.6}), entry("linear_viscous", **DASHPOT))
    assert checked[~unaffected] == pytest.approx(both[~unaffected]), "all oil of both directions flows in one"


def test_oil_that_follows_at_every_speed_leaves_no_void():
    block = sweep()
    plain = force(block, entry("linear_viscous", **DASHPOT))
    fast = 1.01 * np.abs(block[V]).max()
    followed = force(block, entry("linear_viscous", **DASHPOT), entry("starved_intake", follows=fast, missing=1.0))
    assert np.array_equal(followed, plain)


def test_compression_lacks_force_until_the_void_of_the_rebound_is_closed():
    """Rebound at 0.5 m/s for 40 mm with oil that follows at 0.2 m/s leaves a void of 24 mm; compression closes it at
    0.5 + 0.2 m/s."""
    rate = 2000
    time = np.arange(round(0.2 * rate) + 1) / rate
    block = np.full((ROWS, time.size), np.nan)
    block[T], block[DT] = time, np.diff(time, prepend=0.0)
    block[V] = np.where(time < 0.08, 0.5, -0.5)
    block[X] = np.cumsum(block[V]) / rate
    block[A] = 0.0
    computed = force(block, entry("linear_viscous", **DASHPOT), entry("starved_intake", follows=0.2, missing=0.75))
    closed = time[np.flatnonzero(computed < -0.5 * 1500.0 * 0.99)[0]]
    assert closed == pytest.approx(0.08 + 0.024 / 0.7, abs=0.002)
    assert computed[(time > 0.085) & (time < closed - 0.002)] == pytest.approx(-0.25 * 0.5 * 1500.0)
    assert computed[time < 0.08] == pytest.approx(0.5 * 2000.0), "rebound is as before"


def test_a_void_above_the_piston_mirrors_one_below_it():
    block, mirrored = sweep(), sweep()
    mirrored[[X, V, A]] *= -1.0
    alike = {"rebound": 1800.0, "compression": 1800.0}
    below = force(block, entry("linear_viscous", **alike), entry("starved_intake", follows=0.1, missing=0.8))
    above = force(
        mirrored, entry("linear_viscous", **alike), entry("starved_intake", follows=0.1, missing=0.8, side=-1.0)
    )
    assert np.array_equal(above, -below) and not np.array_equal(below, force(block, entry("linear_viscous", **alike)))


def test_a_valve_that_is_always_open_is_a_mass():
    block = sweep(amplitude=0.1)
    open_valve = force(block, entry("valve_inertia", mass_rebound=2.0, mass_compression=2.0, opening=1e-3))
    mass = force(block, entry("inertia", mass=2.0))
    moving = np.abs(block[V]) > 0.01
    assert open_valve[moving] == pytest.approx(mass[moving])
    closed = force(block, entry("valve_inertia", mass_rebound=2.0, mass_compression=2.0, opening=5.0))
    assert np.abs(closed).max() < 0.05 * np.abs(mass).max()
