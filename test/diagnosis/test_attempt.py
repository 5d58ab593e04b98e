"""One effect is fitted to what a model leaves."""

import numpy as np
import pytest
from faults import changed, halves

from damper_estimator.diagnosis.attempt import attempt, sketch
from damper_estimator.diagnosis.candidates import candidates
from damper_estimator.diagnosis.null import derivatives, first_order, near_derivatives, null, slot_size
from damper_estimator.diagnosis.pool import attempts
from damper_estimator.diagnosis.ranking import round_of
from damper_estimator.diagnosis.report import parameters_of
from damper_estimator.diagnosis.scene import force_rows, scene, weights
from damper_estimator.effects.discovery import find_effect
from damper_estimator.identification import fit, rows_of
from damper_estimator.model import make_element


@pytest.fixture(scope="module")
def stiffened(user_model, base):
    """The model against recordings with a spring of 6000 N/m more, and the candidates by name."""
    parts = halves(changed(base, lambda k: 6000.0 * k.displacement))
    stage = scene(user_model, parts[:1], parts[1:])
    tried = {c.effect.name: c for c in candidates(user_model, stage.ranges)[0]}
    return null(user_model, stage), tried


@pytest.fixture(scope="module")
def spring(stiffened):
    """The attempt with a spring rate."""
    own, tried = stiffened
    name = next(name for name, c in tried.items() if c.effect.phenomenon == "spring_rate_error")
    return tried[name], attempt(own, tried[name])


def test_a_planted_effect_takes_the_error_away_on_both_parts(stiffened, spring):
    own, (candidate, tried) = stiffened[0], spring
    (value,) = tried.values.values()
    assert abs(value) == pytest.approx(6000.0, rel=0.05)
    for residual, change in (
        (own.residual_fit, tried.change_fit),
        (own.residual_unseen, tried.change_unseen),
    ):
        assert np.sum((residual + change) ** 2) < 0.2 * np.sum(residual**2)
    assert not tried.hidden and tried.at_bound == ()
    assert tried.element(candidate).parameters == tried.values


def test_what_explains_too_little_gets_no_derivatives(stiffened, spring):
    own, (candidate, tried) = stiffened[0], spring
    assert tried.own_fit.shape == (own.residual_fit.size, 1)
    assert attempt(own, candidate, worth=2.0).own_fit.shape == (own.residual_fit.size, 0)


def test_a_zero_is_hidden_by_the_freed_zero(stiffened):
    own, tried = stiffened
    name = next(name for name, c in tried.items() if c.effect.phenomenon == "force_offset")
    assert attempt(own, tried[name]).hidden


def test_standard_errors_are_those_of_a_fit_of_the_effect_alone(stiffened, spring):
    own, (candidate, tried) = stiffened[0], spring
    told = parameters_of(tried.element(candidate), tried, round_of(own, [candidate], [tried], "both"))
    model, _ = candidate.added_to(own.model)
    part = own.scene.fit[0].measurement
    whole = fit(
        model, [part], free=[candidate.effect.name], fix=["*"], starts=0, zero_free=True,
        weights=[weights(own.model, part)],
    )  # fmt: skip
    (mine,), (theirs,) = told, whole.parameters
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
    assert sum(len(own.measurement.kinematics) for own in parts) < 0.8 * 2 * len(base.kinematics)
    short = [rows_of(base.part(0, 1500))]
    assert sketch(short) == short


def test_the_number_of_workers_does_not_change_an_attempt(stiffened):
    own, tried = stiffened
    some = [tried["coulomb"], tried["inertia"]]
    heard = []
    one, two = (attempts(own, some, 0.0, workers, heard.append) for workers in (1, 2))
    assert heard == [1, 2, 1, 2]
    for a, b in zip(one, two, strict=True):
        assert a.effect == b.effect and a.values == b.values
        np.testing.assert_array_equal(a.change_unseen, b.change_unseen)
