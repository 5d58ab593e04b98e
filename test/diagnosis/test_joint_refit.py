"""A joint refit finds what derivatives at the old parameters hide."""

from dataclasses import replace

import numpy as np
import pytest
from faults import halves

from damper_estimator.diagnosis.baseline import baseline_of
from damper_estimator.diagnosis.diagnosis_data import data_of
from damper_estimator.diagnosis.evaluation import evaluated, without_effects
from damper_estimator.diagnosis.hypotheses import hypotheses_for
from damper_estimator.diagnosis.joint_refit import jointly_refitted, needs_joint_refit
from damper_estimator.diagnosis.parallel_fits import all_fitted
from damper_estimator.diagnosis.ranking import round_of
from damper_estimator.identification import fit
from damper_estimator.model import load_model, parse_model

YIELD = {"tanh_hysteresis": {"force": 400.0, "steepness": 900.0, "shift": 0.0}}


def on_a_mount(base, other):
    """The baseline of a yield force beside another one, fitted to a damper whose steep one sits behind a mount."""
    inside = [YIELD, other]
    mount = {"rubber_mount": {"stiffness": 1.2e6, "loss": 200.0, "path": inside}}
    behind = parse_model({"name": "behind", "source": "test", "effects": [mount]}, "test")
    slow = base.part(0, len(base.kinematics) // 2)
    slow = replace(slow, force=behind.force(slow.kinematics.block))
    first, last = halves(slow)
    model = fit(parse_model({"name": "rigid", "source": "test", "effects": inside}, "test"), [first], starts=1).model
    return baseline_of(model, data_of(model, [first], [last]))


@pytest.fixture(scope="module")
def softened(base):
    """With few parameters."""
    return on_a_mount(base, {"viscous": {"rate": 1500.0}})


def fitted(baseline, *names):
    tried = [h for h in hypotheses_for(baseline.model, baseline.data.ranges)[0] if h.name in names]
    return all_fitted(baseline, tried, 0.0, 1, lambda done: None)


def test_a_mount_behind_which_a_yield_force_is_steep_is_found(softened):
    (mount,) = evaluated(softened, fitted(softened, "rubber_mount"), "refit")
    before = without_effects(softened)[1]
    ((hypothesis, left),) = jointly_refitted(softened, [mount])
    assert left.square < 0.2 * before.square
    values = hypothesis.joint.effects[0].parameters
    assert values["stiffness"] == pytest.approx(1.2e6, rel=0.15)
    assert values == hypothesis.fit.values and hypothesis.fitted_into(softened.model) is hypothesis.joint
    steepness = next(slot.value for slot in hypothesis.joint.slots if slot.address == "tanh_hysteresis.steepness")
    old = next(slot.value for slot in softened.model.slots if slot.address == "tanh_hysteresis.steepness")
    assert steepness > 2.0 * old


def test_it_is_found_behind_a_curve_of_many_points_too(base):
    many = on_a_mount(base, {"viscous_curve": {}})
    (mount,) = evaluated(many, fitted(many, "rubber_mount"), "refit")
    ((hypothesis, left),) = jointly_refitted(many, [mount])
    assert len(hypothesis.joint.slots) > 15
    assert left.square < 0.1 * min(mount.evaluation.refitted.square, without_effects(many)[1].square)
    assert hypothesis.fit.values["stiffness"] == pytest.approx(1.2e6, rel=0.01)


def test_a_round_ranks_by_the_better_of_both_refits(softened):
    candidates = fitted(softened, "rubber_mount", "coulomb", "inertia")
    first_order, joint = (round_of(softened, candidates, "refit", jointly) for jointly in (False, True))
    assert joint.best.phenomenon == "mount_compliance" and joint.gain(joint.best)[0] > 0.8
    for hypothesis in first_order.hypotheses:
        assert joint.hypothesis(hypothesis.name).score <= hypothesis.score + 1e-12
    assert joint.best.resumed(joint.best).joint is None


def test_a_model_whose_force_is_linear_in_its_parameters_needs_none(base, softened):
    model = load_model("linear_viscous")
    assert not needs_joint_refit(baseline_of(model, data_of(model, [base], [base]), base=()))
    assert needs_joint_refit(softened)


def test_what_stays_far_behind_is_not_refitted_to_the_end(softened):
    names = [hypothesis.name for hypothesis, _ in jointly_refitted(
        softened, evaluated(softened, fitted(softened, "rubber_mount", "inertia", "spring_rate_error"), "refit")
    )]  # fmt: skip
    assert "rubber_mount" in names and np.all([name != "spring_rate_error" for name in names])
