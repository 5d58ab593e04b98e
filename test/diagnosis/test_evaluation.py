"""How hypotheses are evaluated: by squared errors on unseen blocks."""

from dataclasses import replace

import numpy as np
import pytest
from planted import known, tried

from damper_estimator.diagnosis.evaluation import errors, evaluated, gains, with_effects, without_effects
from damper_estimator.numerics import block_draws


def test_errors_are_summed_by_block(noisy):
    current = errors(noisy.data.blocks, noisy.residual_fit, noisy.residual_unseen)
    assert current.square == pytest.approx(np.sum(noisy.residual_unseen**2))
    assert current.blocks.size == noisy.data.blocks.max() + 1


def test_a_gain_is_the_share_that_is_taken_away_in_every_draw(noisy):
    without = errors(noisy.data.blocks, noisy.residual_fit, noisy.residual_unseen)
    half = errors(noisy.data.blocks, noisy.residual_fit, 0.5 * noisy.residual_unseen)
    drawn = block_draws(without.blocks.size)
    assert gains(drawn, half, without) == pytest.approx(0.75)
    assert gains(drawn, without, without) == pytest.approx(0.0)


def test_one_effect_with_all_else_kept_is_exact(noisy):
    kept = with_effects(noisy, [tried(noisy, "coulomb", 0.6).fit], base=False)
    np.testing.assert_allclose(kept.unseen, 0.4 * noisy.residual_unseen)


def test_a_refit_that_harms_unseen_data_counts_as_none(noisy):
    random = np.random.default_rng(2)
    fit = noisy.residual_fit[:, None] + random.standard_normal((noisy.residual_fit.size, 1))
    misled = replace(noisy, base_fit=fit, base_unseen=100.0 * random.standard_normal((noisy.residual_unseen.size, 1)))
    kept, refitted = without_effects(misled)
    assert refitted is kept


@pytest.mark.parametrize(("own_is_there", "imitates"), [(True, False), (False, True)])
def test_an_effect_without_what_only_it_can_change_imitates_changed_parameters(noisy, own_is_there, imitates):
    """The error is what the model's parameters can make, with or without the rest of the effect's change."""
    random = np.random.default_rng(3)

    def drawn(like):
        return random.standard_normal((3, like.size)) * np.array([[100.0], [60.0], [10.0]])

    parts = {"fit": drawn(noisy.residual_fit), "unseen": drawn(noisy.residual_unseen)}
    error = {name: known + own_is_there * own + noise for name, (known, own, noise) in parts.items()}
    baseline = replace(
        noisy, residual_fit=error["fit"], residual_unseen=error["unseen"],
        base_fit=parts["fit"][0][:, None], base_unseen=parts["unseen"][0][:, None],
    )  # fmt: skip
    changes = {f"change_{name}": -(known + own) for name, (known, own, _) in parts.items()}
    hypothesis = tried(baseline, "coulomb", 0.0)
    hypothesis = replace(hypothesis, fit=replace(hypothesis.fit, **changes))
    judged = evaluated(baseline, [hypothesis], "both")[0]
    assert 1.0 - judged.evaluation.kept.square / np.sum(error["unseen"] ** 2) > 0.6
    assert judged.evaluation.imitates_change == imitates and bool(judged.exclusion_alone) == imitates
    assert not judged.exclusion, "a second effect may hide what only this one can change"


def test_the_best_explanation_comes_first_and_parameters_count_against_it(noisy):
    large = max(known(noisy).values(), key=lambda hypothesis: hypothesis.size)
    assert large.size >= known(noisy)["coulomb"].size + 3
    fitted = [tried(noisy, "dahl", 0.2), tried(noisy, large.name, 0.72), tried(noisy, "coulomb", 0.70)]
    ranked = evaluated(noisy, fitted, "kept")
    assert [hypothesis.name for hypothesis in ranked] == ["coulomb", large.name, "dahl"]
    assert (
        ranked[0].evaluation.error == pytest.approx(0.3**2) and ranked[1].evaluation.error < ranked[0].evaluation.error
    )
