"""One round: which attempt explains most, how sure that is, and what else it could be."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.diagnosis.attempt import Attempt, Null
from damper_estimator.diagnosis.candidates import Candidate
from damper_estimator.diagnosis.judge import (
    HIGH,
    LOW,
    PENALTY,
    Errors,
    Tally,
    gains,
    nothing,
    rmse,
    tallies,
    with_effects,
)
from damper_estimator.numerics import block_draws

GAIN = 0.25  # of the squared error: what an effect must explain to be found
LEAST_FORCE = 0.015  # of the force's rms: what it must be worth
SECOND_OPINION = 0.85  # of the error may be left, geometric mean of kept and refitted
GENERAL_MARGIN = 0.05  # of the error: what a general explanation must be better by than a specific one
MOST_TIED = 3  # others
_ADDS = 0.01  # of the error: what adds less adds nothing
_CLOSE = 0.06  # of the error
_MUCH = 1.5  # times what the model's own identification left
_BEHIND = 0.15  # of the error: an explanation that is worse by more is no tie


@dataclass(frozen=True)
class Round:
    """All attempts on one model.

    Attributes:
        null: the model that effects were added to.
        candidates: by effect's name.
        tallies: best first, those whose force the freed zero of the gauge does not hide.
        hidden: names of those that it hides.
        kept, refitted: what is left without any effect.
    """

    null: Null
    candidates: dict[str, Candidate]
    tallies: tuple[Tally, ...]
    hidden: tuple[str, ...]
    kept: Errors
    refitted: Errors
    mode: str

    @property
    def best(self) -> Tally | None:
        """The explanation that comes first: a general one only where it is clearly better than every specific one."""
        if not self.tallies:
            return None
        first = self.tallies[0]
        specific = [t for t in self.tallies if not self._general(t)]
        if self._general(first) and specific and specific[0].score <= first.score + GENERAL_MARGIN:
            return specific[0]
        return first

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
        if gain < GAIN:
            return f"explains {100.0 * gain:.0f} % of the squared error on unseen data; {100.0 * GAIN:.0f} % are wanted"
        if low <= 0.0:
            return f"not sure: the gain's 5 % bound is {100.0 * low:.0f} %"
        worth = np.sqrt(max(before**2 - after**2, 0.0))
        if worth < LEAST_FORCE * force_rms:
            return f"worth {worth:.3g} N only, less than {100.0 * LEAST_FORCE:.3g} % of the force"
        if self.mode == "both":
            left = tally.kept.square / max(self.kept.square, 1e-300)
            refitted = tally.refitted.square / max(self.refitted.square, 1e-300)
            if np.sqrt(left * refitted) > SECOND_OPINION:
                return "refitting the parameters that are there explains as much"
        return ""

    def tied(self, best: Tally) -> tuple[str, ...]:
        """Other phenomena that these data cannot tell from the best: they explain about as much, be it in some of the
        bootstrap's replicates, or the best adds nothing where one of them is in.
        """
        names: list[str] = []
        rivals = [t for t in self.tallies if t.attempt.phenomenon != best.attempt.phenomenon]
        drawn = block_draws(self.kept.blocks.size)
        for rival in rivals:
            if rival.attempt.phenomenon in names or len(names) >= MOST_TIED:
                continue
            # A general explanation contains the specific ones: that they do not add to it says nothing.
            if self._general(rival) and not self._general(best):
                continue
            if rival.error > best.error + _BEHIND * (1.0 - best.error) or 1.0 - rival.error < GAIN:
                continue
            if self._as_good(best, rival) or self._disputed(best, rival):
                names.append(rival.attempt.phenomenon)
                continue
            both = with_effects(self.null, [best.attempt, rival.attempt], base=self.refits)
            alone = with_effects(self.null, [rival.attempt], base=self.refits)
            adds = gains(drawn, both, self.without) - gains(drawn, alone, self.without)
            if np.percentile(adds, LOW) < _ADDS:
                names.append(rival.attempt.phenomenon)
        return tuple(names)

    def _as_good(self, best: Tally, rival: Tally) -> bool:
        own, other = self._errors(best), self._errors(rival)
        return rival.error - best.error < _ADDS or float(np.mean(other <= own)) > LOW / 100.0

    def _errors(self, tally: Tally) -> np.ndarray:
        """(replicates,) of what ``error`` is, the unseen part drawn anew."""
        return np.sqrt(np.maximum(1.0 - self.replicates(tally), 0.0) * tally.left_fit)

    def _disputed(self, best: Tally, rival: Tally) -> bool:
        """Whether the two are close with the model's parameters kept, and change places when they are refitted.

        Only while much is left: of a residual that the model always had, the order tells nothing.
        """
        close = rival.error <= best.error + _CLOSE
        turned = rival.refitted.square < best.refitted.square
        usual = float(self.null.model.fit.get("residual_stddev", 0.0) or 0.0)
        much = rmse(self.null, best.refitted) > _MUCH * usual
        return self.mode == "both" and close and turned and much

    def confidence(self, group: Sequence[str]) -> float:
        """Share of the bootstrap's replicates in which one of these phenomena comes first."""
        scores = np.array([self._errors(t) + PENALTY * t.attempt.size for t in self.tallies])
        scores += np.array([GENERAL_MARGIN * self._general(t) for t in self.tallies])[:, None]
        first = np.argmin(scores, axis=0)
        inside = np.array([t.attempt.phenomenon in group for t in self.tallies])
        return float(inside[first].mean())


def round_of(null: Null, candidates: Sequence[Candidate], attempts: Sequence[Attempt], mode: str) -> Round:
    """Judges the attempts of one round."""
    kept, refitted = nothing(null)
    shown = [a for a in attempts if not a.hidden]
    return Round(
        null,
        {c.effect.name: c for c in candidates},
        tuple(tallies(null, shown, mode)),
        tuple(a.effect for a in attempts if a.hidden),
        kept,
        refitted,
        mode,
    )
