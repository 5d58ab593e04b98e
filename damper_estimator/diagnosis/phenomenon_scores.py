"""Which phenomenon the error points to: the best explanation of each against those of all others.

    left_e = sqrt(left_fit,e left_unseen,e) + penalty_e          of an effect; of a form-free test likewise left_t
    left_p = min over the effects e of p of left_e^(1 - w)  x  min over the tests t of p of left_t^w
    P(p)   = prior_p left_p^-kn / sum over q of prior_q left_q^-kn,    averaged over a bootstrap of the unseen part

prior_p is that of its effect with its fitted values, 1 for most; n says for how many independent recordings those at
hand count (``by_recording``).

left is a share of the squared error. The tests assume no form: a phenomenon whose real form differs from that of the
effect in the library keeps part of its credit, and one whose effect fits while the error does not depend on its
variables loses part of it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.diagnosis.evaluation import Remaining, TestEvaluation
from damper_estimator.diagnosis.hypotheses import Hypothesis
from damper_estimator.diagnosis.thresholds import limits

_LEAST = 1e-4  # of the error: nothing distinguishes smaller shares


@dataclass(frozen=True)
class PhenomenonScore:
    """How well one phenomenon explains the error.

    Attributes:
        left: share of the squared error, of the best effect and the best test.
        replicates: (replicates,) the same with the unseen part drawn again.
        prior: of its best effect.
    """

    phenomenon: str
    left: float
    replicates: np.ndarray
    prior: float = 1.0


def scores_of(hypotheses: Sequence[Hypothesis], tests: Sequence[TestEvaluation]) -> list[PhenomenonScore]:
    """Every phenomenon that was tried by the evaluated hypotheses, the one that explains most first."""
    best: dict[str, tuple[float, Hypothesis]] = {}
    for hypothesis in hypotheses:
        left = hypothesis.score + general_margin(hypothesis.evaluation.error) * hypothesis.effect.general
        if not hypothesis.exclusion_alone and left < best.get(hypothesis.phenomenon, (np.inf,))[0]:
            best[hypothesis.phenomenon] = left, hypothesis
    found = []
    for phenomenon, (left, hypothesis) in best.items():
        penalty = left - hypothesis.evaluation.error
        drawn = hypothesis.evaluation.remaining.drawn + penalty
        names = {name for one in hypotheses if one.phenomenon == phenomenon for name in one.tests}
        test = min((test for test in tests if test.test.name in names), key=lambda test: test.error, default=None)
        free = Remaining(1.0, np.ones_like(drawn), 1.0) if test is None else test.remaining
        blended = float(_blended(left, free.error)), _blended(drawn, free.drawn)
        found.append(PhenomenonScore(phenomenon, *blended, hypothesis.fitted_prior))
    return sorted(found, key=lambda score: score.left)


def general_margin(left: float | np.ndarray, whole: float | np.ndarray = 1.0) -> float | np.ndarray:
    """What a general effect must explain more than a specific one, where it leaves ``left`` of the squared error
    ``whole``, in the unit of both.
    """
    return np.minimum(limits().general_margin * whole, limits().general_share * left)


def _blended(left: float | np.ndarray, free: float | np.ndarray) -> np.ndarray:
    """What an effect and the test of its phenomenon leave, as one share."""
    share = limits().form_free
    return np.maximum(left, _LEAST) ** (1.0 - share) * np.maximum(free, _LEAST) ** share


def probabilities(found: Sequence[PhenomenonScore], independent: float = 1.0) -> dict[str, float]:
    """The probability of each phenomenon, given that it is one of them, if the recordings count for so many
    independent ones.
    """
    if not found:
        return {}
    left = np.array([score.replicates for score in found])
    prior = np.array([[score.prior] for score in found])
    weight = prior * (left / left.min(axis=0)) ** -(independent * limits().sharpness)
    share = np.mean(weight / weight.sum(axis=0), axis=1)
    return {score.phenomenon: float(p) for score, p in zip(found, share, strict=True)}
