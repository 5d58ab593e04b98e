"""A mount in front of the oil: both deflections add, and everything else works as with one compliance."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_damper_model import entry, sweep

from damper_estimator.effects.discovery import find_effect
from damper_estimator.model import DamperModel, load_model, save_model
from damper_estimator.model.element import labels, new_element

STIFFNESS = st.floats(2e5, 1e8)
SOURCES = (
    entry("viscous_curve", velocity=[-1.0, 0.0, 1.0], force=[-900.0, 0.0, 1500.0]),
    entry("dahl"),
    entry("gas_spring"),
)


def added(model, name, **values):
    return model.with_missing(new_element(find_effect(name), model.effects, values))


def on_oil(rebound, compression, model=None):
    model = model or DamperModel("m", "s", SOURCES[:2])
    return added(model, "oil_spring", stiffness_rebound=rebound, stiffness_compression=compression)


def row(mount=1.5e6, loss=0.0):
    return added(on_oil(2e6, 3e6, DamperModel("m", "s", SOURCES)), "rubber_mount", stiffness=mount, loss=loss)


@given(rebound=STIFFNESS, compression=STIFFNESS, mount=STIFFNESS)
@settings(max_examples=40, deadline=None)
def test_two_springs_in_a_row_are_one_with_the_sum_of_their_compliances(rebound, compression, mount):
    both = added(on_oil(rebound, compression), "rubber_mount", stiffness=mount, loss=0.0)
    one = on_oil(1.0 / (1.0 / rebound + 1.0 / mount), 1.0 / (1.0 / compression + 1.0 / mount))
    block = sweep()
    expected = one.force(block)
    np.testing.assert_allclose(both.force(block), expected, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("loss", [0.0, 800.0])
def test_parts_live_and_files_are_those_of_the_whole(loss, tmp_path):
    model, block = row(loss=loss), sweep()
    force = model.force(block)
    parts = model.contributions(block)
    assert set(parts) == {label for label, _ in labels(model.effects)}
    np.testing.assert_allclose(sum(parts.values()), force, atol=1e-9 * np.abs(force).max())
    assert np.abs(parts["oil_spring"]).max() > 1.0 and np.abs(parts["rubber_mount"]).max() > 1.0
    stream = model.stream()
    live = [stream.force(block[:, i : i + 1])[0] for i in range(block.shape[1])]
    np.testing.assert_array_equal(live, force)
    save_model(model, tmp_path / "row.yaml")
    kept = load_model(str(tmp_path / "row.yaml"))
    np.testing.assert_array_equal(kept.force(block), force)
    assert kept.fixed == model.fixed


def test_each_can_be_taken_out_again():
    model, block = row(), sweep()
    oil = on_oil(2e6, 3e6, DamperModel("m", "s", SOURCES))
    np.testing.assert_array_equal(model.without("rubber_mount").force(block), oil.force(block))
    assert [one.effect.name for one in model.without("oil_spring").springs] == ["rubber_mount"]


def test_sources_go_behind_what_carries_them():
    (mount,) = row().with_missing(entry("coulomb")).with_missing(entry("quadratic_gas")).effects
    assert [one.effect.name for one in mount.path] == ["oil_spring", "gas_spring", "quadratic_gas"]
    assert [one.effect.name for one in mount.path[0].path] == ["viscous_curve", "dahl", "coulomb"]


@given(share=st.floats(-0.9, 0.9))
@settings(max_examples=20, deadline=None)
def test_a_leak_stands_behind_the_springs_and_takes_its_share_of_the_flow(share):
    """On stiff springs it is a leak in front of the damper; behind soft ones it does not pass what they take up."""
    block, values = sweep(), {"share": share, "opening": 0.3}
    stiff, soft = (added(on_oil(k, k), "one_way_leak", **values) for k in (1e8, 3e5))
    (oil,) = soft.effects
    assert [one.effect.name for one in oil.path] == ["one_way_leak", "viscous_curve", "dahl"]
    rigid = added(DamperModel("m", "s", SOURCES[:2]), "one_way_leak", **values).force(block)
    np.testing.assert_allclose(stiff.force(block), rigid, atol=0.01 * np.abs(rigid).max())
    assert stiff.without("one_way_leak").effects == on_oil(1e8, 1e8).effects
