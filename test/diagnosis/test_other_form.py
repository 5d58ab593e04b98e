"""Another form of a phenomenon in the place of what a model has of it."""

from dataclasses import replace

import numpy as np
import pytest
from faults import BAGS

from damper_estimator.diagnosis import improve
from damper_estimator.diagnosis.apply_finding import state_of
from damper_estimator.diagnosis.diagnose import begun
from damper_estimator.diagnosis.other_form import in_another_form
from damper_estimator.identification import fit
from damper_estimator.model import load_model, parse_model
from damper_estimator.model.element import labels
from damper_estimator.recordings import open_bag
from damper_estimator.signals import SignalMap, measure
from damper_estimator.signals.channels import damper_names


def model_of(*effects):
    return parse_model({"name": "user", "source": "test", "effects": list(effects)}, "test")


@pytest.fixture(scope="module")
def creeping():
    """A damper whose yield force creeps and whose current changes, in two halves."""
    bag = open_bag(BAGS / "semi_active_random.mcap")
    measurement = measure(bag, SignalMap(), damper_names(bag)[0])
    force = load_model("mr_damper_with_creep").force(measurement.kinematics.block)
    force = force + np.random.default_rng(5).normal(0.0, 5.0, force.size)
    return begun(load_model("linear_viscous"), [replace(measurement, force=force)], [])


def identified(state, *effects):
    model = fit(model_of(*effects), list(state.fit), starts=1).model
    return state_of(model, state.fit, state.unseen)


def names(model):
    return [element.effect.name for _, element in labels(model.effects)]


def test_a_better_form_takes_the_place_of_a_wrong_one(creeping):
    state = identified(creeping, {"viscous_curve": {}}, {"semi_active_squash": {}}, {"static_force": {}})
    after, label, form = in_another_form(state)
    assert (label, form.phenomenon) == ("semi_active_squash", "current")
    assert after.rmse_unseen_n < 0.5 * state.rmse_unseen_n
    assert "semi_active_squash" not in names(after.model) and form.name in names(after.model)
    assert list(after.added) == [form.name]


def test_the_right_form_stays(creeping):
    state = identified(creeping, {"linear_viscous": {}}, {"command_slip": {"creep": 0.005}}, {"dahl": {}})
    assert in_another_form(state) is None


def test_improve_takes_the_step_where_nothing_can_be_added(creeping):
    state = identified(creeping, {"linear_viscous": {}}, {"command_yield": {}}, {"static_force": {}})
    better = improve(state.model, state.fit, state.unseen)
    assert better.steps[-1].rmse_unseen_n < 0.3 * better.steps[0].rmse_unseen_n
    assert "command_yield" not in names(better.model)
    (replaced,) = (step for step in better.steps if step.note == "in place of command_yield")
    assert (replaced.action, replaced.effect, replaced.phenomenon) == ("add", "command_slip", "current")
    assert "added command_slip in place of command_yield" in better.sentence
