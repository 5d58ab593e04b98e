"""What a diagnosis and an improvement say."""

from dataclasses import asdict, dataclass

import numpy as np

from damper_estimator.diagnosis.apply_finding import ModelState
from damper_estimator.diagnosis.atlas_curves import AtlasCurve
from damper_estimator.diagnosis.free_curve import FreeCurve
from damper_estimator.diagnosis.informative import Stretch
from damper_estimator.identification import FittedParameter
from damper_estimator.model import DamperModel, Element
from damper_estimator.signals import Measurement
from damper_estimator.signals.signal_map import DamperSignals
from damper_estimator.validation import DataFinding

VERDICTS = ("missing", "nothing_missing", "parameters_changed", "unexplained")


@dataclass(frozen=True)
class EvaluationSummary:
    """One evaluation of one hypothesis on unseen data.

    Attributes:
        rmse_n: N in band, the gauge's zero and drift of each recording taken out.
        gain: 1 - weighted squared error / that without the effect; may be negative.
        low, high: 5 and 95 % of the block bootstrap of the gain.
    """

    rmse_n: float
    gain: float
    low: float
    high: float


@dataclass(frozen=True)
class RankedEffect:
    """One hypothesis of one round.

    Attributes:
        kept, refitted: with the model's parameters as they are, and refitted together to first order; None if it was
            not evaluated so.
        reason: why it is not accepted, "" where it is.
        explains: per unseen recording (n,) N in band, what it would change of the force; empty for what explains
            next to nothing.
    """

    effect: str
    phenomenon: str
    kept: EvaluationSummary | None
    refitted: EvaluationSummary | None
    parameters: tuple[FittedParameter, ...]
    reason: str
    explains: tuple[np.ndarray, ...] = ()

    def record(self) -> dict[str, object]:
        """For JSON."""
        return {
            "effect": self.effect,
            "phenomenon": self.phenomenon,
            "reason": self.reason,
            "kept": None if self.kept is None else asdict(self.kept),
            "refitted": None if self.refitted is None else asdict(self.refitted),
        }


@dataclass(frozen=True)
class Finding:
    """An effect that is missing, as far as these data show it.

    Attributes:
        tied_with: other phenomena that these data cannot distinguish from it.
        rmse_before_n, rmse_after_n: on unseen data.
        share_of_explainable_error: (MSE before - MSE after) / (MSE before - floor^2).
        confidence: probability that what is missing is in the tied group, errors of form included.
        gain, low, high: as in ``EvaluationSummary``.
        evidence, test_to_separate: in words.
        remark: where kept and refitted parameters disagree, else "".
        is_channel: a mistake of the measurement chain: it goes to the signal map.
        partner: phenomenon of another finding without which it explains little; the errors are then those before and
            after both. "" where it explains something by itself.
    """

    effect: str
    phenomenon: str
    tied_with: tuple[str, ...]
    rmse_before_n: float
    rmse_after_n: float
    share_of_explainable_error: float
    confidence: float
    gain: float
    low: float
    high: float
    evidence: str
    test_to_separate: str
    remark: str
    parameters: tuple[FittedParameter, ...]
    is_channel: bool
    partner: str = ""

    @property
    def fall(self) -> float:
        """By how much it lowers the mean squared error on unseen data, N^2."""
        return self.rmse_before_n**2 - self.rmse_after_n**2

    def record(self) -> dict[str, object]:
        """For JSON."""
        return asdict(self)


@dataclass(frozen=True)
class Moved:
    """A parameter that re-identification moves."""

    name: str
    unit: str
    before: float
    after: float
    standard_error: float


@dataclass(frozen=True)
class Structure:
    """Mean residual over a grid, what no effect accounts for.

    Attributes:
        axes: what lies along x and y, with units.
        x, y: (p + 1,), (q + 1,) edges, SI.
        mean_n: (q, p) N, NaN where nothing was driven.
        words: where it is largest.
    """

    axes: tuple[str, str]
    x: np.ndarray
    y: np.ndarray
    mean_n: np.ndarray
    words: str


@dataclass(frozen=True)
class AtlasRow:
    """A form-free test of the error: how much of it follows some variables, whatever the form.

    Attributes:
        test, shows: its name, and the variables in words.
        phenomena: that it represents.
        explains: share of the squared error on unseen data; may be negative.
        low, high: 5 and 95 % of its block bootstrap.
    """

    test: str
    phenomena: tuple[str, ...]
    shows: str
    explains: float
    low: float
    high: float


@dataclass(frozen=True)
class PhenomenonShare:
    """How well the best effect of one phenomenon explains the error of the model as given.

    Attributes:
        left: share of the squared error, geometric mean of fitted and unseen recordings, penalties included.
        probability: that it is this one, given that it is one of those that were tried.
    """

    phenomenon: str
    left: float
    probability: float


@dataclass(frozen=True)
class Diagnosis:
    """What is missing from a model, as far as these recordings show it.

    Attributes:
        model: as given, or identified first where it had no record of a fit.
        verdict: one of ``VERDICTS``.
        sentence: the verdict in one sentence.
        mode: both, kept or refit.
        rmse_n, force_rms_n, noise_floor_n: of the model as given, on unseen data.
        findings: accepted, best first.
        elements: of each finding, the entry with its fitted values.
        ranking: all hypotheses of the first round, best first.
        untestable: effects that could not be tried, with the reason.
        moved: parameters that re-identification moves, where that is enough.
        rmse_refit_alone_n: unseen error after re-identifying what is there.
        structure: of what is left, where nothing accounts for it.
        improved: the model with the damper's findings put in, as ``steps`` ends.
        signals: the damper's entry of the signal map with corrections of the measurement chain.
        data: mistakes of the recordings that show without any model.
        fit, unseen: what was used for what.
        steps: each finding with the model and its errors after it, in the order in which they are put in.
        atlas: what the form-free tests say of the error of the model as given, the one that explains most first.
        phenomena: all that were tried in the first round, the most probable first.
        identified: the model after it was identified first, where it had no record of a fit; else None.
        reference_n: unseen error of the form-free regression (``validation.form_free``): as much is explainable at
            least; a model of the right form may be better.
        stretches: of long recordings, what effects were fitted to and judged on; empty if they were used whole.
        curves: what the model as given lacks over each variable, given the others.
        free_curve: the model with a free curve of velocity, where the findings leave much, the curve leaves less, and
            the model was identified on these recordings; else None.
    """

    model: DamperModel
    verdict: str
    sentence: str
    mode: str
    rmse_n: float
    force_rms_n: float
    noise_floor_n: float
    findings: tuple[Finding, ...]
    elements: tuple[Element, ...]
    ranking: tuple[RankedEffect, ...]
    untestable: dict[str, str]
    moved: tuple[Moved, ...]
    rmse_refit_alone_n: float
    structure: Structure | None
    improved: DamperModel
    signals: DamperSignals
    data: tuple[DataFinding, ...]
    fit: tuple[Measurement, ...]
    unseen: tuple[Measurement, ...]
    steps: tuple[tuple[Finding, ModelState], ...] = ()
    atlas: tuple[AtlasRow, ...] = ()
    phenomena: tuple[PhenomenonShare, ...] = ()
    identified: ModelState | None = None
    reference_n: float = float("nan")
    stretches: tuple[Stretch, ...] = ()
    curves: tuple[AtlasCurve, ...] = ()
    free_curve: FreeCurve | None = None

    def record(self) -> dict[str, object]:
        """For JSON."""
        return {
            "verdict": self.verdict,
            "sentence": self.sentence,
            "mode": self.mode,
            "identified_first": self.identified is not None,
            "rmse_n": self.rmse_n,
            "force_rms_n": self.force_rms_n,
            "noise_floor_n": self.noise_floor_n,
            "reference_n": self.reference_n,
            "rmse_refit_alone_n": self.rmse_refit_alone_n,
            "findings": [finding.record() for finding in self.findings],
            "rejected": [
                *(ranked.record() for ranked in self.ranking if ranked.reason),
                *({"effect": name, "reason": reason} for name, reason in self.untestable.items()),
            ],
            "parameters_moved": [asdict(moved) for moved in self.moved],
            "data_findings": [asdict(finding) for finding in self.data],
            "atlas": [asdict(row) for row in self.atlas],
            "atlas_curves": [curve.record() for curve in self.curves],
            "phenomena": [asdict(one) for one in self.phenomena],
            "stretches": [asdict(one) for one in self.stretches],
            "structure": None if self.structure is None else self.structure.words,
            "free_curve": None if self.free_curve is None else self.free_curve.record(),
        }
