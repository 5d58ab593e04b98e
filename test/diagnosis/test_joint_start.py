"""A finding is identified from where the search ended, if from the present values it does not keep its promise."""

from dataclasses import replace

import pytest
from faults import halves

from damper_estimator.diagnosis.apply_finding import applied, state_of
from damper_estimator.diagnosis.hypotheses import Region
from damper_estimator.effects.discovery import find_effect
from damper_estimator.model import DamperModel, make_element, parse_model

VISCOUS = {"viscous": {"rate": 1500.0}}
YIELD = {"tanh_hysteresis": {"force": 400.0, "steepness": 900.0, "shift": 0.0}}


def model(*effects) -> DamperModel:
    return parse_model({"name": "m", "source": "test", "effects": list(effects)}, "test")


@pytest.fixture(scope="module")
def behind(base):
    """Halves of a recording of a yield force behind a mount, the model of it, and one without the mount whose yield
    force turns round as softly as a friction of many millimetres.
    """
    truth = model({"rubber_mount": {"stiffness": 1.2e6, "loss": 200.0, "path": [YIELD, VISCOUS]}})
    slow = base.part(0, len(base.kinematics) // 2)
    slow = replace(slow, force=truth.force(slow.kinematics.block))
    soft = model({"tanh_hysteresis": {"force": 400.0, "steepness": 3.0, "shift": 0.0}}, VISCOUS)
    return (*halves(slow), truth, soft)


def test_the_identification_starts_from_the_joint_fit_where_that_leads_further(behind):
    fit, unseen, truth, soft = behind
    before = state_of(soft, [fit], [unseen])
    mount = make_element(find_effect("rubber_mount"), {"stiffness": 1e8, "loss": 100.0}, soft.effects)
    promised = 0.99 * before.rmse_unseen_n**2
    alone = applied(before, mount, Region({}), "both", promised)
    started = applied(before, mount, Region({}), "both", promised, joint=truth)
    assert not alone.fulfils(promised, before) and started.fulfils(promised, before)
    assert list(started.added) == list(alone.added) == ["rubber_mount"]


def test_a_joint_fit_of_another_model_is_ignored(behind):
    fit, unseen, _, soft = behind
    before = state_of(soft, [fit], [unseen])
    mount = make_element(find_effect("rubber_mount"), {"stiffness": 1e8, "loss": 100.0}, soft.effects)
    promised = 0.99 * before.rmse_unseen_n**2
    other = applied(before, mount, Region({}), "both", promised, joint=model(VISCOUS))
    assert other.rmse_unseen_n == applied(before, mount, Region({}), "both", promised).rmse_unseen_n
