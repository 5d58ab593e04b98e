"""An effect stays what it represents, however it is fitted: beyond its physical limits it imitates another one."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from faults import changed, halves

from damper_estimator.diagnosis import diagnose
from damper_estimator.diagnosis.accepted import fitted_together
from damper_estimator.diagnosis.apply_finding import applied, state_of
from damper_estimator.diagnosis.diagnosis_data import data_of
from damper_estimator.diagnosis.hypotheses import Region, entry_of, hypotheses_for
from damper_estimator.effects.discovery import find_effect
from damper_estimator.model import make_element, parse_model

TRUE, MOST, FOUND = 5.0, 2.0, 0.5  # kg
PLAIN = ({"viscous": {"rate": 1500.0}},)
BEHIND = ({"rubber_mount": {"stiffness": 2e6, "loss": 200.0, "path": list(PLAIN)}},)
LIMITED = Region({"mass": (0.0, MOST)})
REFUSED = Region({}, lambda values: "too heavy" if values["mass"] > MOST else "")


@pytest.fixture(scope="module", params=[PLAIN, BEHIND], ids=["plain", "behind a mount"])
def case(request, base):
    """A model, halves of a recording whose damper moves a mass in addition, and the entry that a search found."""
    model = parse_model({"name": "m", "source": "test", "effects": list(request.param)}, "test")
    part = base.part(0, len(base.kinematics) // 2)
    force = model.force(part.kinematics.block) + TRUE * part.kinematics.acceleration
    element = make_element(find_effect("inertia"), {"mass": FOUND})
    return model, *halves(replace(part, force=force)), element


def mass(model) -> float:
    return float(entry_of(model, "inertia").parameters["mass"])


@pytest.mark.parametrize("mode", ["both", "kept", "refit"])
def test_an_effect_that_is_added_keeps_its_limits(case, mode):
    model, fit, unseen, element = case
    before = state_of(model, [fit], [unseen])
    free = applied(before, element, Region({}), mode, before.rmse_unseen_n**2)
    assert mass(free.model) > 1.5 * MOST
    limited = applied(before, element, LIMITED, mode, before.rmse_unseen_n**2)
    assert FOUND < mass(limited.model) <= MOST


@pytest.mark.parametrize("mode", ["both", "kept", "refit"])
def test_an_effect_that_would_become_another_stays_as_it_was_found(case, mode):
    model, fit, unseen, element = case
    before = state_of(model, [fit], [unseen])
    after = applied(before, element, REFUSED, mode, before.rmse_unseen_n**2)
    assert mass(after.model) == FOUND
    assert after.rmse_unseen_n < before.rmse_unseen_n


def test_a_result_can_be_sent_to_another_process(case):
    model, fit, unseen, element = case
    before = state_of(model, [fit], [unseen])
    after = applied(before, element, REFUSED, "kept", before.rmse_unseen_n**2)
    received = pickle.loads(pickle.dumps(after))
    assert list(received.added) == ["inertia"] and mass(received.model) == mass(after.model)


@pytest.mark.parametrize("refits", [False, True])
def test_what_was_found_keeps_its_limits_where_it_is_fitted_together(case, refits):
    model, fit, unseen, element = case
    data, with_it = data_of(model, [fit], [unseen]), model.with_missing(element)
    assert FOUND < mass(fitted_together(with_it, {"inertia": LIMITED}, data, refits)) <= MOST
    assert mass(fitted_together(with_it, {"inertia": REFUSED}, data, refits)) == FOUND


def test_every_effect_of_a_diagnosis_ends_where_it_is_what_it_represents(user_model, base):
    """A slow memory beside a groove: no effect of the library has these forms, and each is drawn to what is left."""

    def hidden(kinematics):
        x, v = kinematics.displacement, kinematics.velocity
        slow = np.convolve(v, np.exp(-np.arange(200) / 60.0), mode="full")[: v.size] * kinematics.dt
        return 9000.0 * slow - 120.0 * v * np.abs(x / 0.01)

    fit, unseen = halves(changed(base, hidden))
    found = diagnose(user_model, [fit], [unseen])
    known = {one.name: one.region for one in hypotheses_for(user_model, data_of(user_model, [fit], [unseen]).ranges)[0]}
    added = [finding.effect for finding in found.findings if not finding.is_channel]
    assert added
    for effect in added:
        region, entry = known[effect], entry_of(found.improved, effect)
        for name, (low, high) in region.limits.items():
            assert low <= entry.parameters[name] <= high


def test_the_values_of_a_finding_are_those_of_the_improved_model(user_model, base):
    fit, unseen = halves(changed(base, lambda kinematics: TRUE * kinematics.acceleration))
    found = diagnose(user_model, [fit], [unseen])
    (finding,) = found.findings
    (shown,) = finding.parameters
    assert shown.name == "inertia.mass" and shown.value == mass(found.improved) == pytest.approx(TRUE, rel=0.05)
    assert shown.standard_error == found.improved.standard_errors["inertia.mass"]
