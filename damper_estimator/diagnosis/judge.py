"""Judges attempts on unseen data: squared errors by blocks of a second, which the bootstrap draws.

Residuals are autocorrelated, so single samples are no independent witnesses.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.diagnosis.atlas_terms import Test
from damper_estimator.diagnosis.attempt import Attempt
from damper_estimator.diagnosis.null import Null, first_order
from damper_estimator.diagnosis.scene import unweighted
from damper_estimator.diagnosis.thresholds import limits
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
class Tally:
    """One attempt judged both ways.

    Attributes:
        kept, refitted: what is left with the model's parameters as they are, and refitted to first order.
        kept_gains, refitted_gains: (replicates,) gain against the model without the effect, judged the same way.
        left_unseen, left_fit: shares of the squared error without the effect that are left, as attempts are ranked.
    """

    attempt: Attempt
    kept: Errors
    refitted: Errors
    kept_gains: np.ndarray
    refitted_gains: np.ndarray
    left_unseen: float
    left_fit: float

    @property
    def error(self) -> float:
        """Share of the squared error that is left, geometric mean of both parts: an effect may show little on the
        recordings that happen to be unseen.
        """
        return float(np.sqrt(self.left_unseen * self.left_fit))

    @property
    def score(self) -> float:
        """Smaller is better."""
        return self.error + limits().penalty * self.attempt.size + limits().at_bound * bool(self.attempt.at_bound)


@dataclass(frozen=True)
class Shown:
    """One form-free test, judged as the round judges.

    Attributes:
        size: number of its columns.
        left: what is left after it.
        gains: (replicates,) gain against the model without it.
        left_unseen, left_fit: shares of the squared error without it that are left.
    """

    test: Test
    size: int
    left: Errors
    gains: np.ndarray
    left_unseen: float
    left_fit: float

    @property
    def error(self) -> float:
        """Share of the squared error that is left, geometric mean of both parts."""
        return float(np.sqrt(self.left_unseen * self.left_fit))


def shown(null: Null, mode: str) -> list[Shown]:
    """Every test that the recordings allow, judged."""
    without = nothing(null)[int(mode == "refit")]
    drawn = block_draws(without.blocks.size)
    base = (null.base_fit, null.base_unseen) if mode == "refit" else (null.base_fit[:, :0], null.base_unseen[:, :0])
    judged = []
    for one in null.tests:
        columns = (np.hstack([null.found_fit, base[0], one.fit]), np.hstack([null.found_unseen, base[1], one.unseen]))
        left = errors(null.scene.blocks, *first_order(null.residual_fit, columns[0], null.residual_unseen, columns[1]))
        judged.append(Shown(one.test, one.fit.shape[1], left, gains(drawn, left, without), *_left(left, without)))
    return judged


def errors(blocks: np.ndarray, fit: np.ndarray, unseen: np.ndarray) -> Errors:
    """Errors with their sums over blocks (r,) int."""
    return Errors(fit, unseen, np.bincount(blocks, unseen**2))


def nothing(null: Null) -> tuple[Errors, Errors]:
    """What is left without any effect: kept, and refitted to first order."""
    blocks = null.scene.blocks
    kept = first_order(null.residual_fit, null.found_fit, null.residual_unseen, null.found_unseen)
    free_fit = np.hstack([null.found_fit, null.base_fit])
    free_unseen = np.hstack([null.found_unseen, null.base_unseen])
    refitted = first_order(null.residual_fit, free_fit, null.residual_unseen, free_unseen)
    return _sane(errors(blocks, *kept), errors(blocks, *refitted))


def _sane(kept: Errors, refitted: Errors) -> tuple[Errors, Errors]:
    """Both, where derivatives lead astray twice the kept one: a refit that harms unseen data tells nothing."""
    return kept, refitted if refitted.square <= kept.square else kept


def with_effects(null: Null, attempts: Sequence[Attempt], base: bool) -> Errors:
    """What is left with effects added; ``base`` refits the model's parameters as well, to first order.

    A single effect with everything else kept is exact, all else is linear in the parameters.
    """
    fit = null.residual_fit + sum(a.change_fit for a in attempts)
    unseen = null.residual_unseen + sum(a.change_unseen for a in attempts)
    free_fit, free_unseen = [null.found_fit], [null.found_unseen]
    if base:
        free_fit.append(null.base_fit)
        free_unseen.append(null.base_unseen)
    if base or len(attempts) > 1 or null.found_fit.shape[1]:
        free_fit += [a.own_fit for a in attempts]
        free_unseen += [a.own_unseen for a in attempts]
    return errors(null.scene.blocks, *first_order(fit, np.hstack(free_fit), unseen, np.hstack(free_unseen)))


def tallies(null: Null, attempts: Sequence[Attempt], mode: str) -> list[Tally]:
    """All attempts judged, best first; ``mode`` is both, kept or refit."""
    without_kept, without_refitted = nothing(null)
    drawn = block_draws(without_kept.blocks.size)
    judged = []
    for attempt in attempts:
        kept, refitted = _sane(with_effects(null, [attempt], base=False), with_effects(null, [attempt], base=True))
        judged.append(
            Tally(
                attempt,
                kept,
                refitted,
                gains(drawn, kept, without_kept),
                gains(drawn, refitted, without_refitted),
                *(_left(refitted, without_refitted) if mode == "refit" else _left(kept, without_kept)),
            )
        )
    return sorted(judged, key=lambda tally: tally.score)


def _left(errors: Errors, without: Errors) -> tuple[float, float]:
    """Shares of the squared error that are left, unseen and fit."""
    before = float(np.sum(without.fit**2))
    return errors.square / max(without.square, 1e-300), float(np.sum(errors.fit**2)) / max(before, 1e-300)


def gains(drawn: np.ndarray, errors: Errors, without: Errors) -> np.ndarray:
    """(replicates,) 1 - error / error without."""
    return 1.0 - (drawn @ errors.blocks) / np.maximum(drawn @ without.blocks, 1e-300)


def rmse(null: Null, errors: Errors) -> float:
    """Unseen error in N, unweighted."""
    return unweighted(null.scene.unseen, errors.unseen)
