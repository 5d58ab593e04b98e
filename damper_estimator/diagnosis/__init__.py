"""Which physical effect a model lacks, how sure that is, and what else it could be."""

from damper_estimator.diagnosis.diagnose import diagnose
from damper_estimator.diagnosis.hypotheses import Explanations, Hypothesis, explanations, sensitivities
from damper_estimator.diagnosis.improve import improve
from damper_estimator.diagnosis.misfit import with_misfit
from damper_estimator.diagnosis.result import (
    AtlasRow,
    Diagnosis,
    Finding,
    Improvement,
    Judged,
    Judgement,
    Moved,
    Step,
    Structure,
)
from damper_estimator.diagnosis.thresholds import limits

__all__ = [
    "AtlasRow",
    "Diagnosis",
    "Explanations",
    "Finding",
    "Hypothesis",
    "Improvement",
    "Judged",
    "Judgement",
    "Moved",
    "Step",
    "Structure",
    "diagnose",
    "explanations",
    "improve",
    "limits",
    "sensitivities",
    "with_misfit",
]
