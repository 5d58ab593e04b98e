"""Effects with memory: their limits, laws and declared order of convergence."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.effects.delay_line import STATES, delayed
from damper_estimator.effects.discovery import all_effects, find_effect
from damper_estimator.effects.trial import Ranges
from damper_estimator.model import make_element
from damper_estimator.model.damper_model import DamperModel
from damper_estimator.signals.layout import COMMAND, DT, PRESSURE, ROWS, TEMPERATURE, A, T, V, X

STATEFUL = [n for n, e in all_effects().items() if e.order > 0 and e.kind != "channel"]


def sine(rate, seconds=1.0, amplitude=0.02, frequency=2.0, jitter=0.0):
    """Exact kinematics of a sine that starts in the middle."""
    time = np.arange(round(seconds * rate) + 1) / rate
    omega = 2 * np.pi * frequency
    block = np.full((ROWS, time.size), np.nan)
    block[T], block[DT] = time, np.diff(time, prepend=0.0)
    block[X] = amplitude * np.sin(omega * time)
    block[V] = amplitude * omega * np.cos(omega * time)
    block[A] = -(omega**2) * block[X]
    block[COMMAND] = 0.5 + 0.5 * np.sin(3.0 * time)
    block[TEMPERATURE], block[PRESSURE] = 40.0, 2e6
    return block


def force(name, block, before=(), **values):
    return DamperModel("m", "", (*before, make_element(find_effect(name), values))).force(block)


@pytest.mark.parametrize("name", STATEFUL)
def test_error_falls_with_the_step_at_least_as_the_declared_order_says(name):
    """Against the effect itself at a 64 times finer step; as a mean over the record, since reversals fall between
    samples.
    """
    effect = find_effect(name)
    base = make_element(find_effect("linear_viscous"))
    values = {"cavitation_limit": {"limit": 200.0}, "maxwell_slip": {"force": (50.0, 80.0, 30.0)}}.get(name, {})
    element = make_element(effect, values, (base,) if effect.kind == "series" else ())
    effects = {
        "input": (element, make_element(find_effect("semi_active_squash")), base),
        "modifier": (base, element),
    }.get(effect.kind, (element,))
    model = DamperModel("m", "", effects)
    rates = (500, 1000, 2000)
    fine = model.force(sine(64 * rates[0], frequency=1.7))
    scale = np.abs(fine).max()
    errors = []
    for rate in rates:
        step = 64 * rates[0] // rate
        coarse = model.force(sine(rate, frequency=1.7))
        errors.append(np.mean(np.abs(coarse - fine[::step][: coarse.size])[5:]) / scale)
    if errors[-1] < 1e-5:
        return  # exact, except for the samples of a delay line, at least 0.8 ms apart
    slope = np.polyfit(np.log(1.0 / np.array(rates)), np.log(np.array(errors) + 1e-15), 1)[0]
    assert slope > effect.order - 0.35, errors


def test_dahl_becomes_coulomb_as_its_stiffness_grows():
    block = sine(1000)
    sliding = (np.abs(block[V]) > 0.1) & (block[T] > 0.1)
    errors = [
        np.abs(force("dahl", block, force=100.0, stiffness=k) - 100.0 * np.sign(block[V]))[sliding].max()
        for k in (1e4, 1e5, 1e6)
    ]
    assert errors[0] > errors[1] > errors[2] and errors[2] < 1.0


@pytest.mark.parametrize("exponent", [0.5, 1.0, 1.5, 2.0])
def test_dahl_follows_its_closed_form_over_a_monotone_travel(exponent):
    way = np.linspace(0.0, 0.004, 200)
    block = sine(1000, 0.199)
    block[X] = way
    block[V] = 0.02
    computed = force("dahl", block, force=80.0, stiffness=5e4, exponent=exponent)
    y, h = 1.0, way[1] / 200
    expected = [0.0]
    for _ in range(199):
        for _ in range(200):
            y = max(y - h * 5e4 / 80.0 * y**exponent, 0.0)
        expected.append(80.0 * (1.0 - y))
    assert computed == pytest.approx(expected, abs=0.1)


def test_dahl_does_not_depend_on_the_rate():
    slow, fast = sine(1000, 2.0, frequency=1.0), sine(1000, 2.0, frequency=1.0)
    fast[DT] /= 10.0
    fast[V] *= 10.0
    assert np.array_equal(force("dahl", slow), force("dahl", fast))


@pytest.mark.parametrize("n", [1.0, 1.5, 3.0, 8.0])
def test_bouc_wen_saturates_at_its_limit(n):
    values = {"alpha": 150.0, "delta": 400.0, "beta": 180.0, "gamma": 90.0, "n": n}
    computed = force("bouc_wen", sine(1000, 2.0, amplitude=0.05), **values)
    limit = 150.0 * (400.0 / 270.0) ** (1.0 / n)
    assert np.abs(computed).max() == pytest.approx(limit, rel=1e-3)


@pytest.mark.parametrize("n", [1.0, 1.5, 2.0, 5.0])
@pytest.mark.parametrize("beta", [1e-3, 100.0, 199.0])
def test_bouc_wen_follows_its_equation_in_steps_of_any_length(n, beta):
    gamma, limit = 200.0 - beta, (400.0 / 200.0) ** (1.0 / n)
    random = np.random.default_rng(3)
    moves = random.choice([-1.0, 1.0], 60) * limit / 400.0 * 10.0 ** random.uniform(-2.0, 1.0, 60)
    block = sine(100, 0.6)[:, :61]
    block[X] = np.concatenate([[0.0], np.cumsum(moves)])
    computed = force("bouc_wen", block, alpha=1.0, delta=400.0, beta=beta, gamma=gamma, n=n)
    for before, after, move in zip(computed, computed[1:], moves, strict=False):
        way = np.sign(move)
        exact = solve_ivp(
            lambda _, z, way=way: way * (400.0 - (beta + gamma * np.sign(way * z)) * np.abs(z) ** n),
            (0.0, abs(move)), [before], rtol=1e-9, atol=1e-11, max_step=abs(move) / 50.0,
        ).y[0, -1]  # fmt: skip
        assert after == pytest.approx(exact, abs=5e-4 * limit)


def test_bouc_wens_scale_of_z_is_redundant_with_alpha():
    block, n, c = sine(1000), 2.0, 3.0
    one = force("bouc_wen", block, alpha=100.0, delta=300.0, beta=200.0, gamma=50.0, n=n)
    other = force(
        "bouc_wen", block, alpha=100.0 / c, delta=300.0 * c, beta=200.0 * c ** (1 - n), gamma=50.0 * c ** (1 - n), n=n
    )
    assert one == pytest.approx(other, abs=1e-6 * np.abs(one).max())


def test_shifted_bouc_wen_without_shift_is_bouc_wen():
    block = sine(700)
    assert force("bouc_wen_shifted", block, mu=0.0) == pytest.approx(force("bouc_wen", block), abs=1e-12)


def test_renault_hysteresis_keeps_the_peaks_of_its_sines_and_closes_in_fast_compression():
    """At the peak velocity of a sine of the table's frequency the compensation cancels the hysteresis."""
    frequency, peak = 1.5, 0.4
    values = {"alpha": 120.0, "delta": 600.0, "beta": 300.0, "gamma": 70.0, "n": 3.0, "frequency": frequency}
    block = sine(6000, 2.0, peak / (2 * np.pi * frequency), frequency)
    computed = force("renault_hysteresis", block, **values)
    last_cycle = slice(-4001, None)
    rebound_peak = np.argmax(block[V][last_cycle])
    assert computed[last_cycle][rebound_peak] == pytest.approx(0.0, abs=0.02 * 120.0)
    fast_compression = block[V][last_cycle] < -0.3
    assert np.abs(computed[last_cycle][fast_compression]).max() < 1e-9


def test_lugre_slides_at_coulombs_force_plus_viscous():
    block = sine(2000, 0.1)
    block[V] = 0.2
    computed = force("lugre", block, force=60.0, excess=0.0, stiffness=2e5, viscous=100.0)
    assert computed[-1] == pytest.approx(60.0 + 20.0, rel=1e-6)


def test_a_zero_delay_changes_nothing_and_a_delay_shifts():
    block = sine(1000)
    base = make_element(find_effect("linear_viscous"), {"rebound": 1.0, "compression": 1.0})
    plain = DamperModel("m", "", (base,)).force(block)
    assert np.array_equal(force("force_delay", block, before=(base,), delay=0.0), plain)
    late = force("force_delay", block, before=(base,), delay=0.0155)
    assert late[100:] == pytest.approx(np.interp(block[T] - 0.0155, block[T], plain)[100:], abs=1e-12)
    moved = DamperModel("m", "", (make_element(find_effect("velocity_delay"), {"delay": 0.0155}), base)).force(block)
    assert moved == pytest.approx(late, abs=1e-12)


@pytest.mark.parametrize("rate", [200, 1000, 4000, 20000])
def test_the_longest_delay_fits_at_any_rate(rate):
    state, time = np.zeros(STATES), np.arange(2 * rate) / rate
    out = [delayed(state, 0.0 if i == 0 else 1.0 / rate, t, 0.2) for i, t in enumerate(time)]
    after = time > 0.25
    assert np.array(out)[after] == pytest.approx(time[after] - 0.2, abs=1e-9)
    assert not np.array(out)[time < 0.15].any()


def test_cavitation_limits_compression_until_the_void_is_filled():
    block = sine(20000, 2.0)
    base = make_element(find_effect("linear_viscous"), {"rebound": 3000.0, "compression": 3000.0})
    plain = DamperModel("m", "", (base,)).force(block)
    limited = force("cavitation_limit", block, before=(base,), limit=200.0, held=1.0)
    assert limited.min() == pytest.approx(-200.0)
    is_limited = limited != plain
    assert limited[is_limited] == pytest.approx(-200.0)
    # Piston travel less the inflow at the limit's speed: the void closes again after the reversal.
    inflow = 200.0 / 3000.0
    edges = np.flatnonzero(np.diff(is_limited.astype(int)))
    for first, last in zip(edges[::2], edges[1::2], strict=False):
        opened = np.sum((-block[V, first + 1 : last] - inflow) * block[DT, first + 1 : last])
        assert abs(opened) < 1e-4
        assert block[V, last] > -inflow


def test_heat_fades_the_force_and_a_cold_damper_does_not():
    block = sine(200, 60.0, amplitude=0.05)
    base = make_element(find_effect("linear_viscous"), {"rebound": 3000.0, "compression": 3000.0})
    plain = DamperModel("m", "", (base,)).force(block)
    faded = force("dissipation_fade", block, before=(base,), fade=0.01, capacity=200.0)
    share = faded[np.abs(plain) > 10] / plain[np.abs(plain) > 10]
    assert share[0] == pytest.approx(1.0, abs=1e-3)
    assert share[-1] < 0.9 and (np.diff(share) < 1e-3).all()


def test_a_warm_chamber_fades_the_force_of_a_damper_that_hardly_works():
    block = sine(200, 60.0, amplitude=1e-3)
    base = make_element(find_effect("linear_viscous"), {"rebound": 3000.0, "compression": 3000.0})
    plain = DamperModel("m", "", (base,)).force(block)
    faded = force("dissipation_fade", block, before=(base,), fade=0.01, capacity=1e4, warming=0.5, cooling=1e4)
    moving = np.abs(plain) > 0.1 * np.abs(plain).max()
    # 0.5 K/s for a minute, at 1 % per kelvin.
    expected = 1.0 - 0.01 * 0.5 * (block[T] - block[T][0])
    assert faded[moving] / plain[moving] == pytest.approx(expected[moving], abs=5e-3)


def slip_over(places, **values):
    """Force of ``elastic_slip`` on straight ways between places, in small steps."""
    parts = [np.linspace(a, b, 400, endpoint=False) for a, b in zip(places, places[1:], strict=False)]
    x = np.concatenate([*parts, places[-1:]])
    block = np.full((ROWS, x.size), np.nan)
    block[T], block[DT], block[X] = 1e-3 * np.arange(x.size), np.minimum(np.arange(x.size), 1) * 1e-3, x
    return x, force("elastic_slip", block, **values)


def test_elastic_slip_reverses_along_the_first_loading_at_twice_its_size():
    x, found = slip_over([0.0, 8e-3, -8e-3], force=100.0, way=1e-3, spread=1.0)
    loading, ways = found[:401], 8e-3 - x[400:]
    expected = 100.0 - 2.0 * np.interp(0.5 * ways, x[:401], loading)
    np.testing.assert_allclose(found[400:], expected, atol=0.5)


def test_a_small_loop_of_elastic_slip_closes_and_the_large_one_goes_on():
    _, whole = slip_over([0.0, 3e-3], force=100.0, way=1e-3, spread=1.0)
    _, broken = slip_over([0.0, 1e-3, 0.6e-3, 1e-3, 3e-3], force=100.0, way=1e-3, spread=1.0)
    assert broken[1200] == pytest.approx(broken[400], abs=1e-9)
    assert broken[-1] == pytest.approx(whole[-1], abs=1e-9)


def test_elastic_slip_of_equal_parts_is_elastic_and_then_slides():
    x, found = slip_over([0.0, 3e-3], force=100.0, way=1e-3, spread=0.1)
    np.testing.assert_allclose(found, 100.0 * np.minimum(x / 1e-3, 1.0), atol=3.0)


def test_friction_of_contacts_is_elastic_slip_without_creep():
    block = sine(500)
    expected = force("elastic_slip", block.copy(), force=80.0, way=2e-4, spread=0.7)
    np.testing.assert_allclose(force("contact_friction", block, force=80.0, travel=2e-4, spread=0.7), expected)


@pytest.mark.parametrize("name", ["contact_friction", "dahl"])
def test_friction_that_slides_late_is_less_plausible_and_then_none(name):
    tried = find_effect(name).trial(Ranges(-0.03, 0.03, speed=0.5, acceleration=20.0, force=500.0, seconds=20.0))

    def values(travel):
        return {"force": 80.0, "travel": travel, "stiffness": 80.0 / travel, "spread": 1.0, "exponent": 1.0}

    plausible = [tried.plausible(values(travel)) for travel in np.geomspace(1e-4, 4e-3, 30)]
    assert np.all(np.diff(plausible) <= 0.0) and plausible[0] == 1.0 and plausible[-1] < limits().tied
    assert tried.plausible(values(4e-4)) == 1.0 and tried.plausible(values(8e-4)) < 0.5

    def refused(travel):
        _, latest = tried.limits.get("travel", (0.0, np.inf))
        return travel > latest or bool(tried.exclusion and "no friction" in tried.exclusion(values(travel)))

    assert not refused(1e-3) and refused(3e-3)


@pytest.mark.parametrize(
    ("name", "friction", "hysteresis"),
    [
        ("bouc_wen", *({"delta": d, "beta": 0.6 * d, "gamma": 0.4 * d, "n": 1.0} for d in (5e3, 1e3))),
        ("tanh_hysteresis", {"steepness": 50.0, "shift": 2e-4}, {"steepness": 50.0, "shift": 3e-3}),
    ],
)  # fmt: skip
def test_hysteresis_without_memory_is_friction(name, friction, hysteresis):
    tried = find_effect(name).trial(Ranges(-0.03, 0.03, speed=0.5, acceleration=20.0, force=500.0, seconds=20.0))
    assert "friction" in tried.exclusion(friction) and tried.imitates == "friction step"
    assert not tried.exclusion(hysteresis)


def yield_over(block, creep, way=1e-3, spread=1.0):
    """Share of the yield force, at a constant saturating command."""
    block[COMMAND] = 1.0
    values = {"force": 1.0, "saturation": 1e-3, "way": way, "spread": spread, "creep": creep}
    return force("command_slip", block, **values)


def test_yield_without_creep_is_elastic_slip():
    block = sine(500)
    expected = force("elastic_slip", block.copy(), force=1.0, way=1e-3, spread=1.0)
    np.testing.assert_allclose(yield_over(block, 0.0), expected, atol=1e-12)


@pytest.mark.parametrize(("speed", "share"), [(2e-3, 0.4), (4e-3, 0.8), (0.05, 1.0), (-2e-3, -0.4)])
def test_a_yield_that_creeps_is_viscous_below_its_speed(speed, share):
    block = sine(500, seconds=4.0)
    block[X] = speed * block[T]
    assert yield_over(block, 5e-3)[-1] == pytest.approx(share, rel=1e-3)


def test_held_still_a_yield_that_creeps_relaxes_as_the_equation_says():
    """Where no part slips, w ds/dt = -v_c s with the harmonic mean of the travels."""
    block = sine(2000, seconds=0.5)
    block[X] = np.where(block[T] > 0.0, 2e-4, 0.0)
    found = yield_over(block, 5e-3)[1:]
    ways = 1e-3 * np.exp(np.linspace(-1.0, 1.0, 9))
    rate = 5e-3 * np.mean(1.0 / ways)
    np.testing.assert_allclose(found, found[0] * np.exp(-rate * (block[T][1:] - block[T][1])), atol=3e-4)


def test_creep_has_an_end_in_steps_of_any_length():
    block = sine(20, amplitude=0.3, frequency=9.7)
    found = yield_over(block, 1.0, way=1e-6, spread=4.0)
    assert np.isfinite(found).all() and np.abs(found).max() <= 1.0


def field(commands, name="command_hysteresis", hold=1, **values):
    """Command (n,) that a linear yield force shows behind an effect of the command."""
    block = sine(1000, (hold * len(commands) - 1) / 1000.0)
    block[X], block[V], block[A] = 0.0, 1e8, 0.0
    block[COMMAND] = np.repeat(np.asarray(commands, float), hold)
    slip = make_element(find_effect("semi_active_squash"), {"gain": 1.0, "damping": 1e5, "stiffness": 0.0})
    return DamperModel("m", "", (make_element(find_effect(name), values), slip)).force(block)


def test_the_field_lags_by_the_width_after_a_long_way_of_the_current_and_ignores_its_speed():
    up, down = np.linspace(0.0, 2.0, 400), np.linspace(2.0, 0.5, 300)
    found = field(np.concatenate([up, down]), width=0.1)
    assert found[399] == pytest.approx(1.9, abs=1e-6) and found[-1] == pytest.approx(0.6, abs=1e-6)
    in_jumps = field([0.0, 2.0, 0.5], width=0.1)
    assert in_jumps[1:] == pytest.approx([found[399], found[-1]], abs=1e-9)


def test_the_field_never_moves_against_the_current_and_follows_a_parabola_after_a_reversal():
    down = np.linspace(2.0, 1.7, 100)
    found = field([0.0, *down], width=0.1)[1:]
    assert (np.diff(found) <= 1e-12).all()
    assert 2.0 - 0.1 - found == pytest.approx((2.0 - down) ** 2 / (8.0 * 0.1), abs=0.1 / 8)


def test_noise_of_the_current_leaves_its_history_in_the_field():
    noise = 0.004 * np.random.default_rng(0).standard_normal(2000)
    noisy = field(np.concatenate([[0.0, 2.0], 1.0 + noise]), width=0.1)
    assert noisy[-500:].mean() == pytest.approx(1.1, abs=0.02)


def test_a_held_current_holds_the_field_and_an_unknown_one_does_not_change_it():
    held = field([0.0, 2.0, *[1.0] * 50], width=0.2)
    assert np.ptp(held[2:]) == 0.0 and held[2] > 1.19
    unknown = field([0.0, 2.0, np.nan, np.nan, 2.0], width=0.2)
    assert unknown[4] == unknown[1]


def test_a_narrow_loop_and_no_share_of_eddy_currents_change_nothing():
    commands = [0.0, 1.0, 0.3, 0.8]
    assert field(commands, width=1e-6) == pytest.approx(commands, abs=2e-6)
    assert field(commands, "command_eddy", share=0.0) == pytest.approx(commands, abs=1e-9)


def test_eddy_currents_hold_back_their_share_of_a_step_for_their_time():
    found = field([0.0, *[1.0] * 200], "command_eddy", share=0.4, time_constant=0.05)
    after = np.arange(1, 201) / 1000.0
    assert found[1:] == pytest.approx(1.0 - 0.4 * np.exp(-after / 0.05), abs=1e-9)
