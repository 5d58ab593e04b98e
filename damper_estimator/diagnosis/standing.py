"""Which phenomenon the error points to: all explanations of each, specific and form-free, against all others.

    left_p = min over explanations e of phenomenon p of  sqrt(left_fit,e left_unseen,e) + penalty_e
    P(p)   = left_p^-k / sum over q of left_q^-k,        averaged over the bootstrap's replicates of the unseen part

left is a share of the squared error without the explanation. The form-free tests stand beside the effects so that a
phenomenon whose form is not quite that of the effect in the library does not lose to another one with more freedom;
an effect must explain a good part of what its test does, though.
An explanation may claim only what is its own: a test counts if it explains clearly more than the simpler tests that it
can imitate, and an effect that is no change of the curve if it explains clearly more than any change of the curve.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.diagnosis.atlas_terms import STATIC
from damper_estimator.diagnosis.judge import Shown, Tally
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.effects.contract import Effect

_LEAST = 1e-4  # of the error: smaller shares are told apart by nothing


@dataclass(frozen=True)
class Standing:
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


def standings(
    tallies: Sequence[Tally],
    tests: Sequence[Shown],
    effects: Mapping[str, Effect],
    replicates_of: Callable[[Tally], np.ndarray],
) -> list[Standing]:
    """Every phenomenon that was tried with an effect, the one that explains most first.

    Args:
        effects: of the tallies, by name.
        replicates_of: (replicates,) gain of a tally with the unseen part drawn again.
    """
    counted = [test for test in tests if _beyond_simpler(test, tests)]
    curve = next((test.error for test in tests if test.test.name == "curve"), 1.0)
    found = []
    for phenomenon in dict.fromkeys(tally.attempt.phenomenon for tally in tallies):
        tried = [tally for tally in tallies if tally.attempt.phenomenon == phenomenon]
        names = {name for tally in tried for name in effects[tally.attempt.effect].tests}
        explained = 1.0 - min(tally.error for tally in tried)
        alike = [test for test in counted if explained >= limits().form * (1.0 - test.error)]
        tested = [_tested(test) for test in alike if test.test.name in names]
        free_left = min((left for left, _ in tested), default=np.inf)
        for tally in tried:
            effect = effects[tally.attempt.effect]
            if _is_static(effect) or tally.error < (1.0 - limits().own) * curve:
                tested.append(_tried(tally, effect.general, replicates_of(tally)))
        if tested:
            left, replicates = min(tested, key=lambda one: one[0])
            found.append(Standing(phenomenon, left, replicates, left == free_left))
    return sorted(found, key=lambda standing: standing.left)


def _is_static(effect: Effect) -> bool:
    """Whether the effect may act as a change of the curve: by its tests, or as a fault of the chain that has none."""
    return set(effect.tests) <= STATIC if effect.tests else effect.kind == "channel"


def probabilities(found: Sequence[Standing]) -> dict[str, float]:
    """The probability of each phenomenon, given that it is one of them."""
    if not found:
        return {}
    left = np.maximum([standing.replicates for standing in found], _LEAST)
    weight = (left / left.min(axis=0)) ** -limits().sharpness
    share = np.mean(weight / weight.sum(axis=0), axis=1)
    return {standing.phenomenon: float(p) for standing, p in zip(found, share, strict=True)}


def _beyond_simpler(test: Shown, tests: Sequence[Shown]) -> bool:
    simpler = min((other.error for other in tests if other.test.name in test.test.contains), default=np.inf)
    return test.error < (1.0 - limits().own) * simpler


def _tested(test: Shown) -> tuple[float, np.ndarray]:
    penalty = limits().form_free_margin + limits().form_free_penalty * test.size
    return test.error + penalty, _drawn(test.gains, test.left_fit) + penalty


def _tried(tally: Tally, general: bool, gains: np.ndarray) -> tuple[float, np.ndarray]:
    penalty = tally.score - tally.error + limits().general_margin * general
    return tally.error + penalty, _drawn(gains, tally.left_fit) + penalty


def _drawn(gains: np.ndarray, left_fit: float) -> np.ndarray:
    return np.sqrt(np.maximum(1.0 - gains, 0.0) * left_fit)
