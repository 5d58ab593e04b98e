"""Which phenomenon the error points to: all explanations of each, specific and form-free, against all others.

    left_p = min over explanations e of phenomenon p of  sqrt(left_fit,e left_unseen,e) + penalty_e
    P(p)   = left_p^-k / sum over q of left_q^-k,        averaged over the bootstrap's replicates of the unseen part

left is a share of the squared error without the explanation. The form-free tests compete with the effects so that a
phenomenon whose form differs from that of the effect in the library does not lose to another one with more freedom; an
effect must explain a good part of what its test does, though. An explanation counts only with what simpler ones cannot
explain: a test must explain clearly more than the simpler tests that it can imitate, and an effect that is no change of
the curve clearly more than any change of the curve.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.diagnosis.atlas_terms import STATIC
from damper_estimator.diagnosis.evaluation import TestEvaluation
from damper_estimator.diagnosis.hypotheses import Hypothesis
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.effects.contract import Effect

_LEAST = 1e-4  # of the error: nothing distinguishes smaller shares


@dataclass(frozen=True)
class PhenomenonScore:
    """How well one phenomenon explains the error.

    Attributes:
        left: share of the squared error.
        replicates: (replicates,) the same with the unseen part drawn again.
        form_free: whether a form-free test explains it better than every effect.
    """

    phenomenon: str
    left: float
    replicates: np.ndarray
    form_free: bool


def scores_of(
    hypotheses: Sequence[Hypothesis],
    tests: Sequence[TestEvaluation],
    replicates_of: Callable[[Hypothesis], np.ndarray],
) -> list[PhenomenonScore]:
    """Every phenomenon that was tried with an effect, the one that explains most first.

    Args:
        hypotheses: evaluated.
        replicates_of: (replicates,) gain of a hypothesis with the unseen part drawn again.
    """
    counted = [test for test in tests if _beyond_simpler(test, tests)]
    curve = next((test.error for test in tests if test.test.name == "curve"), 1.0)
    found = []
    possible = [hypothesis for hypothesis in hypotheses if not hypothesis.exclusion]
    for phenomenon in dict.fromkeys(hypothesis.phenomenon for hypothesis in possible):
        tried = [hypothesis for hypothesis in possible if hypothesis.phenomenon == phenomenon]
        names = {name for hypothesis in tried for name in hypothesis.effect.tests}
        explained = 1.0 - min(hypothesis.evaluation.error for hypothesis in tried)
        alike = [test for test in counted if explained >= limits().form * (1.0 - test.error)]
        tested = [_tested(test) for test in alike if test.test.name in names]
        free_left = min((left for left, _ in tested), default=np.inf)
        for hypothesis in tried:
            if _is_static(hypothesis.effect) or hypothesis.evaluation.error < (1.0 - limits().beyond) * curve:
                tested.append(_tried(hypothesis, replicates_of(hypothesis)))
        if tested:
            left, replicates = min(tested, key=lambda one: one[0])
            found.append(PhenomenonScore(phenomenon, left, replicates, left == free_left))
    return sorted(found, key=lambda score: score.left)


def _is_static(effect: Effect) -> bool:
    """Whether the effect may act as a change of the curve: by its tests, or as a fault of the chain that has none."""
    return set(effect.tests) <= STATIC if effect.tests else effect.kind == "channel"


def probabilities(found: Sequence[PhenomenonScore]) -> dict[str, float]:
    """The probability of each phenomenon, given that it is one of them."""
    if not found:
        return {}
    left = np.maximum([score.replicates for score in found], _LEAST)
    weight = (left / left.min(axis=0)) ** -limits().sharpness
    share = np.mean(weight / weight.sum(axis=0), axis=1)
    return {score.phenomenon: float(p) for score, p in zip(found, share, strict=True)}


def _beyond_simpler(test: TestEvaluation, tests: Sequence[TestEvaluation]) -> bool:
    simpler = min((other.error for other in tests if other.test.name in test.test.contains), default=np.inf)
    return test.error < (1.0 - limits().beyond) * simpler


def _tested(test: TestEvaluation) -> tuple[float, np.ndarray]:
    penalty = limits().form_free_margin + limits().form_free_penalty * test.size
    return test.error + penalty, _drawn(test.gains, test.left_fit) + penalty


def _tried(hypothesis: Hypothesis, gains: np.ndarray) -> tuple[float, np.ndarray]:
    evaluation = hypothesis.evaluation
    penalty = hypothesis.score - evaluation.error + limits().general_margin * hypothesis.effect.general
    return evaluation.error + penalty, _drawn(gains, evaluation.left_fit) + penalty


def _drawn(gains: np.ndarray, left_fit: float) -> np.ndarray:
    return np.sqrt(np.maximum(1.0 - gains, 0.0) * left_fit)
