"""How attempts are judged: by squared errors on unseen blocks, against each other, and against thresholds."""

from dataclasses import replace

import numpy as np
import pytest

from damper_estimator.diagnosis import AtlasRow
from damper_estimator.diagnosis.accepted import Accepted
from damper_estimator.diagnosis.attempt import Attempt
from damper_estimator.diagnosis.candidates import candidates
from damper_estimator.diagnosis.judge import Tally, errors, gains, nothing, tallies, with_effects
from damper_estimator.diagnosis.null import null
from damper_estimator.diagnosis.ranking import Round, round_of
from damper_estimator.diagnosis.reidentify import Reidentified
from damper_estimator.diagnosis.report import unexplained_sentence
from damper_estimator.diagnosis.scene import scene
from damper_estimator.diagnosis.search import Search
from damper_estimator.diagnosis.structure import structure
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.diagnosis.verdict import verdict_on
from damper_estimator.numerics import block_draws
from damper_estimator.signals.layout import X

FORCE = 500.0  # N rms, of which thresholds are shares


@pytest.fixture(scope="module")
def noisy(user_model, base):
    """The model with a residual of 100 N rms, white, on both parts; its own form plays no part."""
    own = null(user_model, scene(user_model, [base], [base]), base=())
    random = np.random.default_rng(1)
    fit, unseen = (100.0 * random.standard_normal(part.size) for part in (own.residual_fit, own.residual_unseen))
    weightless = replace(own.scene, fit=weighing(own.scene.fit), unseen=weighing(own.scene.unseen))
    return replace(own, residual_fit=fit, residual_unseen=unseen, scene=weightless)


def weighing(rows):
    return tuple(own.weighing(np.ones(own.weight.size)) for own in rows)


def tried(own, effect, share, phenomenon=None, size=1, unseen=None):
    """An attempt that takes ``share`` of the residual's amplitude away, alike on both parts unless told otherwise."""
    known = {c.effect.name: c for c in candidates(own.model, own.scene.ranges)[0]}
    candidate = known[effect]
    count = own.residual_fit.size
    return Attempt(
        effect, phenomenon or candidate.effect.phenomenon, size, dict(candidate.element.parameters), (),
        np.zeros((count, 0)), np.zeros((own.residual_unseen.size, 0)), np.ones(1), -share * own.residual_fit,
        -(share if unseen is None else unseen) * own.residual_unseen, False,
    )  # fmt: skip


def rounded(own, *attempts, mode="kept") -> Round:
    return round_of(own, candidates(own.model, own.scene.ranges)[0], attempts, mode)


def test_errors_are_summed_by_block(noisy):
    own = errors(noisy.scene.blocks, noisy.residual_fit, noisy.residual_unseen)
    assert own.square == pytest.approx(np.sum(noisy.residual_unseen**2))
    assert own.blocks.size == noisy.scene.blocks.max() + 1


def test_a_gain_is_the_share_that_is_taken_away_in_every_draw(noisy):
    without = errors(noisy.scene.blocks, noisy.residual_fit, noisy.residual_unseen)
    half = errors(noisy.scene.blocks, noisy.residual_fit, 0.5 * noisy.residual_unseen)
    drawn = block_draws(without.blocks.size)
    assert gains(drawn, half, without) == pytest.approx(0.75)
    assert gains(drawn, without, without) == pytest.approx(0.0)


def test_one_effect_with_all_else_kept_is_exact(noisy):
    kept = with_effects(noisy, [tried(noisy, "coulomb", 0.6)], base=False)
    np.testing.assert_allclose(kept.unseen, 0.4 * noisy.residual_unseen)


def test_a_refit_that_harms_unseen_data_counts_as_none(noisy):
    random = np.random.default_rng(2)
    fit = noisy.residual_fit[:, None] + random.standard_normal((noisy.residual_fit.size, 1))
    misled = replace(noisy, base_fit=fit, base_unseen=100.0 * random.standard_normal((noisy.residual_unseen.size, 1)))
    kept, refitted = nothing(misled)
    assert refitted is kept


def test_the_best_explanation_comes_first_and_parameters_count_against_it(noisy):
    attempts = [tried(noisy, "coulomb", 0.70), tried(noisy, "inertia", 0.72, size=30), tried(noisy, "dahl", 0.2)]
    ranked = tallies(noisy, attempts, "kept")
    assert [t.attempt.effect for t in ranked] == ["coulomb", "inertia", "dahl"]
    assert ranked[0].error == pytest.approx(0.3**2)


@pytest.mark.parametrize(
    ("share", "reason"),
    [
        (0.005, "explains nothing"),
        (0.1, "of the squared error on unseen data"),
        (0.8, ""),
    ],
)
def test_what_explains_too_little_is_told_why(noisy, share, reason):
    own = rounded(noisy, tried(noisy, "coulomb", share))
    told = own.reason_against(own.best, FORCE)
    assert reason in told and bool(reason) == bool(told)
    assert (own.gain(own.best)[0] >= limits().gain) == (share == 0.8)


def test_what_is_worth_next_to_nothing_of_the_force_is_told_so(noisy):
    own = rounded(noisy, tried(noisy, "coulomb", 0.8))
    taken = 100.0 * np.sqrt(1.0 - 0.2**2)
    assert "worth" in own.reason_against(own.best, 1.05 * taken / limits().least_force)
    assert not own.reason_against(own.best, 0.9 * taken / limits().least_force)


def test_what_helps_in_a_single_block_is_not_sure(noisy):
    loud = noisy.scene.blocks == 3
    residual = np.where(loud, 50.0, 1.0) * noisy.residual_unseen
    burst = replace(noisy, residual_unseen=residual)
    one = replace(tried(burst, "coulomb", 0.7), change_unseen=np.where(loud, -0.7, 0.5) * residual)
    own = rounded(burst, one)
    assert own.gain(own.best)[0] > limits().gain and own.gain(own.best)[1] < 0.0
    assert "not sure" in own.reason_against(own.best, FORCE)


def test_a_general_explanation_must_be_clearly_better_than_a_specific_one(noisy):
    known = candidates(noisy.model, noisy.scene.ranges)[0]
    general = next(c.effect.name for c in known if c.effect.general)
    error = 0.3**2
    near, far = (
        1.0 - np.sqrt(error + margin) for margin in (0.5 * limits().general_margin, 2.0 * limits().general_margin)
    )
    for share, best in ((near, "coulomb"), (far, general)):
        own = rounded(noisy, tried(noisy, general, 0.7), tried(noisy, "coulomb", share))
        assert own.best.attempt.effect == best


def test_explanations_that_do_as_well_are_tied_and_share_the_confidence(noisy):
    own = rounded(noisy, tried(noisy, "coulomb", 0.70), tried(noisy, "inertia", 0.70), tried(noisy, "oil_spring", 0.1))
    assert own.tied(own.best) in (("inertia",), ("friction",))
    assert own.confidence(("friction",)) == pytest.approx(own.confidence(("inertia",)), abs=0.05)
    assert own.confidence(("friction", "inertia")) > 0.95
    clear = rounded(noisy, tried(noisy, "coulomb", 0.8), tried(noisy, "inertia", 0.3))
    assert clear.tied(clear.best) == () and clear.confidence(("friction",)) > 0.95


def test_probabilities_add_up_and_follow_what_is_left(noisy):
    names = ("coulomb", "inertia", "oil_spring", "gas_spring")
    own = rounded(noisy, *(tried(noisy, name, share) for name, share in zip(names, (0.7, 0.5, 0.3, 0.1), strict=True)))
    values = [own.probabilities[known.phenomenon] for known in own.standings]
    assert sum(own.probabilities.values()) == pytest.approx(1.0)
    assert values == sorted(values, reverse=True)


def found(own, accepted=(), left=100.0) -> Search:
    return Search((own,), tuple(accepted), own.null.model, left, {}, own.mode)


def accepted_of(own) -> Accepted:
    best: Tally = own.best
    element = best.attempt.element(own.candidates[best.attempt.effect])
    return Accepted(own, best, element, (), 1.0, own.gain(best), 100.0, 20.0)


def again_with(own, rmse, enough=True) -> Reidentified:
    return Reidentified(own.null.model, (), rmse, 1.0 - (rmse / 100.0) ** 2, enough, frozenset())


def test_a_finding_is_missing_unless_moving_what_is_there_says_as_much(noisy):
    own = rounded(noisy, tried(noisy, "coulomb", 0.8))
    one = accepted_of(own)
    assert verdict_on(found(own, [one], 20.0), None, FORCE, 5.0) == ("missing", None)
    assert verdict_on(found(own, [one], 20.0), again_with(own, 60.0), FORCE, 5.0)[0] == "missing"
    assert verdict_on(found(own, [one], 20.0), again_with(own, 15.0), FORCE, 5.0)[0] == "parameters_changed"
    assert verdict_on(found(own, [one], 20.0), again_with(own, 15.0, enough=False), FORCE, 5.0)[0] == "missing"


def test_moved_parameters_count_only_where_they_take_most_of_it_away(noisy):
    own = rounded(noisy)
    assert verdict_on(found(own), again_with(own, 20.0), FORCE, 5.0)[0] == "parameters_changed"
    assert verdict_on(found(own), again_with(own, 90.0), FORCE, 5.0)[0] != "parameters_changed"


def test_what_is_left_is_unexplained_only_far_above_the_noise(noisy):
    plain = replace(noisy, model=replace(noisy.model, fit={}))
    own = rounded(plain)
    assert verdict_on(found(own, left=100.0), None, FORCE, 90.0) == ("nothing_missing", None)
    assert verdict_on(found(own, left=100.0), None, FORCE, 5.0) == ("unexplained", None)
    assert verdict_on(found(own, left=100.0), None, 1e5, 5.0) == ("nothing_missing", None)


def test_structure_over_the_motion_is_seen_and_put_in_words(noisy):
    def ripple(rows):
        x = np.concatenate([own.measurement.kinematics.block[X][own.picks] for own in rows])
        return 100.0 * np.sign(x - np.median(x))

    rippled = replace(noisy, residual_fit=ripple(noisy.scene.fit), residual_unseen=ripple(noisy.scene.unseen))
    for own, seen in ((rippled, True), (noisy, False)):
        picture, gain, low = structure(own, errors(own.scene.blocks, own.residual_fit, own.residual_unseen))
        assert (gain > 0.6) == (low > 0.5) == seen
    picture = structure(rippled, errors(rippled.scene.blocks, rippled.residual_fit, rippled.residual_unseen))[0]
    assert "displacement" in picture.words and np.nanmax(np.abs(picture.mean_n)) == pytest.approx(100.0, rel=0.05)


def test_an_unexplained_error_is_said_to_depend_on_what_a_form_free_test_shows():
    row = AtlasRow("position", ("position_dependence",), "velocity and position", 0.6, 0.5, 0.7)
    text = unexplained_sentence([row], None, 100.0, 10.0)
    assert "60 %" in text and "velocity and position" in text and "position dependence" in text
    unsure = replace(row, low=0.1)
    assert "nothing that was measured" in unexplained_sentence([unsure], None, 100.0, 10.0)
