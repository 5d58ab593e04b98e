"""One round: which hypothesis explains most, how sure that is, and what else it could be."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from damper_estimator.diagnosis.baseline import Baseline
from damper_estimator.diagnosis.evaluation import (
    HIGH,
    LOW,
    Errors,
    TestEvaluation,
    evaluated,
    evaluated_tests,
    rmse,
    with_refitted,
    without_effects,
)
from damper_estimator.diagnosis.hypotheses import Hypothesis
from damper_estimator.diagnosis.joint_refit import jointly_refitted, needs_joint_refit
from damper_estimator.diagnosis.phenomenon_scores import PhenomenonScore, probabilities, scores_of
from damper_estimator.diagnosis.thresholds import limits

MOST_TIED = 3  # others


@dataclass(frozen=True)
class Round:
    """All hypotheses on one model.

    Attributes:
        baseline: the model that effects were added to.
        hypotheses: evaluated, best first; without those whose force the freed zero of the gauge hides.
        hidden: those that it hides.
        tests: form-free tests of the same error.
        kept, refitted: what is left without any effect.
        constants: names of effects that are a constant force here: no other form could be meant.
    """

    baseline: Baseline
    hypotheses: tuple[Hypothesis, ...]
    hidden: tuple[Hypothesis, ...]
    tests: tuple[TestEvaluation, ...]
    kept: Errors
    refitted: Errors
    mode: str
    constants: frozenset[str] = frozenset()

    @cached_property
    def scores(self) -> list[PhenomenonScore]:
        """All phenomena, the one that explains most first."""
        return scores_of(self.hypotheses, self.tests)

    @cached_property
    def probabilities(self) -> dict[str, float]:
        """Of each phenomenon, given that what is missing is one of them."""
        return probabilities(self.scores, self.baseline.data.independent)

    @property
    def best(self) -> Hypothesis | None:
        """The effect that comes first: of the phenomenon that explains most, the one with the smallest score."""
        if not self.scores:
            return self.hypotheses[0] if self.hypotheses else None
        return self.best_of(max(self.probabilities, key=self.probabilities.__getitem__))

    def best_of(self, phenomenon: str) -> Hypothesis:
        """The effect that explains most in the way of one phenomenon."""
        return next(h for h in self.hypotheses if h.phenomenon == phenomenon and not h.exclusion_alone)

    def hypothesis(self, effect: str) -> Hypothesis:
        """The one with an effect."""
        return next(hypothesis for hypothesis in self.hypotheses if hypothesis.name == effect)

    def decided_for(self, best: Hypothesis) -> "Round":
        """What is asked of a round after an effect was chosen: without the other hypotheses."""
        return replace(self.concluded, hypotheses=(best,), hidden=())

    @property
    def concluded(self) -> "Round":
        """The same without what was computed on the way, which takes much memory for long recordings."""
        return replace(self, baseline=replace(self.baseline))

    @property
    def refits(self) -> bool:
        """Whether the model is refitted, with every effect and without any, before errors are compared."""
        return self.mode == "refit"

    @property
    def without(self) -> Errors:
        """What is left without any effect, as this round evaluates."""
        return self.refitted if self.refits else self.kept

    def left(self, hypothesis: Hypothesis) -> Errors:
        """What is left with an effect, as this round evaluates."""
        return hypothesis.evaluation.refitted if self.refits else hypothesis.evaluation.kept

    def replicates(self, hypothesis: Hypothesis) -> np.ndarray:
        """(replicates,) gain of an effect, as this round evaluates."""
        evaluation = hypothesis.evaluation
        return evaluation.refitted_gains if self.refits else evaluation.kept_gains

    def gain(self, hypothesis: Hypothesis) -> tuple[float, float, float]:
        """Gain on unseen data with the 5 and 95 % ends of its bootstrap, as this round evaluates."""
        low, high = np.percentile(self.replicates(hypothesis), [LOW, HIGH])
        return 1.0 - self.left(hypothesis).square / max(self.without.square, 1e-300), float(low), float(high)

    def reason_against(self, hypothesis: Hypothesis, force_rms: float) -> str:
        """Why the data do not support an effect by itself; "" where they do."""
        if hypothesis.exclusion_alone:
            return hypothesis.exclusion_alone
        if not hypothesis.fit.tried:
            return (
                f"not tried: its form-free tests explain less than {100.0 * limits().hint:.0f} % of the squared error"
            )
        gain, low, _ = self.gain(hypothesis)
        before, after = rmse(self.baseline, self.without), rmse(self.baseline, self.left(hypothesis))
        if gain <= 0.02:
            return "explains nothing on unseen data"
        required = limits().gain
        if gain < required:
            return (
                f"explains {_below(gain, required)} % of the squared error on unseen data; "
                f"{100.0 * required:.0f} % required"
            )
        if low <= 0.0:
            return f"uncertain: the gain's 5 % bound is {100.0 * low:z.0f} %"
        worth = np.sqrt(max(before**2 - after**2, 0.0))
        if worth < limits().least_force * force_rms:
            return (
                f"lowers the error by only {worth:.3g} N, less than {100.0 * limits().least_force:.3g} % of the force"
            )
        new = self.baseline.data.change * self._right(hypothesis)
        if new < limits().named:
            return (
                f"only {_below(new, limits().named)} % probable to be both new and right; "
                f"{100.0 * limits().named:.0f} % required"
            )
        confidence = self.confidence(hypothesis)
        # What a model lacks on the recordings of its identification may be added whatever its name.
        if self.baseline.data.change < 1.0 and confidence < limits().confident:
            return (
                f"a confidence of only {_below(confidence, limits().confident)} %; "
                f"{100.0 * limits().confident:.0f} % required"
            )
        return ""

    def tied(self, best: Hypothesis) -> tuple[str, ...]:
        """Other phenomena that these data cannot distinguish from the best, the most probable first."""
        order = sorted(self.probabilities, key=self.probabilities.__getitem__, reverse=True)
        others = [name for name in order if name != best.phenomenon and self.probabilities[name] >= limits().tied]
        return tuple(others[:MOST_TIED])

    def supported(self, force_rms: float) -> list[Hypothesis]:
        """The best hypothesis and the best ones that are tied with it, without those that the data do not support.

        A general effect, which can take most forms, does not stand for a tie.
        """
        if self.best is None:
            return []
        tied = (self.best_of(name) for name in self.tied(self.best))
        group = (self.best, *(one for one in tied if not one.effect.general))
        return [one for one in group if not self.reason_against(one, force_rms)]

    def probability(self, group: Sequence[str]) -> float:
        """That one of these phenomena is what is missing, if it is one of those that were tried."""
        return float(sum(self.probabilities.get(name, 0.0) for name in group))

    def confidence(self, hypothesis: Hypothesis) -> float:
        """Probability that the phenomenon of a finding, or one that is tied with it, is what is missing.

        Either something has changed since the model was identified, or the finding is in what the model always got
        wrong; of a usual error that nothing in particular accounts for, no effect predicts a share e on unseen data:

            1 - (1 - P(change)) (1 - e)
        """
        explained = np.clip(1.0 - hypothesis.evaluation.error, 0.0, 1.0)
        meant = 1.0 - (1.0 - self.baseline.data.change) * (1.0 - explained)
        return float(meant) * self._right(hypothesis)

    def _right(self, hypothesis: Hypothesis) -> float:
        """Probability of the tied group if something is missing.

        It includes that the true phenomenon is among those that were tried, with forms that resemble the damper's: on
        dampers of other physics that falls with what the best effect leaves unexplained.
        """
        explained = 1.0 - hypothesis.evaluation.error
        share = np.inf if hypothesis.name in self.constants else limits().form_share
        form = np.clip(share * explained, 0.0, limits().form_right)
        return float(form) * self.probability((hypothesis.phenomenon, *self.tied(hypothesis)))


def _below(gain: float, required: float) -> str:
    """A share in %, with a decimal where it would read as what is required."""
    text = f"{100.0 * gain:.0f}"
    return text if int(text) < round(100.0 * required) else f"{np.floor(1000.0 * gain) / 10.0:.1f}"


def round_of(baseline: Baseline, fitted: Sequence[Hypothesis], mode: str, jointly: bool = False) -> Round:
    """Evaluates the fitted hypotheses of one round; ``jointly`` refits the model with the best ones, where that is more
    than a first-order refit.
    """
    kept, refitted = without_effects(baseline)
    hypotheses = evaluated(baseline, [hypothesis for hypothesis in fitted if not hypothesis.fit.hidden], mode)
    if jointly and needs_joint_refit(baseline):
        refits = jointly_refitted(baseline, hypotheses)
        joint = {one.name: with_refitted(baseline.data, one, left, refitted) for one, left in refits}
        together = (min(joint.get(one.name, one), one, key=lambda either: either.score) for one in hypotheses)
        hypotheses = sorted(together, key=lambda one: one.score)
    tests = evaluated_tests(baseline, mode)
    return Round(
        baseline,
        tuple(_judged(hypothesis, tests) for hypothesis in hypotheses),
        tuple(hypothesis for hypothesis in fitted if hypothesis.fit.hidden),
        tuple(tests),
        kept,
        refitted,
        mode,
    )


def _judged(hypothesis: Hypothesis, tests: Sequence[TestEvaluation]) -> Hypothesis:
    """The hypothesis, without its exclusion if it explains clearly more than what it would imitate."""
    imitated = next((test.error for test in tests if test.test.name == hypothesis.imitates), 0.0)
    more = max(limits().gain * imitated, limits().own_part)
    if hypothesis.evaluation.error >= imitated - more:
        return hypothesis
    return replace(hypothesis, region=replace(hypothesis.region, excludes=None))
