"""Gas that a damper has, and gas that it has lost."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from motions import entry, force, sweep

from damper_estimator.effects.discovery import find_effect
from damper_estimator.effects.trial import Ranges


@pytest.mark.parametrize(("name", "charge"), [("gas_spring", "static_force"), ("lost_gas", "lost_force")])
@pytest.mark.parametrize("with_mean", [True, False])
def test_a_gas_is_tried_with_its_static_force_where_the_mean_is_to_be_explained(with_mean, name, charge):
    ranges = Ranges(-0.03, 0.03, speed=0.5, acceleration=20.0, force=500.0, seconds=20.0, with_mean=with_mean)
    tried = find_effect(name).trial(ranges)
    at_middle = force(sweep(), entry(name, **{**tried.values, charge: 200.0}))[0]
    assert abs(at_middle) == pytest.approx(200.0 * with_mean)


@given(lost=st.floats(0.0, 1.0), volume=st.floats(2e-5, 1e-3), relative=st.floats(0.0, 1.0))
def test_what_is_lost_of_a_charge_leaves_the_rest(lost, volume, relative):
    gas = {"volume": volume, "relative": relative}
    charged = entry("gas_spring", static_force=300.0, **gas)
    left = force(sweep(), charged, entry("lost_gas", lost_force=300.0 * lost, **gas))
    rest = force(sweep(), entry("gas_spring", static_force=300.0 * (1.0 - lost), **gas))
    assert left == pytest.approx(rest, abs=1e-9 * np.abs(force(sweep(), charged)).max())
