"""A free curve in place of a model's curve, where that is too stiff for the damper."""

import numpy as np
import pytest
from roads import road

import damper_estimator as de
from damper_estimator.diagnosis.diagnose import begun
from damper_estimator.diagnosis.free_curve import with_free_curve
from damper_estimator.effects.discovery import find_effect
from damper_estimator.model import parse_model
from damper_estimator.model.element import labels, new_element
from damper_estimator.signals.layout import ROWS, V

NOISE = 6.0  # N


def model_of(*effects):
    return parse_model({"name": "user", "source": "test", "effects": list(effects)}, "test")


def names(model):
    return [label for label, _ in labels(model.effects)]


def recorded(force, seconds=24.0, seed=3):
    """A recording at 500 Hz of a damper whose force follows from time, displacement and velocity."""
    random = np.random.default_rng(seed)
    time = np.arange(0.0, seconds, 0.002)
    x = road(random, time, 12.0, slope=1.2)
    measured = force(time, x, np.gradient(x, time)) + random.normal(0.0, NOISE, time.size)
    return de.Recording.from_arrays(time, x, force=measured)


def digressive(time, x, v):
    return 900.0 * np.tanh(v / 0.12) * np.where(v > 0.0, 1.0, 0.6) + 300.0 * v


def rubbing(time, x, v):
    """A straight line, and friction of many contacts: parallel sliders with a spring each (Iwan 1966)."""
    force, last = 800.0 * v, np.zeros(20)
    stiffness, most = 2.0e4, np.linspace(2.0, 38.0, 20)
    for i in range(1, x.size):
        last = np.clip(last + stiffness * (x[i] - x[i - 1]), -most, most)
        force[i] += last.sum()
    return force


@pytest.fixture(scope="module")
def recording():
    return recorded(digressive)


@pytest.mark.parametrize("name", ["linear_viscous", "coulomb", "dahl"])
def test_improve_ends_near_the_noise_from_any_start(recording, name):
    better = de.improve(recording, name).only
    assert "viscous_curve" in [step.effect for step in better.steps]
    assert better.steps[-1].rmse_unseen_n < 2.0 * NOISE
    assert better.verdict == "nothing_missing"


def test_a_diagnosis_says_that_the_curve_is_too_stiff(recording):
    found = de.diagnose(recording, de.fit(recording, "linear_viscous").model).only
    assert found.free_curve.replaced == ("linear_viscous", "static_force")
    assert "linear_viscous and static_force leaves" in found.sentence
    assert found.record()["free_curve"]["rmse_unseen_n"] == found.free_curve.state.rmse_unseen_n < found.rmse_n


def test_a_finding_that_leaves_less_comes_before_the_curve():
    recording = recorded(rubbing)
    found = de.diagnose(recording, de.fit(recording, "linear_viscous").model).only
    assert found.free_curve is None
    assert found.findings[0].phenomenon in ("friction", "hysteresis")


def test_an_error_over_velocity_on_another_recording_is_a_change_and_no_stiff_curve(recording):
    model = de.fit(recorded(lambda t, x, v: 4000.0 * v), "linear_viscous").model
    found = de.diagnose(recorded(digressive, seed=4), model).only
    assert found.free_curve is None


def test_a_model_with_a_free_curve_has_none_to_gain(recording):
    fitted = de.fit(recording, "viscous_curve")
    assert with_free_curve(begun(fitted.model, next(iter(recording.measurements.values())), ())) is None


def test_what_is_no_curve_of_velocity_stays(recording):
    model = model_of({"linear_viscous": {}}, {"gas_spring": {}}, {"force_lag": {"time_constant": 0.001}})
    fitted = de.fit(recording, model)
    found = with_free_curve(begun(fitted.model, next(iter(recording.measurements.values())), ()))
    assert found.replaced == ("linear_viscous",)
    assert names(found.state.model) == ["viscous_curve", "gas_spring", "force_lag"]


def test_a_curve_in_place_of_a_line_is_the_same_model():
    before = model_of(
        {"linear_viscous": {"rebound": 1500.0, "compression": 1500.0}},
        {"static_force": {"force": 40.0}},
        {"position_gain": {"gain": 0.4}},
    )
    knots = np.array([-0.5, 0.0, 0.5])
    curve = new_element(
        find_effect("viscous_curve"), before.effects, {"velocity": tuple(knots), "force": tuple(1500.0 * knots + 40.0)}
    )
    after = before.with_instead(["linear_viscous", "static_force"], curve)
    assert names(after) == ["viscous_curve", "position_gain"]
    random = np.random.default_rng(1)
    block = np.full((ROWS, 400), np.nan)
    block[:V] = [np.arange(400) * 1e-3, np.full(400, 1e-3), random.normal(0.0, 0.01, 400)]
    block[V : V + 2] = random.normal(0.0, 0.4, (2, 400))
    assert after.force(block) == pytest.approx(before.force(block), rel=1e-12, abs=1e-9)
