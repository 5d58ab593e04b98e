"""How the hypotheses of a round are ranked, refused and tied."""

from dataclasses import replace

import numpy as np
import pytest
from planted import FORCE, known, rounded, tried

from damper_estimator.diagnosis.atlas_terms import TESTS
from damper_estimator.diagnosis.diagnosis_data import ranges_of
from damper_estimator.diagnosis.phenomenon_scores import PhenomenonScore, probabilities
from damper_estimator.diagnosis.thresholds import limits, using
from damper_estimator.effects.discovery import find_effect


@pytest.mark.parametrize(
    ("share", "reason"),
    [
        (0.005, "explains nothing"),
        (0.1, "of the squared error on unseen data"),
        (0.8, ""),
    ],
)
def test_what_explains_too_little_gets_a_reason(noisy, share, reason):
    current = rounded(noisy, tried(noisy, "coulomb", share))
    reason_given = current.reason_against(current.best, FORCE)
    assert reason in reason_given and bool(reason) == bool(reason_given)
    assert (current.gain(current.best)[0] >= limits().gain) == (share == 0.8)


def test_what_is_worth_next_to_nothing_of_the_force_is_said_so(noisy):
    current = rounded(noisy, tried(noisy, "coulomb", 0.8))
    taken = 100.0 * np.sqrt(1.0 - 0.2**2)
    assert "lowers the error by only" in current.reason_against(current.best, 1.05 * taken / limits().least_force)
    assert not current.reason_against(current.best, 0.9 * taken / limits().least_force)


def test_what_is_hardly_more_probable_than_ten_others_is_not_named(noisy):
    names = ("coulomb", "inertia", "oil_spring", "gas_spring", "relief", "cavitation_limit", "valve_inertia")
    alike = rounded(noisy, *(tried(noisy, name, 0.2) for name in names))
    assert alike.gain(alike.best)[0] > limits().gain
    group = (alike.best.phenomenon, *alike.tied(alike.best))
    assert alike.confidence(alike.best) == pytest.approx(
        alike.probability(group) * limits().form_share * alike.gain(alike.best)[0]
    )
    with using(named=1.01 * alike.confidence(alike.best)):
        assert "probable" in alike.reason_against(alike.best, FORCE)
    with using(named=0.99 * alike.confidence(alike.best)):
        assert not alike.reason_against(alike.best, FORCE)


@pytest.mark.parametrize("share", [0.2, 0.5, 0.8])
def test_what_an_effect_predicts_of_the_unseen_error_counts_for_its_being_meant(noisy, share):
    """Between the probability of a change and certainty, the nearer to certainty the more it predicts."""
    certain = rounded(noisy, tried(noisy, "coulomb", share))
    doubtful = replace(noisy, data=replace(noisy.data, change=0.3))
    current = rounded(doubtful, tried(doubtful, "coulomb", share))
    meant = current.confidence(current.best) / certain.confidence(certain.best)
    assert meant == pytest.approx(1.0 - 0.7 * current.best.evaluation.error)
    more = rounded(doubtful, tried(doubtful, "coulomb", share + 0.1))
    assert more.confidence(more.best) > current.confidence(current.best)


def test_a_constant_has_no_form_that_could_be_wrong(noisy):
    current = rounded(noisy, tried(noisy, "coulomb", 0.3))
    constant = replace(current, constants=frozenset({"coulomb"}))
    assert constant.confidence(constant.best) == pytest.approx(limits().form_right)
    assert current.confidence(current.best) < limits().form_right


def test_what_was_not_fitted_is_said_not_to_have_been_tried(noisy):
    one = tried(noisy, "coulomb", 0.0)
    current = rounded(noisy, replace(one, fit=replace(one.fit, tried=False)))
    assert "not tried" in current.reason_against(current.best, FORCE)
    current = rounded(noisy, one)
    assert "explains nothing" in current.reason_against(current.best, FORCE)


def test_what_is_probably_no_news_is_not_named(noisy):
    old = replace(noisy, data=replace(noisy.data, change=0.1))
    current = rounded(old, tried(old, "coulomb", 0.8))
    assert "both new and right" in current.reason_against(current.best, FORCE)


def test_what_helps_in_a_single_block_is_not_sure(noisy):
    loud = noisy.data.blocks == 3
    residual = np.where(loud, 50.0, 1.0) * noisy.residual_unseen
    burst = replace(noisy, residual_unseen=residual)
    one = tried(burst, "coulomb", 0.7)
    one = replace(one, fit=replace(one.fit, change_unseen=np.where(loud, -0.7, 0.5) * residual))
    current = rounded(burst, one)
    assert current.gain(current.best)[0] > limits().gain and current.gain(current.best)[1] < 0.0
    assert "uncertain" in current.reason_against(current.best, FORCE)


def test_a_general_explanation_must_be_clearly_better_than_a_specific_one(noisy):
    general = next(one.name for one in known(noisy).values() if one.effect.general)
    error = 0.3**2
    near, far = (
        1.0 - np.sqrt(error + margin) for margin in (0.5 * limits().general_margin, 2.0 * limits().general_margin)
    )
    for share, best in ((near, "coulomb"), (far, general)):
        current = rounded(noisy, tried(noisy, general, 0.7), tried(noisy, "coulomb", share))
        assert current.best.name == best


def test_explanations_that_do_as_well_are_tied_and_share_the_confidence(noisy):
    current = rounded(
        noisy, tried(noisy, "coulomb", 0.70), tried(noisy, "inertia", 0.70), tried(noisy, "oil_spring", 0.1)
    )
    assert current.tied(current.best) in (("inertia",), ("friction",))
    assert current.probability(("friction",)) == pytest.approx(current.probability(("inertia",)), abs=0.05)
    assert current.probability(("friction", "inertia")) > 0.95
    clear = rounded(noisy, tried(noisy, "coulomb", 0.8), tried(noisy, "inertia", 0.3))
    assert clear.tied(clear.best) == () and clear.probability(("friction",)) > 0.95


def test_a_tie_is_found_by_what_the_data_support_of_it(noisy):
    """The first of a tie may explain too little on the unseen part alone, while the next one explains enough there."""
    below, above = (1.0 - np.sqrt(1.0 - gain) for gain in (limits().gain - 0.02, limits().gain + 0.02))
    first, second = tried(noisy, "coulomb", 0.2, below), tried(noisy, "inertia", 0.16, above)
    current = rounded(noisy, first, second)
    assert current.best.name == "coulomb" and current.tied(current.best) == ("inertia",)
    assert [one.name for one in current.supported(FORCE)] == ["inertia"]
    assert [one.name for one in rounded(noisy, first).supported(FORCE)] == []
    assert rounded(noisy).supported(FORCE) == []
    general = next(one.name for one in known(noisy).values() if one.effect.general and one.phenomenon != "friction")
    stands = rounded(noisy, first, tried(noisy, general, 0.18, above))
    assert stands.best.name == "coulomb" and stands.tied(stands.best) and stands.supported(FORCE) == []


def test_probabilities_add_up_and_follow_what_is_left(noisy):
    names = ("coulomb", "inertia", "oil_spring", "gas_spring")
    current = rounded(
        noisy, *(tried(noisy, name, share) for name, share in zip(names, (0.7, 0.5, 0.3, 0.1), strict=True))
    )
    values = [current.probabilities[score.phenomenon] for score in current.scores]
    assert sum(current.probabilities.values()) == pytest.approx(1.0)
    assert values == sorted(values, reverse=True)


def test_what_is_known_otherwise_weighs_in(noisy):
    """A straight line over displacement: gas comes first unless a spring is stated, or the gas was identified."""
    ranges = ranges_of([part.measurement for part in noisy.data.fit])
    trial = find_effect("spring_rate_error").trial
    assert trial(ranges).prior < 1.0 == find_effect("gas_spring").trial(ranges).prior
    assert trial(replace(ranges, spring_rate=2e4)).prior == 1.0
    assert trial(replace(ranges, identified=frozenset({"gas_spring"}))).prior == 1.0
    alike = np.full(8, 0.5)
    scores = [PhenomenonScore("gas", 0.5, alike), PhenomenonScore("spring", 0.5, alike, prior=0.25)]
    assert probabilities(scores) == pytest.approx({"gas": 0.8, "spring": 0.2})


def test_implausible_values_lower_the_prior(noisy):
    """Only those of the fit: whatever else the effect may be, and not its error."""
    friction, other = tried(noisy, "contact_friction", 0.6), tried(noisy, "gas_spring", 0.6)
    late = replace(friction, fit=replace(friction.fit, values={**friction.fit.values, "travel": 9e-4}))
    assert late.fitted_prior < 0.5 and friction.fitted_prior == 1.0
    before, after = (rounded(noisy, one, other).probabilities for one in (friction, late))
    odds = [found["friction"] / found["gas_spring"] for found in (before, after)]
    assert odds[1] == pytest.approx(late.fitted_prior * odds[0])


def test_only_what_is_identified_of_a_model_is_known(user_model, base):
    gas = tuple(slot.address for slot in user_model.slots if "gas_spring" in slot.address)
    assert "gas_spring" in ranges_of([base], user_model).identified
    assert "gas_spring" in ranges_of([base], replace(user_model, fixed=gas[:1])).identified
    assert "gas_spring" not in ranges_of([base], replace(user_model, fixed=gas)).identified


def long_groove(baseline, share):
    """As long as the stroke, so that it acts alike at every position."""
    groove = tried(baseline, "bypass_groove", share)
    longest = groove.region.limits["half_length"][1]
    return replace(groove, fit=replace(groove.fit, values={**groove.fit.values, "half_length": longest}))


def test_what_imitates_a_changed_curve_must_explain_clearly_more_than_that(noisy):
    free = rounded(noisy, long_groove(noisy, 0.5))
    assert not free.best.exclusion and not free.reason_against(free.best, FORCE), "no curve explains white noise"
    residuals = {
        part: 300.0 * np.tanh(np.concatenate([r.measurement.kinematics.velocity[r.picks] for r in rows]) / 0.1)
        for part, rows in (("residual_fit", noisy.data.fit), ("residual_unseen", noisy.data.unseen))
    }
    curve = replace(noisy, **residuals)
    excluded = rounded(curve, long_groove(curve, 0.5))
    (groove,) = excluded.hypotheses
    assert "a change of the curve" in groove.exclusion == excluded.reason_against(groove, FORCE)
    assert excluded.gain(groove)[0] > limits().gain


def test_what_effects_imitate_is_a_test_that_exists(noisy):
    imitated = {one.name: one.imitates for one in known(noisy).values() if one.imitates}
    friction = dict.fromkeys(("bouc_wen", "tanh_hysteresis"), "friction step")
    curve, mass = (
        dict.fromkeys(("bypass_groove", "dashpot"), "curve"),
        dict.fromkeys(("valve_inertia", "valve_lag"), "mass"),
    )
    assert imitated == {**curve, **mass, **friction}
    assert set(imitated.values()) <= {test.name for test in TESTS}
    assert all(known(noisy)[name].region.excludes is not None for name in imitated)
