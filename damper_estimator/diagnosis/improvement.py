"""What an improvement says."""

from dataclasses import dataclass

from damper_estimator.diagnosis.result import Diagnosis, RankedEffect
from damper_estimator.model import DamperModel
from damper_estimator.signals import Measurement
from damper_estimator.signals.signal_map import DamperSignals


@dataclass(frozen=True)
class Step:
    """One step of an improvement.

    Attributes:
        action: start, correct, refit, add or prune.
        effect, phenomenon: None for start and refit.
        model: after the step.
        rmse_fit_n, rmse_unseen_n: N in band.
        diagnosis: what was tried before this step; None where nothing was.
        note: in words.
        replaced: labels of the entries that the effect replaced in the model; none where it was added beside all.
    """

    action: str
    effect: str | None
    phenomenon: str | None
    model: DamperModel
    rmse_fit_n: float
    rmse_unseen_n: float
    diagnosis: Diagnosis | None
    note: str
    replaced: tuple[str, ...] = ()


@dataclass(frozen=True)
class Improvement:
    """A model with all that was missing and justified.

    Attributes:
        steps: the first is the model as given.
        verdict: of what is left after the last step.
        sentence: what happened, in one sentence.
        model, signals: the improved model, and the damper's entry of the signal map with corrections.
        rejected: hypotheses of the last round.
        first: the diagnosis of the model as given.
        final: the diagnosis that found nothing more.
    """

    steps: tuple[Step, ...]
    verdict: str
    sentence: str
    noise_floor_n: float
    model: DamperModel
    signals: DamperSignals
    rejected: tuple[RankedEffect, ...]
    fit: tuple[Measurement, ...]
    unseen: tuple[Measurement, ...]
    first: Diagnosis
    final: Diagnosis

    @property
    def reference_n(self) -> float:
        """Unseen error of the form-free regression, as in ``Diagnosis``."""
        return self.final.reference_n

    def record(self) -> dict[str, object]:
        """For JSON."""
        names = ("action", "effect", "phenomenon", "rmse_fit_n", "rmse_unseen_n", "note")
        return {
            "steps": [{name: getattr(step, name) for name in names} for step in self.steps],
            "verdict": self.verdict,
            "sentence": self.sentence,
            "noise_floor_n": self.noise_floor_n,
            "reference_n": self.reference_n,
            "rejected": [ranked.record() for ranked in self.rejected],
            "atlas_curves": [curve.record() for curve in self.final.curves],
        }
