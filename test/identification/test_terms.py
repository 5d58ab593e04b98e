"""A model taken apart: the parts' forces add up, and what is called linear is."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from damper_estimator.effects.discovery import all_effects, find_effect
from damper_estimator.identification.terms import terms
from damper_estimator.model import DamperModel, make_element
from damper_estimator.signals.layout import COMMAND, DT, PRESSURE, ROWS, TEMPERATURE, A, T, V, X

TOLERANCE = 1e-9  # of the force
SOLVED = 1e-6  # of the force, behind a compliance, which is solved to a separate tolerance
LEAVES = st.sampled_from(["linear_viscous", "coulomb", "gas_spring", "static_force", "tanh_hysteresis", "bouc_wen"])
ACTING = st.sampled_from(
    [
        "force_lag",
        "position_gain",
        "command_gain",
        "cavitation_limit",
        "force_offset",
        "force_gain_error",
        "channel_skew",
    ]
)
VALUES = {
    "position_gain": {"gain": 0.4},
    "command_gain": {},
    "force_gain_error": {"gain": 0.1},
    "channel_skew": {"skew": 0.003},
}


def entry(name, path=(), **values):
    return make_element(find_effect(name), values, path)


def sweep(size=200):
    block = np.full((ROWS, size), 40.0)
    block[DT] = 0.002
    block[DT, 0] = 0.0
    block[T] = np.cumsum(block[DT])
    block[X] = 0.03 * np.sin(30 * block[T]) + 0.002
    block[V] = 0.9 * np.cos(30 * block[T])
    block[A] = -27.0 * np.sin(30 * block[T])
    block[COMMAND], block[TEMPERATURE], block[PRESSURE] = 0.7, 50.0, 2e6
    return block


@st.composite
def chains(draw, depth=2):
    """Lists of entries with paths, compliances, inputs, linear and nonlinear modifiers and channel effects."""
    entries = [entry(name) for name in draw(st.lists(LEAVES, min_size=1, max_size=3))]
    if depth and draw(st.booleans()):
        inner = draw(chains(depth - 1))
        wrap = draw(st.sampled_from(["path", "oil_spring"]))
        inner = [e for e in inner if e.effect.kind != "channel"]
        entries.insert(draw(st.integers(0, len(entries))), entry(wrap, path=tuple(inner)))
    for name in draw(st.lists(ACTING, max_size=2)):
        if depth == 2 or find_effect(name).kind != "channel":
            added = {s.name: draw(st.sampled_from([0.0, 170.0])) for s in find_effect(name).settings if s.adds}
            # A gauge stands behind the whole damper, and rewrites what others add behind it as well.
            inside = sum(e.effect.kind != "channel" for e in entries)
            place = len(entries) if find_effect(name).kind == "channel" else draw(st.integers(1, inside))
            entries.insert(place, entry(name, **VALUES.get(name, {}), **added))
    return [entry("velocity_delay"), *entries] if draw(st.booleans()) else entries


@given(chains())
@settings(max_examples=60, deadline=None)
def test_the_parts_forces_add_up_to_the_models(entries):
    model, block = DamperModel("m", "", tuple(entries)), sweep()
    total = sum(term.model.force(block) for term in terms(model))
    force = model.force(block)
    tolerance = SOLVED if "oil_spring" in model.uses() else TOLERANCE
    np.testing.assert_allclose(total, force, atol=tolerance * (100.0 + np.abs(force).max()))


@given(chains())
@settings(max_examples=60, deadline=None)
def test_every_slot_belongs_to_a_part_under_its_own_address(entries):
    model = DamperModel("m", "", tuple(entries))
    parts = terms(model)
    assert {slot for term in parts for slot in term.slots} == set(range(len(model.slots)))
    for term in parts:
        assert [slot.parameter for slot in term.model.slots] == [model.slots[i].parameter for i in term.slots]
        assert [slot.value for slot in term.model.slots] == [model.slots[i].value for i in term.slots]


@given(chains(), st.floats(0.1, 5.0))
@settings(max_examples=60, deadline=None)
def test_a_part_is_proportional_to_its_linear_parameters(entries, factor):
    model, block = DamperModel("m", "", tuple(entries)), sweep()
    for term in terms(model):
        if term.linear:
            values = np.array([slot.value for slot in term.model.slots])
            scaled = np.where(np.isin(term.slots, term.linear), factor * values, values)
            force = term.model.force(block)
            np.testing.assert_allclose(
                term.model.with_vector(scaled).force(block),
                factor * force,
                atol=TOLERANCE * (1.0 + factor * np.abs(force).max()),
            )


@pytest.mark.parametrize("name", [n for n, e in all_effects().items() if any(p.linear for p in e.parameters)])
def test_the_force_of_every_effect_is_the_sum_of_what_its_linear_parameters_give_alone(name):
    model, block = DamperModel("m", "", (entry(name),)), sweep()
    ((term),) = terms(model)
    assert term.linear
    random = np.random.default_rng(3)
    values = np.array([slot.value for slot in model.slots])
    linear = list(term.linear)
    values[linear] = random.uniform(0.5, 2.0, len(linear))
    whole, alone = model.with_vector(values).force(block), np.zeros(block.shape[1])
    for slot in linear:
        single = values.copy()
        single[[other for other in linear if other != slot]] = 0.0
        alone += model.with_vector(single).force(block)
    np.testing.assert_allclose(alone, whole, atol=TOLERANCE * (1.0 + np.abs(whole).max()))


def test_what_a_scale_adds_by_itself_is_in_one_part():
    scale = entry("command_gain", at_rest=300.0)
    model, block = DamperModel("m", "", (entry("coulomb"), entry("viscous"), scale)), sweep()
    whole, parts = model.force(block), [term.model.force(block) for term in terms(model)]
    assert len(parts) == 3
    np.testing.assert_allclose(sum(parts), whole, atol=TOLERANCE * np.abs(whole).max())
    assert linear_addresses(*model.effects) == {"coulomb.force", "viscous.rate"}


def linear_addresses(*entries):
    model = DamperModel("m", "", entries)
    return {model.slots[i].address for term in terms(model) for i in term.linear}


def test_nothing_is_linear_before_a_nonlinear_modifier_or_behind_a_compliance():
    assert linear_addresses(entry("coulomb"), entry("cavitation_limit"), entry("static_force")) == {
        "static_force.force"
    }
    assert linear_addresses(entry("oil_spring", (entry("coulomb"),)), entry("viscous")) == {"viscous.rate"}
    assert linear_addresses(entry("path", (entry("coulomb"),)), entry("force_lag")) == {"coulomb.force"}
    assert linear_addresses(entry("path", (entry("coulomb"), entry("cavitation_limit"))), entry("viscous")) == {
        "viscous.rate"
    }


def test_a_modifiers_own_parameters_are_never_linear():
    assert linear_addresses(entry("viscous"), entry("position_gain"), entry("force_gain_error")) == {"viscous.rate"}
