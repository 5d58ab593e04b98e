"""The model as a list of effects: composition laws, list methods, files."""

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from damper_estimator.effects.discovery import find_effect
from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel, load_model, make_element, parse_model, save_model
from damper_estimator.model.element import new_element
from damper_estimator.model.model_files import library_models, model_yaml
from damper_estimator.signals.layout import COMMAND, DT, ROWS, TEMPERATURE, A, T, V, X


def entry(name, path=(), **values):
    return make_element(find_effect(name), values, path)


def sweep(size=300, seed=0):
    random = np.random.default_rng(seed)
    block = np.full((ROWS, size), np.nan)
    block[DT] = random.uniform(0.001, 0.003, size)
    block[DT, 0] = 0.0
    block[T] = np.cumsum(block[DT])
    block[X] = 0.03 * np.sin(12 * block[T])
    block[V] = 0.36 * np.cos(12 * block[T])
    block[A] = -4.3 * np.sin(12 * block[T])
    block[COMMAND] = np.where(block[T] > 0.2, 1.0, 0.0)
    return block


LEAVES = st.sampled_from(["linear_viscous", "coulomb", "gas_spring", "static_force", "tanh_hysteresis"])
MODIFIERS = st.sampled_from(["force_lag", "position_gain"])


@st.composite
def chains(draw, depth=2):
    """Random lists of effects with paths, series, inputs and modifiers, nested."""
    entries = [entry(name) for name in draw(st.lists(LEAVES, min_size=1, max_size=3))]
    if depth and draw(st.booleans()):
        inner = draw(chains(depth - 1))
        wrap = draw(st.sampled_from(["path", "oil_spring"]))
        entries.append(entry(wrap, path=tuple(inner)))
    if draw(st.booleans()):
        entries.insert(0, entry("command_lag"))
    if draw(st.booleans()):
        entries.append(entry(draw(MODIFIERS)))
    return entries


@given(chains(), st.integers(0, 99), st.lists(st.integers(1, 40), max_size=6))
@settings(max_examples=40, deadline=None)
def test_any_chain_gives_the_same_bits_in_blocks_of_any_size(effects, seed, splits):
    model, block = DamperModel("m", "", tuple(effects)), sweep(160, seed)
    block[DT, 90] = 0.0  # a reset in the middle
    stream, first, parts = model.stream(), 0, []
    for size in [*splits, 160]:
        last = min(first + size, 160)
        if last > first:
            parts.append(stream.force(np.ascontiguousarray(block[:, first:last])))
        first = last
    assert np.array_equal(model.force(block), np.concatenate(parts))


@given(chains(), st.integers(0, 99))
@settings(max_examples=30, deadline=None)
def test_contributions_add_up_to_the_force(effects, seed):
    model, block = DamperModel("m", "", tuple(effects)), sweep(100, seed)
    force, parts = model.stream().contributions(block)
    assert force == pytest.approx(parts.sum(axis=0), abs=1e-9 * (1.0 + np.abs(force).max()))
    assert np.array_equal(force, model.force(block))
    shown = model.contributions(block)
    assert sum(shown.values()) == pytest.approx(force, abs=1e-9 * (1.0 + np.abs(force).max()))


def test_a_compliance_contributes_what_it_changes():
    rate = {"viscous": {"rate": 1500.0}}
    model = parse_model({"name": "m", "source": "s", "effects": [{"oil_spring": {"path": [rate]}}]}, "test")
    block = sweep(400, 3)
    alone = parse_model({"name": "m", "source": "s", "effects": [rate]}, "test").force(block)
    parts = model.contributions(block)
    assert parts["viscous"] == pytest.approx(alone)
    assert parts["oil_spring"] == pytest.approx(model.force(block) - alone)


@given(chains())
@settings(max_examples=30, deadline=None)
def test_model_file_gives_the_same_model_back(effects):
    model = DamperModel("m", "somebody: eq. (1)", tuple(effects), fixed=(), notes="why")
    assert parse_model(yaml.safe_load(model_yaml(model)), "m.yaml") == model


@given(st.lists(LEAVES, min_size=2, max_size=5), st.randoms())
@settings(max_examples=20, deadline=None)
def test_sources_commute(names, random):
    shuffled = random.sample(names, len(names))
    block = sweep()
    forces = [DamperModel("m", "", tuple(entry(n) for n in order)).force(block) for order in (names, shuffled)]
    assert forces[0] == pytest.approx(forces[1], abs=1e-8)


def test_a_path_equals_its_entries_without_the_path():
    block = sweep()
    flat = DamperModel("m", "", (entry("linear_viscous"), entry("coulomb")))
    nested = DamperModel("m", "", (entry("linear_viscous"), entry("path", path=(entry("coulomb"),))))
    assert flat.force(block) == pytest.approx(nested.force(block), abs=1e-9)


def test_a_modifier_at_the_end_of_a_path_acts_only_on_that_path():
    block = sweep()
    gained = entry("path", path=(entry("coulomb"), entry("position_gain", gain=1.0)))
    both = DamperModel("m", "", (entry("linear_viscous"), gained)).force(block)
    alone = DamperModel("m", "", (gained,)).force(block)
    assert both - alone == pytest.approx(DamperModel("m", "", (entry("linear_viscous"),)).force(block), abs=1e-9)


def test_the_state_resets_between_parts():
    model = DamperModel("m", "", (entry("linear_viscous"), entry("force_lag", time_constant=0.05)))
    block = sweep(100)
    block[DT, 50] = 0.0
    second = np.ascontiguousarray(block[:, 50:])
    assert np.array_equal(model.force(block)[50:], model.force(second))


def test_a_lost_command_does_not_affect_later_samples():
    model = DamperModel("m", "", (entry("command_lag"), entry("linear_viscous"), entry("force_lag")))
    block = sweep(60)
    block[V, 20:23] = np.nan
    force = model.force(block)
    assert np.isnan(force[20:23]).all() and np.isfinite(np.delete(force, [20, 21, 22])).all()
    stream = model.stream()
    assert np.array_equal(
        force,
        np.concatenate([stream.force(np.ascontiguousarray(block[:, i : i + 1])) for i in range(60)]),
        equal_nan=True,
    )


def test_addresses_number_instances_and_elements():
    model = DamperModel(
        "m",
        "",
        (
            entry("coulomb"),
            entry("path", path=(entry("coulomb"),)),
            entry("viscous_curve", velocity=[0, 1], force=[1, 2]),
        ),
    )
    addresses = [slot.address for slot in model.slots]
    assert addresses == ["coulomb.force", "coulomb#2.force", "viscous_curve.force[0]", "viscous_curve.force[1]"]


def test_values_are_changed_by_address_and_by_vector():
    model = DamperModel("m", "", (entry("coulomb"), entry("viscous_curve", velocity=[0, 1], force=[1, 2])))
    changed = model.with_values({"viscous_curve.force[1]": 5.0})
    assert [slot.value for slot in changed.slots] == [50.0, 1.0, 5.0]
    assert np.array_equal(changed.force(sweep()), DamperModel("m", "", changed.effects).force(sweep()))
    with pytest.raises(InputError, match=r"coulomb\.mu"):
        model.with_values({"coulomb.mu": 1.0})


def test_effects_are_added_where_their_kind_belongs():
    model = DamperModel("m", "", (entry("linear_viscous"), entry("force_lag")))
    model = model.with_effect(entry("coulomb")).with_effect(entry("force_offset"))
    model = model.with_effect(entry("position_gain")).with_effect(entry("command_lag"))
    assert [e.effect.name for e in model.effects] == [
        "command_lag", "linear_viscous", "coulomb", "force_lag", "position_gain", "force_offset",
    ]  # fmt: skip


def test_a_series_effect_wraps_the_sources_and_releases_them_when_removed():
    model = DamperModel("m", "", (entry("linear_viscous"), entry("coulomb"), entry("force_lag")))
    spring = find_effect("oil_spring")
    wrapped = model.with_effect(make_element(spring, path=model.effects[:2]))
    assert [e.effect.name for e in wrapped.effects] == ["oil_spring", "force_lag"]
    assert wrapped.without("oil_spring").effects == model.effects


def test_removing_an_unknown_label_lists_the_known_ones():
    with pytest.raises(InputError, match="coulomb"):
        DamperModel("m", "", (entry("coulomb"),)).without("dahl#2")


def test_saved_models_load_again(tmp_path):
    model = DamperModel("m", "s", (entry("coulomb", force=1e-05), entry("gas_spring")), fixed=("gas_spring.volume",))
    save_model(model, tmp_path / "m.yaml")
    assert load_model(tmp_path / "m.yaml") == model
    (tmp_path / "fleet").mkdir()
    save_model(model, tmp_path / "fleet" / "front_left.yaml")
    assert load_model(tmp_path / "fleet", "front_left") == model
    with pytest.raises(InputError, match="front_left"):
        load_model(tmp_path / "fleet", "rear_left")


@pytest.mark.parametrize(
    ("content", "fault"),
    [
        ("", "not a model file"),
        ("effects: 3", "not a model file"),
        ("effects: [colomb]", "unknown effect 'colomb'; did you mean coulomb"),
        ("effects: [{coulomb: {force: -5}}]", "force = -5 is outside 0 to 10000 N"),
        ("effects: [{coulomb: {force: .nan}}]", "outside"),
        ("effects: [{coulomb: {force: high}}]", "not a number"),
        ("effects: [{coulomb: {mu: 1}}]", "'mu' is unknown"),
        ("effects: [{coulomb: 7}]", "must be a mapping"),
        ("effects: [{viscous_curve: {velocity: [0, 1], force: [1]}}]", "force has 1 values, velocity has 2"),
        ("effects: [{path: []}]", "path is empty"),
        ("effects: [{path: [force_offset]}]", "measurement chain"),
        ("effects: [coulomb]\nfixed: [coulomb.mu]", "fixed contains coulomb.mu"),
        ("effects: [coulomb]\ncolour: red", "unknown keys colour"),
        ("effects: [coulomb", "not valid YAML"),
        ("\x00", "not valid YAML"),
    ],
)
def test_bad_model_files_are_refused_in_one_line(tmp_path, content, fault):
    path = tmp_path / "bad.yaml"
    path.write_text(content)
    with pytest.raises(InputError) as caught:
        load_model(path).program  # noqa: B018
    text = str(caught.value)
    assert fault in text and "\n" not in text
    assert str(path) in text or fault == "measurement chain"


def test_unknown_names_of_models_are_refused():
    with pytest.raises(InputError, match="damper-estimator models"):
        load_model("no_such_model")


def test_every_model_of_the_library_loads_and_gives_finite_forces():
    for name in library_models():
        model = load_model(name)
        block = sweep()
        assert model.name == name and model.source
        assert np.isfinite(model.force(block)).all()


def test_what_is_fixed_stays_so_whatever_is_added_or_removed(tmp_path):
    curve, friction, gas = entry("viscous_curve"), entry("coulomb", force=5.0), entry("gas_spring")
    second = entry("coulomb", force=9.0)
    fixed = ("coulomb.force", "gas_spring.volume", "coulomb#2.force")
    model = DamperModel("m", "s", (curve, friction, gas, second), fixed=fixed)
    less = model.without("coulomb")
    assert less.fixed == ("gas_spring.volume", "coulomb.force"), "the second is the first now"
    assert model.with_effect(entry("inertia")).fixed == fixed
    spring = entry("oil_spring", model.effects)
    on_oil = DamperModel("m", "s", (spring,), fixed=("oil_spring.stiffness_rebound", "coulomb.force"))
    again = on_oil.with_missing(entry("gas_pocket", model.effects))
    assert again.fixed == ("coulomb.force",), "it takes the place of the oil"
    on_mount = on_oil.with_missing(new_element(find_effect("rubber_mount"), on_oil.effects))
    springs = {"oil_spring.stiffness_rebound", "oil_spring.stiffness_compression"}
    assert set(on_mount.fixed) == {"coulomb.force", *springs}, "the oil stays as stiff as it was behind a mount"
    for changed in (less, model.without("gas_spring"), on_oil.without("oil_spring")):
        save_model(changed, tmp_path / "changed.yaml")
        assert load_model(str(tmp_path / "changed.yaml")).fixed == changed.fixed


@settings(max_examples=40, deadline=None)
@given(slope=st.floats(0.0, 20000.0), stiffness=st.floats(1e5, 1e8), seed=st.integers(0, 1000))
def test_a_compliance_before_a_path_whose_force_falls_with_velocity_stays_finite(slope, stiffness, seed):
    falling = entry("viscous_curve", velocity=[-0.2, -0.1, 0.0, 0.1, 0.2], force=[
        -500.0 + 0.1 * slope, -500.0, 0.0, 500.0, 500.0 - 0.1 * slope])  # fmt: skip
    values = dict.fromkeys(("stiffness_rebound", "stiffness_compression"), stiffness)
    model = DamperModel("m", "", (entry("oil_spring", (falling,), **values),))
    force = model.force(sweep(600, seed))
    assert np.isfinite(force).all()
    assert np.abs(force).max() < 1e7  # N: it may be wrong, but is not without limit


@pytest.mark.parametrize("moved", [False, True])
def test_effects_of_the_measurement_chain_act_on_a_whole_block_behind_a_compliance(moved):
    block = sweep(400)
    values = dict.fromkeys(("stiffness_rebound", "stiffness_compression"), 1e6)
    before = (entry("velocity_delay", delay=0.002),) if moved else ()
    spring = entry("oil_spring", (entry("linear_viscous"),), **values)
    plain = DamperModel("m", "", (*before, spring))
    late = DamperModel(
        "m", "", (*before, spring, entry("channel_skew", skew=0.004), entry("force_gain_error", gain=0.1))
    )
    expected = 1.1 * np.interp(block[T] - 0.004, block[T], plain.force(block))
    np.testing.assert_allclose(late.force(block), expected, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(sum(late.contributions(block).values()), expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("name", sorted(library_models()))
def test_forces_with_other_numbers_are_those_of_the_model_with_them(name):
    model, block = load_model(name), sweep()
    block[TEMPERATURE] = 30.0 + 10.0 * block[T]
    vector = np.array([0.5 * (one.value + np.clip(1.1 * one.value, one.parameter.lower, one.parameter.upper))
                       for one in model.slots])  # fmt: skip
    np.testing.assert_array_equal(model.force_at(vector, block), model.with_vector(vector).force(block))
