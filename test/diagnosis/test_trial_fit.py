"""One effect is fitted to what a model leaves."""

from dataclasses import replace

import numpy as np
import pytest
from faults import changed, halves
from planted import known

from damper_estimator.diagnosis.baseline import baseline_of, derivatives, first_order, near_derivatives, slot_size
from damper_estimator.diagnosis.diagnosis_data import data_of, force_rows, weights
from damper_estimator.diagnosis.explanation import parameters_of
from damper_estimator.diagnosis.hypotheses import hypotheses_for
from damper_estimator.diagnosis.parallel_fits import all_fitted
from damper_estimator.diagnosis.ranking import round_of
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.diagnosis.trial_fit import sketch, trial_fit
from damper_estimator.effects.discovery import find_effect
from damper_estimator.identification import fit, rows_of
from damper_estimator.identification.rows import DRIFTING
from damper_estimator.model import make_element, parse_model


@pytest.fixture(scope="module")
def stiffened(user_model, base):
    """The model against recordings with a spring of 6000 N/m more, and the hypotheses by name."""
    parts = halves(changed(base, lambda k: 6000.0 * k.displacement))
    data = data_of(user_model, parts[:1], parts[1:])
    tried = {c.name: c for c in hypotheses_for(user_model, data.ranges)[0]}
    return baseline_of(user_model, data), tried


@pytest.fixture(scope="module")
def spring(stiffened):
    """The hypothesis of a spring rate with its fit."""
    baseline, tried = stiffened
    hypothesis = next(one for one in tried.values() if one.phenomenon == "spring_rate_error")
    return replace(hypothesis, fit=trial_fit(baseline, hypothesis))


def test_a_planted_effect_takes_the_error_away_on_both_parts(stiffened, spring):
    baseline, tried = stiffened[0], spring.fit
    (value,) = tried.values.values()
    assert abs(value) == pytest.approx(6000.0, rel=0.05)
    for residual, change in (
        (baseline.residual_fit, tried.change_fit),
        (baseline.residual_unseen, tried.change_unseen),
    ):
        assert np.sum((residual + change) ** 2) < 0.2 * np.sum(residual**2)
    assert not tried.hidden and tried.at_bound == ()
    assert spring.fitted_element.parameters == tried.values


@pytest.mark.parametrize(
    "spring", [{"rubber_mount": {"stiffness": 1.5e6, "loss": 0.0}}, {"joint_play": {"stiffness": 2e6}}]
)
def test_a_source_behind_a_compliance_is_found_there(base, spring):
    (name, values), *_ = spring.items()
    inside = [{"viscous": {"rate": 1500.0}}, {"coulomb": {"force": 90.0, "transition": 0.01}}]

    def model(sources):
        return parse_model({"name": "m", "source": "", "effects": [{name: {**values, "path": sources}}]}, "test")

    measured = replace(base, force=model(inside).force(base.kinematics.block))
    without = model(inside[:1])
    assert without.with_missing(make_element(find_effect("coulomb"))).effects[0].path[-1].effect.name == "coulomb"
    parts = halves(measured)
    data = data_of(without, parts[:1], parts[1:])
    baseline = baseline_of(without, data, base=())
    friction = next(one for one in hypotheses_for(without, data.ranges)[0] if one.name == "coulomb")
    found = trial_fit(baseline, friction)
    assert found.values["force"] == pytest.approx(90.0, rel=0.15)
    assert np.sum((baseline.residual_unseen + found.change_unseen) ** 2) < 0.05 * np.sum(baseline.residual_unseen**2)


def test_what_explains_too_little_gets_no_derivatives(stiffened, spring):
    baseline = stiffened[0]
    assert spring.fit.derivatives_fit.shape == (baseline.residual_fit.size, 1)
    assert trial_fit(baseline, spring, worth=2.0).derivatives_fit.shape == (baseline.residual_fit.size, 0)


def test_a_zero_is_hidden_by_the_freed_zero(stiffened):
    baseline, tried = stiffened
    name = next(name for name, c in tried.items() if c.phenomenon == "force_offset")
    assert trial_fit(baseline, tried[name]).hidden


def test_standard_errors_are_those_of_a_fit_of_the_effect_alone(stiffened, spring):
    baseline = stiffened[0]
    reported = parameters_of(spring.fitted_element, spring.fit, round_of(baseline, [spring], "both"))
    model, _ = spring.added_to(baseline.model)
    part = baseline.data.fit[0].measurement
    whole = fit(
        model, [part], free=[spring.name], fix=["*"], starts=0, zero=DRIFTING,
        weights=[weights(baseline.model, part)],
    )  # fmt: skip
    (mine,), (theirs,) = reported, whole.parameters
    assert mine.value == pytest.approx(theirs.value, rel=1e-6)
    assert mine.standard_error == pytest.approx(theirs.standard_error, rel=1e-6)


def test_derivatives_by_linear_parameters_are_exact(user_model, base):
    rows = [rows_of(base)]
    force = force_rows(user_model, rows)
    slots = [i for i, slot in enumerate(user_model.slots) if slot.parameter.linear][:4]
    columns = derivatives(user_model, rows, slots, force)
    for k, i in enumerate(slots):
        vector = np.array([slot.value for slot in user_model.slots])
        vector[i] += 0.37 * slot_size(user_model.slots[i])
        expected = (force_rows(user_model.with_vector(vector), rows) - force) / 0.37
        np.testing.assert_allclose(columns[:, k], expected, atol=1e-6 * np.abs(expected).max())


def test_behind_a_compliance_derivatives_are_those_of_the_path_as_if_it_were_rigid(user_model, base):
    rows = [rows_of(base.part(0, 2000))]
    soft = user_model.with_effect(make_element(find_effect("oil_spring"), {}, user_model.effects))
    slots = list(range(len(soft.slots)))
    columns = near_derivatives(soft, rows, slots, force_rows(soft, rows))
    addresses = [slot.address for slot in soft.slots]
    rigid = derivatives(user_model, rows, range(len(user_model.slots)), force_rows(user_model, rows))
    inner = [addresses.index(slot.address) for slot in user_model.slots]
    np.testing.assert_allclose(columns[:, inner], rigid)
    assert np.abs(columns[:, [i for i in slots if i not in inner]]).max() > 0.0


def test_a_first_order_refit_holds_back_what_would_move_far():
    random = np.random.default_rng(1)
    columns = random.standard_normal((400, 2))
    residual = random.standard_normal(400)
    left, unseen = first_order(residual, columns, residual, columns)
    assert np.sum(left**2) < np.sum(residual**2) and np.array_equal(left, unseen)
    # A parameter that would have to move by a hundred times its size moves by next to nothing.
    far = 1e-3 * columns
    held, _ = first_order(residual, far, residual, far)
    assert np.sum(held**2) > 0.999 * np.sum(residual**2)
    assert first_order(residual, columns[:, :0], residual, columns[:, :0])[0] is residual


def test_a_sketch_is_a_few_thousand_samples_of_all_recordings(user_model, base):
    rows = [rows_of(base), rows_of(base)]
    parts = sketch(rows)
    assert sum(len(part.measurement.kinematics) for part in parts) < 0.8 * 2 * len(base.kinematics)
    short = [rows_of(base.part(0, 1500))]
    assert sketch(short) == short


def test_the_number_of_workers_does_not_change_a_fit(stiffened):
    baseline, tried = stiffened
    some = [tried["coulomb"], tried["inertia"]]
    heard = []
    one, two = (all_fitted(baseline, some, 0.0, workers, heard.append) for workers in (1, 2))
    assert heard == [1, 2, 1, 2]
    for a, b in zip(one, two, strict=True):
        assert a.name == b.name and a.fit.values == b.fit.values
        np.testing.assert_array_equal(a.fit.change_unseen, b.fit.change_unseen)


def test_effects_whose_tests_are_silent_are_tried_against_a_large_error_alone(noisy):
    """White noise follows nothing that was measured; nor does the force of a chamber that lost its oil long before."""
    every = hypotheses_for(noisy.model, noisy.data.ranges)[0]
    tried = [one for one in every if set(one.effect.tests) & set(noisy.hints)]
    assert all(noisy.suggests(one) for one in tried)
    scale = 0.5 * limits().usual * noisy.data.force_rms / 100.0
    quiet = replace(noisy, residual_fit=scale * noisy.residual_fit, residual_unseen=scale * noisy.residual_unseen)
    assert not any(quiet.suggests(one) for one in tried)


def test_a_compliance_is_tried_where_the_friction_behind_it_shows_it(base):
    """Friction that turns round later, without a rate of the force that would give the compliance away."""
    viscous, dahl = {"viscous": {"rate": 200.0}}, {"dahl": {"force": 400.0}}
    for effects, expected in (([viscous], False), ([viscous, dahl], True)):
        model = parse_model({"name": "m", "source": "test", "effects": effects}, "test")
        baseline = baseline_of(model, data_of(model, [base], []))
        vars(baseline)["hints"] = dict.fromkeys(baseline.hints, 0.0) | {"friction step": 0.8}
        for name in ("joint_play", "rubber_mount", "oil_spring"):
            assert baseline.suggests(known(baseline)[name]) == expected
