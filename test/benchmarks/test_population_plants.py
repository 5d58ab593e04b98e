"""The dampers of the population obey physical laws, and their cases match their names."""

from dataclasses import replace

import numpy as np
import pytest
from population import cases, drives, families, measurement_chain, simulate
from population.damper_phenomena import IN_THE_DAMPER
from population.flows import stored, through_piston, valve_areas, viscosity
from population.measurement_chain import FAULTS
from population.plant_parameters import AMBIENT, FAMILIES, MAGNETO, MONO, TWIN
from population.realisation import scene_of
from population.strength_search import MEDIUM, TOLERANCE, in_chain, in_damper
from population.twin_tube import through_foot

SECONDS = 6.0
SEEDS = (1, 2, 3)


def damper(family, seed, **more):
    return families.drawn(np.random.default_rng([family, seed]), family)._replace(**more)


def drive(plant, seed=1, kind="random", speed=0.4, warming=0.0, highest=0.0, seconds=SECONDS):
    rng = np.random.default_rng(seed)
    return drives.drawn(rng, kind, seconds, speed, families.tightest(plant), warming, highest)


def plain(plant):
    """Without energy storage and memory other than chambers and gas."""
    return plant._replace(delay_form=0, gel_form=0, foam=0.0, mount_form=0, gas_form=2, release=0.0, place_form=0)


def scene(plant, motion):
    return scene_of(motion, simulate.run(plant, motion), motion)


def realisations(family, name, seed=1):
    plant = damper(family, seed)
    if family == MAGNETO and name != "current":
        plant = plant._replace(current_form=1)
    motion = drive(plant, warming=15.0, highest=1.5)
    return plant, motion, IN_THE_DAMPER[name](plant, scene(plant, motion), np.random.default_rng(seed))


@pytest.mark.parametrize("family", (TWIN, MONO, MAGNETO), ids=FAMILIES)
@pytest.mark.parametrize("seed", SEEDS)
def test_a_damper_dissipates_energy(family, seed):
    plant = damper(family, seed)
    for kind in drives.KINDS:
        motion = drive(plant, seed, kind)
        force = simulate.force_of(plant, motion)
        work = np.cumsum(force * motion.v) / drives.RATE
        assert work[-1] > 0.0  # it begins and ends at the same place, at rest
        # Energy returned on the way was stored in gas, oil and seals.
        most = np.max(np.maximum.accumulate(work) - work)
        assert most < 0.5 * (plant.charge * plant.rod + 50.0) * 4.0 * np.abs(motion.x).max()


@pytest.mark.parametrize("family", (TWIN, MONO, MAGNETO), ids=FAMILIES)
@pytest.mark.parametrize("name", IN_THE_DAMPER)
def test_no_phenomenon_produces_energy(family, name):
    _, motion, forms = realisations(family, name)
    still = replace(motion, temperature=np.full(motion.x.size, 30.0), current=np.full(motion.x.size, 0.5))
    for form in forms:
        size = min(max(1.0, form.low), form.high)
        force = simulate.force_of(form.on(size), still)
        assert np.sum(force * still.v) > 0.0, form.form


@pytest.mark.parametrize("family", (TWIN, MONO, MAGNETO), ids=FAMILIES)
def test_at_rest_only_the_gas_pushes(family):
    plant = damper(family, 4)
    motion = drive(plant)
    force = simulate.force_of(plant, motion)
    assert force[10] == pytest.approx(-plant.rod * (plant.charge - AMBIENT), rel=0.02, abs=2.0)


def test_oil_that_leaves_the_rebound_chamber_of_a_monotube_passes_the_piston():
    plant = plain(damper(MONO, 5))
    motion = drive(plant)
    _, p1, p2, _ = simulate.run(plant, motion).T
    annulus = plant.piston - plant.rod
    packed = np.array([stored(plant, p, plant.free_gas) for p in p1])
    volume = plant.rebound_volume - annulus * motion.x
    field = plant.idle
    flow = [
        through_piston(plant, a - b, x, viscosity(plant, 30.0), *valve_areas(plant, a - b, field), field)
        for a, b, x in zip(p1, p2, motion.x, strict=True)
    ]
    # The step of the excess of oil, at the volume of the step's end.
    left = volume[1:] * packed[1:] - volume[:-1] * packed[:-1]
    expected = (annulus * motion.v - np.array(flow))[1:] / drives.RATE
    assert np.abs(left - expected).max() < 1e-3 * np.abs(annulus * motion.v).max() / drives.RATE + 1e-13


def test_oil_that_leaves_both_chambers_of_a_twin_tube_is_in_the_reserve():
    plant = plain(damper(TWIN, 6))
    motion = drive(plant)
    _, p1, p2, p3 = simulate.run(plant, motion).T
    annulus = plant.piston - plant.rod
    s1, s2 = (np.array([stored(plant, p, plant.free_gas) for p in pressures]) for pressures in (p1, p2))
    inside = (plant.rebound_volume - annulus * motion.x) * s1 + (
        plant.compression_volume + plant.piston * motion.x
    ) * s2
    out = np.array([through_foot(plant, a - b, viscosity(plant, 30.0)) for a, b in zip(p2, p3, strict=True)])
    expected = (-plant.rod * motion.v - out)[1:] / drives.RATE
    # The next step corrects the remainder of a step's solution: errors do not accumulate.
    lost = np.abs(inside[1:] - inside[0] - np.cumsum(expected))
    swept = plant.rod * np.ptp(motion.x)
    assert lost.max() < 1e-2 * swept
    assert lost[-1] < 1e-6 * swept


@pytest.mark.parametrize("name", IN_THE_DAMPER)
def test_a_phenomenon_has_at_least_three_forms(name):
    forms = {realisation.form for family in (TWIN, MONO, MAGNETO) for realisation in realisations(family, name)[2]}
    assert len(forms) >= 3


@pytest.mark.parametrize("name", IN_THE_DAMPER)
def test_on_and_off_differ_and_off_is_the_same_every_time(name):
    _, motion, forms = realisations(MONO, name)
    for form in forms:
        size = min(max(1.0, form.low), form.high)
        off = simulate.force_of(form.off(size), motion)
        assert np.array_equal(off, simulate.force_of(form.off(size), motion))
        assert not np.array_equal(off, simulate.force_of(form.on(size), motion)), form.form


@pytest.mark.parametrize("name", FAULTS)
def test_a_chain_without_a_fault_shows_the_force_exactly(name):
    plant = damper(MONO, 7)
    motion = drive(plant)
    force = simulate.force_of(plant, motion)
    chain = measurement_chain.drawn(np.random.default_rng(1), force.std(), coil_over=False)
    for form in range(3):
        assert np.array_equal(
            measurement_chain.gauge(measurement_chain.faulty(chain, name, form, 0.0), motion, force), force
        )


@pytest.mark.parametrize("late", (-0.003, 0.002))
@pytest.mark.parametrize("form", (0, 1))
def test_a_late_force_has_the_stated_delay(late, form):
    plant = damper(MONO, 8)
    motion = drive(plant)
    force = simulate.in_band(simulate.force_of(plant, motion))
    chain = measurement_chain.faulty(
        measurement_chain.drawn(np.random.default_rng(1), 100.0, False), "channel_skew", form, late
    )
    shown = measurement_chain.gauge(chain, motion, force)
    shift = round(measurement_chain.late_by(chain) * drives.RATE)
    inner = slice(500, -500)
    assert np.roll(force, shift)[inner] == pytest.approx(shown[inner], abs=1e-6 * np.abs(force).max())


@pytest.mark.parametrize("name", ("friction", "inertia", "oil_compressibility", "hysteresis"))
def test_a_strength_is_found_within_its_tolerance(name):
    _, motion, forms = realisations(MONO, name, seed=2)
    chain = measurement_chain.drawn(np.random.default_rng(1), 100.0, False)
    for form in forms:
        found = in_damper(name, form, chain, motion, MEDIUM)
        assert found is not None, form.form
        again = simulate.share(simulate.force_of(found.off[0], motion), simulate.force_of(found.on[0], motion))
        assert again == pytest.approx(found.strength)
        assert again == pytest.approx(MEDIUM, rel=TOLERANCE)


def test_a_fault_of_the_chain_has_the_requested_strength():
    plant = damper(MONO, 9)
    motion = drive(plant)
    chain = measurement_chain.drawn(np.random.default_rng(1), 100.0, False)
    found = in_chain("force_gain_error", 0, -1.0, plant, chain, motion, MEDIUM)
    assert found.size < 0.0
    assert found.strength == pytest.approx(MEDIUM, rel=TOLERANCE)


def test_a_case_repeats_with_its_seed_and_differs_with_another():
    card = cases.Card(0, "hidden", ("friction",), "medium")
    one, again, other = (cases.made(card, seed, longest=21.0) for seed in (3, 3, 4))
    for role in ("base", "fit", "unseen", "twin"):
        for field in ("time", "x", "force", "truth"):
            assert np.array_equal(getattr(getattr(one, role), field), getattr(getattr(again, role), field))
    assert not np.array_equal(one.fit.x[:1000], other.fit.x[:1000])
    assert one.effects[0].strength == pytest.approx(MEDIUM, rel=TOLERANCE)


def test_with_nothing_hidden_all_recordings_are_of_one_damper():
    card = cases.Card(1, "nothing", (), "none")
    case = cases.made(card, 5, longest=21.0)
    assert case.effects == ()
    assert np.array_equal(case.unseen.force, case.twin.force)


def test_two_effects_have_one_base_without_either():
    card = cases.Card(2, "pair", ("inertia", "channel_skew"), "medium", against=True)
    case = cases.made(card, 6, longest=21.0)
    first, second = case.effects
    assert first.off == second.off
    assert second.on[0] == first.on[0]
    assert second.off[1].skew == 0.0 < second.on[1].skew


def test_the_deck_holds_every_phenomenon_and_repeats_with_its_seed():
    many = [card for card, _ in zip(cases.deck(1, real=True), range(28), strict=False)]
    assert sorted(card.hidden[0] for card in many if card.kind == "hidden") == sorted(cases.PHENOMENA)
    assert {kind: sum(card.kind == kind for card in many) for kind in ("nothing", "pair", "real")} == {
        "nothing": 3, "pair": 4, "real": 3,
    }  # fmt: skip
    assert many == [card for card, _ in zip(cases.deck(1, real=True), range(28), strict=False)]
    assert many != [card for card, _ in zip(cases.deck(2, real=True), range(28), strict=False)]
