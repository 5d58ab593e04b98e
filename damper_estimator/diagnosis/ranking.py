"""One round: which attempt explains most, how sure that is, and what else it could be."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from damper_estimator.diagnosis.attempt import Attempt
from damper_estimator.diagnosis.candidates import Candidate
from damper_estimator.diagnosis.judge import (
    HIGH,
    LOW,
    Errors,
    Shown,
    Tally,
    nothing,
    rmse,
    shown,
    tallies,
)
from damper_estimator.diagnosis.null import Null
from damper_estimator.diagnosis.standing import Standing, probabilities, standings
from damper_estimator.diagnosis.thresholds import limits

MOST_TIED = 3  # others


@dataclass(frozen=True)
class Round:
    """All attempts on one model.

    Attributes:
        null: the model that effects were added to.
        candidates: by effect's name.
        tallies: best first, those whose force the freed zero of the gauge does not hide.
        hidden: names of those that it hides.
        tests: form-free tests of the same error.
        kept, refitted: what is left without any effect.
    """

    null: Null
    candidates: dict[str, Candidate]
    tallies: tuple[Tally, ...]
    hidden: tuple[str, ...]
    tests: tuple[Shown, ...]
    kept: Errors
    refitted: Errors
    mode: str

    @cached_property
    def standings(self) -> list[Standing]:
        """All phenomena, the one that explains most first."""
        effects = {name: candidate.effect for name, candidate in self.candidates.items()}
        return standings(self.tallies, self.tests, effects, self.replicates)

    @cached_property
    def probabilities(self) -> dict[str, float]:
        """Of each phenomenon, given that what is missing is one of them."""
        return probabilities(self.standings)

    @property
    def best(self) -> Tally | None:
        """The effect that comes first: of the phenomenon that explains most, the one with the smallest score."""
        if not self.standings:
            return self.tallies[0] if self.tallies else None
        return self.best_of(max(self.probabilities, key=self.probabilities.__getitem__))

    def best_of(self, phenomenon: str) -> Tally:
        """The effect that explains most in the way of one phenomenon."""
        return next(t for t in self.tallies if t.attempt.phenomenon == phenomenon)

    def _general(self, tally: Tally) -> bool:
        return self.candidates[tally.attempt.effect].effect.general

    @property
    def refits(self) -> bool:
        """Whether the model is refitted, with every effect and without any, before errors are compared."""
        return self.mode == "refit"

    @property
    def without(self) -> Errors:
        """What is left without any effect, as this round judges."""
        return self.refitted if self.refits else self.kept

    def left(self, tally: Tally) -> Errors:
        """What is left with an effect, as this round judges."""
        return tally.refitted if self.refits else tally.kept

    def replicates(self, tally: Tally) -> np.ndarray:
        """(replicates,) gain of an effect, as this round judges."""
        return tally.refitted_gains if self.refits else tally.kept_gains

    def gain(self, tally: Tally) -> tuple[float, float, float]:
        """Gain on unseen data with the 5 and 95 % ends of its bootstrap, as this round judges."""
        low, high = np.percentile(self.replicates(tally), [LOW, HIGH])
        return 1.0 - self.left(tally).square / max(self.without.square, 1e-300), float(low), float(high)

    def reason_against(self, tally: Tally, force_rms: float) -> str:
        """Why the data do not support an effect by itself; "" where they do."""
        gain, low, _ = self.gain(tally)
        before, after = rmse(self.null, self.without), rmse(self.null, self.left(tally))
        if gain <= 0.02:
            return "explains nothing on unseen data"
        required = limits().gain
        if gain < required:
            return (
                f"explains {100.0 * gain:.0f} % of the squared error on unseen data; {100.0 * required:.0f} % required"
            )
        if low <= 0.0:
            return f"not sure: the gain's 5 % bound is {100.0 * low:.0f} %"
        worth = np.sqrt(max(before**2 - after**2, 0.0))
        if worth < limits().least_force * force_rms:
            return f"worth {worth:.3g} N only, less than {100.0 * limits().least_force:.3g} % of the force"
        return ""

    def tied(self, best: Tally) -> tuple[str, ...]:
        """Other phenomena that these data cannot tell from the best, the most probable first."""
        order = sorted(self.probabilities, key=self.probabilities.__getitem__, reverse=True)
        others = [
            name for name in order if name != best.attempt.phenomenon and self.probabilities[name] >= limits().tied
        ]
        return tuple(others[:MOST_TIED])

    def confidence(self, group: Sequence[str]) -> float:
        """Probability that one of these phenomena is what is missing."""
        return float(sum(self.probabilities.get(name, 0.0) for name in group))


def round_of(null: Null, candidates: Sequence[Candidate], attempts: Sequence[Attempt], mode: str) -> Round:
    """Judges the attempts of one round."""
    kept, refitted = nothing(null)
    visible = [a for a in attempts if not a.hidden]
    return Round(
        null,
        {c.effect.name: c for c in candidates},
        tuple(tallies(null, visible, mode)),
        tuple(a.effect for a in attempts if a.hidden),
        tuple(shown(null, mode)),
        kept,
        refitted,
        mode,
    )
