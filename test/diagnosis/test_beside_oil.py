"""A mass on the rod, which no oil carries, beside a void that opens under the damper's own force."""

from dataclasses import replace

import numpy as np
import pytest
from faults import changed, halves

from damper_estimator.diagnosis import diagnose
from damper_estimator.effects.discovery import all_effects
from damper_estimator.model.element import new_element


@pytest.fixture(scope="module")
def with_void(user_model, base):
    """The user's model with a void that opens at half of the recorded force."""
    opening = 0.5 * float(np.std(base.force))
    model = user_model.with_missing(entry("rod_side_void", user_model, stiffness=2e6, opening=opening, gas=2e4))
    return replace(model, fit=user_model.fit)  # as if it had been identified: its parameters are kept


def entry(name, model, **values):
    """A new entry of a model."""
    return new_element(all_effects()[name], model.effects, values)


def measured(model, base, extra):
    """The recording as it would be of a damper that is the model, and something more."""
    return changed(base, lambda k: model.force(k.block) - base.force + extra(k))


@pytest.mark.parametrize("mass", [8.0, 25.0])
def test_a_mass_is_found_with_its_size_beside_a_void(mass, with_void, base):
    fit, unseen = halves(measured(with_void, base, lambda k: mass * k.acceleration))
    found = diagnose(with_void, [fit], [unseen])
    first = found.findings[0]
    assert first.phenomenon == "inertia" and not first.tied_with
    assert first.parameters[0].value == pytest.approx(mass, rel=0.1)
    assert first.rmse_after_n < 0.2 * first.rmse_before_n


def test_a_mass_is_put_beside_the_oil(with_void):
    changed_model = with_void.with_missing(entry("inertia", with_void))
    names = [one.effect.name for one in changed_model.effects]
    assert names[0] == "rod_side_void" and names[-1] == "inertia"
