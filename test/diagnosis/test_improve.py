"""What an improvement does to models and signal maps in which the truth is known."""

from dataclasses import replace

import numpy as np
import pytest
from faults import changed, halves, late

from damper_estimator.diagnosis import improve
from damper_estimator.effects.discovery import find_effect
from damper_estimator.identification import pooled_error
from damper_estimator.model import load_model, make_element

KEYS = {"action", "effect", "phenomenon", "rmse_fit_n", "rmse_unseen_n"}


@pytest.fixture(scope="module")
def story(user_model, soft):
    return improve(user_model, [soft[0]], [soft[1]], workers=2)


def test_the_error_falls_towards_the_floor_on_data_that_no_fit_saw(story, user_model, soft):
    errors = [step.rmse_unseen_n for step in story.steps]
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 0.5 * errors[0]
    assert errors[0] == pytest.approx(pooled_error(user_model, [soft[1]])[0])
    assert errors[-1] == pytest.approx(pooled_error(story.model, [soft[1]])[0])


def test_the_record_begins_with_the_model_as_given(story, user_model):
    steps = story.record()["steps"]
    assert all(KEYS <= set(step) for step in steps)
    assert steps[0]["effect"] is None and steps[0]["phenomenon"] is None
    assert story.steps[0].model is user_model
    assert {"verdict", "noise_floor_n"} <= set(story.record())


def test_every_step_keeps_its_model_and_what_was_tried(story):
    for step in story.steps[1:]:
        assert step.action in ("correct", "refit", "add", "prune")
        if step.action == "add":
            assert step.effect in step.model.uses()
            assert step.diagnosis.ranking
    assert story.model.fit["bags"] and story.model.fit["residual_stddev"] > 0.0 and story.model.fit["improved"] is True


def test_a_mistake_of_the_chain_goes_to_the_map_and_never_into_the_model(user_model, base):
    fit, unseen = halves(late(base, 0.003))
    improved = improve(user_model, [fit], [unseen])
    assert [step.action for step in improved.steps] == ["start", "correct"]
    assert improved.model.effects == user_model.effects
    assert improved.signals.force.skew == pytest.approx(0.003, abs=3e-4)
    assert improved.steps[-1].rmse_unseen_n < 0.5 * improved.steps[0].rmse_unseen_n


def test_the_record_states_the_error_on_the_corrected_recordings(user_model, base):
    """A model that was identified on a late force starts with an error that the corrected map does not have."""
    fit, unseen = halves(late(base, 0.003))
    given = replace(user_model, fit={**user_model.fit, "bags": [fit.recording], "residual_stddev": 1e3})
    improved = improve(given, [fit], [unseen])
    assert [step.action for step in improved.steps] == ["start", "correct"]
    error, force = stated_error(improved)
    assert improved.model.fit["residual_stddev"] == pytest.approx(error, rel=1e-5)
    assert improved.model.fit["force_rms"] == pytest.approx(force, rel=1e-5)
    assert improved.model.fit["standard_errors"] == user_model.fit["standard_errors"]


def stated_error(improved):
    """Error and rms of the force, N, of the part on which the error is the larger share."""
    last, shares = improved.steps[-1], {}
    for error, group in ((last.rmse_fit_n, improved.fit), (last.rmse_unseen_n, improved.unseen)):
        force = np.std(np.concatenate([m.in_band(m.force)[m.judged] for m in group]))
        shares[error / force] = error, force
    return shares[max(shares)]


def test_the_record_states_the_error_on_data_that_no_fit_saw(base):
    """On the vehicle the model errs as where it was not identified."""
    fit, unseen = halves(base)
    worse = changed(unseen, lambda k: 300.0 * np.sin(2.0 * np.pi * 7.3 * k.time))
    improved = improve(load_model("linear_viscous"), [fit], [worse])
    record, last = improved.model.fit, improved.steps[-1]
    assert record["residual_stddev"] == pytest.approx(last.rmse_unseen_n, rel=1e-5)
    assert last.rmse_unseen_n > 200.0 > 2.0 * last.rmse_fit_n
    assert record["force_stddev"] >= last.rmse_unseen_n


def test_nothing_is_added_where_nothing_is_missing(user_model, base):
    improved = improve(user_model, list(halves(base))[:1], list(halves(base))[1:])
    assert len(improved.steps) == 1 and improved.model is user_model
    assert improved.verdict == "nothing_missing"


def test_changed_parameters_are_identified_anew_and_nothing_is_added(user_model, base):
    stiffer = {s.address: 1.3 * s.value for s in user_model.slots if s.address.startswith("viscous_curve.force")}
    before = user_model.force(base.kinematics.block)
    truth = user_model.with_values(stiffer)
    fit, unseen = halves(changed(base, lambda k: truth.force(k.block) - before))
    improved = improve(user_model, [fit], [unseen])
    assert [step.action for step in improved.steps] == ["start", "refit"]
    assert improved.model.uses() == user_model.uses()


def test_two_effects_are_found_one_after_the_other(user_model, base):
    """A stop and moving mass, each of another shape than its effect's."""

    def hidden(k):
        beyond = np.maximum(np.abs(k.displacement) - 0.018, 0.0)
        stop = 900.0 * np.expm1(beyond / 0.006) * np.sign(k.displacement)
        return stop + 1.3 * np.gradient(k.velocity, k.time)

    fit, unseen = halves(changed(base, hidden))
    improved = improve(user_model, [fit], [unseen], workers=2)
    assert {"end_stop", "inertia"} <= {step.phenomenon for step in improved.steps}


def test_trusted_parameters_stay(user_model, base):
    def heavier(k):
        return 2.0 * np.gradient(k.velocity, k.time)

    fit, unseen = halves(changed(base, heavier))
    improved = improve(user_model, [fit], [unseen], mode="kept")
    kept = {slot.address: slot.value for slot in user_model.slots}
    after = {slot.address: slot.value for slot in improved.model.slots}
    assert "inertia" in improved.model.uses()
    assert {address: after[address] for address in kept} == kept


def test_what_a_later_effect_made_needless_is_taken_out(user_model, soft):
    """Friction that is not there, put in by hand as if an earlier step had added it."""
    from damper_estimator.diagnosis.diagnose import begun
    from damper_estimator.diagnosis.hypotheses import Region
    from damper_estimator.diagnosis.improve import _Improving, _prune

    needless = user_model.with_effect(make_element(find_effect("coulomb"), {"force": 0.5}))
    added = {"coulomb": Region({}), "inertia": Region({})}
    improving = _Improving(replace(begun(needless, [soft[0]], [soft[1]]), added=added), "both")
    improving.keep("start", improving.current, None, None)
    _prune(improving, lambda text, share: None)
    assert improving.steps[-1].action == "prune" and improving.steps[-1].effect == "coulomb"
    assert "coulomb" not in improving.current.model.uses()


def test_a_recording_without_force_is_refused_in_one_line(user_model, base):
    from damper_estimator.errors import InputError

    with pytest.raises(InputError, match="no measured force"):
        improve(user_model, [replace(base, force=None)], [base])
