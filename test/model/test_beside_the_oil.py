"""What a series spring carries: the oil what acts through the piston, a mount everything."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from test_damper_model import entry, sweep

from damper_estimator.effects.discovery import find_effect
from damper_estimator.model import DamperModel
from damper_estimator.model.element import make_element, new_element


def names_in(model):
    return [(e.effect.name, [inner.effect.name for inner in e.path]) for e in model.effects]


def test_gas_and_static_force_act_beside_the_oil_and_through_a_mount():
    curve, gas, friction, static = (entry(name) for name in ("viscous_curve", "gas_spring", "dahl", "static_force"))
    model = DamperModel("m", "s", (curve, gas, friction, static))
    oil, mount = (new_element(find_effect(name), model.effects) for name in ("oil_spring", "rubber_mount"))
    beside = [("gas_spring", []), ("static_force", [])]
    on_oil = model.with_missing(oil)
    assert names_in(on_oil) == [("oil_spring", ["viscous_curve", "dahl"]), *beside]
    assert names_in(model.with_missing(mount)) == [
        ("rubber_mount", ["viscous_curve", "gas_spring", "dahl", "static_force"])
    ]
    in_a_row = on_oil.with_missing(mount)
    assert names_in(in_a_row) == [("rubber_mount", ["oil_spring", "gas_spring", "static_force"])]
    assert model.with_missing(mount).with_missing(oil).effects == in_a_row.effects, "in whatever order they are added"
    assert names_in(on_oil.with_missing(entry("quadratic_gas")))[-1] == ("quadratic_gas", [])
    assert names_in(on_oil.with_missing(entry("coulomb")))[0] == ("oil_spring", ["viscous_curve", "dahl", "coulomb"])
    again = on_oil.effects[0]
    assert names_in(model.with_missing(again)) == names_in(on_oil), "with its path, as a search returns it"
    alone = DamperModel("m", "s", (gas, static)).with_missing(oil)
    assert names_in(alone) == [("oil_spring", ["gas_spring", "static_force"])]


@given(force=st.floats(-2000.0, 2000.0), rebound=st.floats(2e5, 1e8), compression=st.floats(2e5, 1e8))
@settings(max_examples=30, deadline=None)
def test_a_static_force_added_to_a_damper_on_oil_shifts_its_force_alone(force, rebound, compression):
    values = {"stiffness_rebound": rebound, "stiffness_compression": compression}
    model = DamperModel("m", "s", (entry("oil_spring", (entry("linear_viscous"),), **values),))
    shifted = model.with_missing(entry("static_force", force=force))
    block = sweep()
    np.testing.assert_allclose(shifted.force(block), model.force(block) + force, atol=1e-9 * (1.0 + abs(force)))


@given(stiffness=st.floats(1e8, 9e8))
@settings(max_examples=20, deadline=None)
def test_a_compliance_carries_sources_behind_a_lag_and_changes_nothing_if_it_is_stiff(stiffness):
    """What was added to a model that ends with a lag stands behind it, and acts through the oil all the same."""
    sources = (entry("linear_viscous"), entry("gas_spring"), entry("force_lag"), entry("dahl"))
    model = DamperModel("m", "s", sources)
    values = {"stiffness_rebound": stiffness, "stiffness_compression": stiffness}
    on_oil = model.with_missing(new_element(find_effect("oil_spring"), model.effects, values))
    assert names_in(on_oil) == [("oil_spring", ["linear_viscous", "force_lag", "dahl"]), ("gas_spring", [])]
    block = sweep()
    late = slice(20, None)  # the lag of a constant gas force is over
    force = model.force(block)[late]
    np.testing.assert_allclose(on_oil.force(block)[late], force, atol=0.02 * np.abs(force).max())


MODIFIERS = ("position_gain", "temperature_gain", "pressure_relief", "force_lag")


@given(
    names=st.permutations(("linear_viscous", "coulomb", "gas_spring", *MODIFIERS)),
    spring=st.sampled_from(("oil_spring", "rubber_mount", "gas_pocket", "rod_side_void")),
)
@settings(max_examples=40, deadline=None)
def test_a_stiff_compliance_changes_nothing_wherever_the_modifiers_stand(names, spring):
    model = DamperModel("m", "s", tuple(entry(name) for name in names))
    element = new_element(find_effect(spring), model.effects)
    stiff = {p.name: 1e9 if p.unit == "N/m" else 1e6 for p in element.effect.parameters if p.unit in ("N/m", "N")}
    carried = model.with_missing(element.with_values(stiff))
    assert carried.effects[0].effect.name == spring
    block = sweep()
    late = slice(20, None)  # the lag of a constant gas force is over
    force = model.force(block)[late]
    np.testing.assert_allclose(carried.force(block)[late], force, atol=0.02 * np.abs(force).max())


def test_a_compliance_carries_modifiers_and_what_they_act_on():
    def carried(spring, *names):
        model = DamperModel("m", "s", tuple(entry(name) for name in names))
        return names_in(model.with_missing(new_element(find_effect(spring), model.effects)))

    assert carried("oil_spring", "linear_viscous", "position_gain", "dahl", "channel_skew") == [
        ("oil_spring", ["linear_viscous", "position_gain", "dahl"]), ("channel_skew", [])
    ]  # fmt: skip
    scaled = ("linear_viscous", "gas_spring", "temperature_gain", "static_force")
    assert carried("oil_spring", *scaled) == [("oil_spring", list(scaled[:3])), ("static_force", [])]
    assert carried("rubber_mount", *scaled) == [("rubber_mount", list(scaled))]
    alike = ("linear_viscous", "static_force", "temperature_gain", "static_force")
    assert carried("oil_spring", *alike) == [("oil_spring", list(alike[:3])), ("static_force", [])]


def test_a_compliance_with_a_path_leaves_everything_else_in_place():
    first, second, lag = entry("coulomb"), entry("coulomb", force=9.0), entry("force_lag")
    model = DamperModel("m", "s", (entry("linear_viscous"), first, second, lag))
    spring = make_element(find_effect("oil_spring"), path=(entry("linear_viscous", rebound=1.0), first))
    assert names_in(model.with_effect(spring)) == [
        ("oil_spring", ["linear_viscous", "coulomb"]), ("coulomb", []), ("force_lag", [])
    ]  # fmt: skip
