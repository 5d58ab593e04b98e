"""Evaluates hypotheses on unseen data: squared errors by blocks of a second, which the bootstrap draws.

Residuals are autocorrelated, so that neighbouring samples are not independent.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from damper_estimator.diagnosis.atlas_terms import Test
from damper_estimator.diagnosis.baseline import Baseline, first_order
from damper_estimator.diagnosis.diagnosis_data import DiagnosisData, unweighted
from damper_estimator.diagnosis.hypotheses import Hypothesis
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.diagnosis.trial_fit import TrialFit
from damper_estimator.numerics import block_draws

LOW, HIGH = 5.0, 95.0  # percentiles


@dataclass(frozen=True)
class Errors:
    """What is left after one way of adding an effect.

    Attributes:
        fit, unseen: (r,) rows.
        blocks: (b,) sum of squares of the unseen rows in each block.
    """

    fit: np.ndarray
    unseen: np.ndarray
    blocks: np.ndarray

    @property
    def square(self) -> float:
        """Sum of squares, unseen."""
        return float(self.blocks.sum())


@dataclass(frozen=True)
class Remaining:
    """The share of the squared error that is left, as a round ranks.

    Attributes:
        error: geometric mean of both parts, because an effect may show little on what happens to be unseen; in each the
            recordings judge one by one.
        drawn: (replicates,) the same with the unseen part drawn again.
        unseen: of the unseen part, all recordings together.
        worsened: weight of the recordings that are worse than without; the smaller of both parts, so that one recording
            on its own contradicts nothing.
    """

    error: float
    drawn: np.ndarray
    unseen: float
    worsened: float = 0.0


@dataclass(frozen=True)
class Evaluation:
    """What is left with one hypothesis, evaluated both ways.

    Attributes:
        kept, refitted: what is left with the model's parameters as they are, and refitted to first order.
        kept_gains, refitted_gains: (replicates,) gain against the model without the effect, evaluated the same way.
        remaining: of the error without the effect, as the round ranks.
        own_expected, own_found: shares of the squared error that its own part should explain, and explains
            (``_own_part``).
    """

    kept: Errors
    refitted: Errors
    kept_gains: np.ndarray
    refitted_gains: np.ndarray
    remaining: Remaining
    own_expected: float = 0.0
    own_found: float = 0.0

    @property
    def error(self) -> float:
        """Share of the squared error that is left, as the round ranks."""
        return self.remaining.error

    @property
    def imitates_change(self) -> bool:
        """Whether it explains only what other values of the model's parameters explain as well; a small part of its own
        shows nothing.
        """
        shows = self.own_expected >= limits().own_part
        return shows and self.own_found < limits().own_found * self.own_expected


@dataclass(frozen=True)
class TestEvaluation:
    """One form-free test, evaluated as the round evaluates.

    Attributes:
        size: number of its columns.
        left: what is left after it.
        gains: (replicates,) gain against the model without it.
        remaining: of the error without it.
    """

    test: Test
    size: int
    left: Errors
    gains: np.ndarray
    remaining: Remaining

    @property
    def error(self) -> float:
        """Share of the squared error that is left."""
        return self.remaining.error


def evaluated_tests(baseline: Baseline, mode: str) -> list[TestEvaluation]:
    """Every test that the recordings allow."""
    without = without_effects(baseline)[int(mode == "refit")]
    drawn = block_draws(without.blocks.size)
    refitted = slice(None if mode == "refit" else 0)
    found = []
    for one in baseline.tests:
        fit = np.hstack([baseline.found_fit, baseline.base_fit[:, refitted], one.fit])
        unseen = np.hstack([baseline.found_unseen, baseline.base_unseen[:, refitted], one.unseen])
        left = errors(baseline.data.blocks, *first_order(baseline.residual_fit, fit, baseline.residual_unseen, unseen))
        remaining = remaining_of(baseline.data, left, without, drawn)
        found.append(TestEvaluation(one.test, one.fit.shape[1], left, gains(drawn, left, without), remaining))
    return found


def errors(blocks: np.ndarray, fit: np.ndarray, unseen: np.ndarray) -> Errors:
    """Errors with their sums over blocks (r,) int."""
    return Errors(fit, unseen, np.bincount(blocks, unseen**2))


def without_effects(baseline: Baseline) -> tuple[Errors, Errors]:
    """What is left without any effect: kept, and refitted to first order."""
    blocks = baseline.data.blocks
    residuals = baseline.residual_fit, baseline.residual_unseen
    kept = first_order(residuals[0], baseline.found_fit, residuals[1], baseline.found_unseen)
    free_fit, free_unseen = _free_columns(baseline)
    refitted = first_order(residuals[0], free_fit, residuals[1], free_unseen)
    return _harmless(errors(blocks, *kept), errors(blocks, *refitted))


def _free_columns(baseline: Baseline) -> tuple[np.ndarray, np.ndarray]:
    """(r, k) of both parts: derivatives by all parameters that a refit moves."""
    return (
        np.hstack([baseline.found_fit, baseline.base_fit]),
        np.hstack([baseline.found_unseen, baseline.base_unseen]),
    )


def _harmless(kept: Errors, refitted: Errors) -> tuple[Errors, Errors]:
    """Both, where derivatives mislead twice the kept one: a refit that harms unseen data says nothing."""
    return kept, refitted if refitted.square <= kept.square else kept


def with_effects(baseline: Baseline, fits: Sequence[TrialFit], base: bool) -> Errors:
    """What is left with effects added; ``base`` refits the model's parameters as well, to first order.

    A single effect with everything else kept is exact, all else is linear in the parameters.
    """
    fit = baseline.residual_fit + sum(one.change_fit for one in fits)
    unseen = baseline.residual_unseen + sum(one.change_unseen for one in fits)
    free_fit, free_unseen = [baseline.found_fit], [baseline.found_unseen]
    if base:
        free_fit.append(baseline.base_fit)
        free_unseen.append(baseline.base_unseen)
    if base or len(fits) > 1 or baseline.found_fit.shape[1]:
        free_fit += [one.derivatives_fit for one in fits]
        free_unseen += [one.derivatives_unseen for one in fits]
    return errors(baseline.data.blocks, *first_order(fit, np.hstack(free_fit), unseen, np.hstack(free_unseen)))


def evaluated(baseline: Baseline, hypotheses: Sequence[Hypothesis], mode: str) -> list[Hypothesis]:
    """All fitted hypotheses with their evaluation, best first; ``mode`` is both, kept or refit."""
    without, free = without_effects(baseline), _free_columns(baseline)
    drawn = block_draws(without[0].blocks.size)
    ranked_by = int(mode == "refit")
    found = []
    for hypothesis in hypotheses:
        left = _harmless(*(with_effects(baseline, [hypothesis.fit], base) for base in (False, True)))
        gained = (gains(drawn, one, before) for one, before in zip(left, without, strict=True))
        remaining = remaining_of(baseline.data, left[ranked_by], without[ranked_by], drawn)
        own = _own_part(hypothesis.fit, free, left, without) if ranked_by == 0 else (0.0, 0.0)
        evaluation = Evaluation(*left, *gained, remaining, *own)
        found.append(replace(hypothesis, evaluation=evaluation))
    return sorted(found, key=lambda hypothesis: hypothesis.score)


def _own_part(
    fit: TrialFit, free: tuple[np.ndarray, np.ndarray], left: tuple[Errors, Errors], without: tuple[Errors, Errors]
) -> tuple[float, float]:
    """The shares of the squared error that the part which only an effect can change should explain, and explains,
    beyond the model's refitted parameters.

    Of its change d, the parameters can make a part as well, to first order. If the effect is what is missing, the rest
    o explains

        expected = gain |o|^2 / |d|^2
    """
    (kept, refitted), (kept_without, refitted_without) = left, without
    whole = max(kept_without.square, 1e-300)
    gain = max(1.0 - kept.square / whole, 0.0)
    found = (refitted_without.square - refitted.square) / whole
    if gain == 0.0:
        return 0.0, found
    changes = fit.change_fit, fit.change_unseen
    own = first_order(changes[0], free[0], changes[1], free[1])
    shares = (np.sum(part**2) / max(np.sum(d**2), 1e-300) for part, d in zip(own, changes, strict=True))
    return gain * float(min(*shares, 1.0)), found


def with_refitted(data: DiagnosisData, hypothesis: Hypothesis, left: Errors, without: Errors) -> Hypothesis:
    """A hypothesis whose refit with the model leaves ``left``, where refitted errors rank."""
    before, drawn = hypothesis.evaluation, block_draws(without.blocks.size)
    remaining = remaining_of(data, left, without, drawn)
    evaluation = Evaluation(before.kept, left, before.kept_gains, gains(drawn, left, without), remaining)
    return replace(hypothesis, evaluation=evaluation)


def remaining_of(data: DiagnosisData, errors: Errors, without: Errors, drawn: np.ndarray | None = None) -> Remaining:
    """The share of the error ``without`` that ``errors`` are; the unseen part also as drawn (replicates, blocks)."""
    ignored = (limits().least_force * data.force_rms) ** 2
    fit, unseen = data.fit_recordings, data.unseen_recordings
    fit_sums = fit.squares(errors.fit), fit.squares(without.fit)
    after, before = (data.by_recording(one.blocks) for one in (errors, without))
    unseen_sums = after.sum(axis=0), before.sum(axis=0)
    of_fit, of_unseen = fit.left(*fit_sums, ignored), unseen.left(*unseen_sums, ignored)
    worsened = min(fit.worsened(*fit_sums, ignored), unseen.worsened(*unseen_sums, ignored))
    again = of_unseen[None] if drawn is None else unseen.left(drawn @ after, drawn @ before, ignored)
    whole = errors.square / max(without.square, 1e-300)
    return Remaining(float(np.sqrt(of_unseen * of_fit)), np.sqrt(again * of_fit), whole, worsened)


def gains(drawn: np.ndarray, errors: Errors, without: Errors) -> np.ndarray:
    """(replicates,) 1 - error / error without."""
    return 1.0 - (drawn @ errors.blocks) / np.maximum(drawn @ without.blocks, 1e-300)


def rmse(baseline: Baseline, errors: Errors) -> float:
    """Unseen error in N, unweighted."""
    return unweighted(baseline.data.unseen, errors.unseen)
