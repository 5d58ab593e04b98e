"""Which physical effect a model lacks, how sure that is, and what else it could be."""

from damper_estimator.diagnosis.acceleration_templates import Template
from damper_estimator.diagnosis.atlas_curves import AtlasCurve
from damper_estimator.diagnosis.atlas_terms import TESTS
from damper_estimator.diagnosis.by_recording import by_recording, independent
from damper_estimator.diagnosis.correction import corrected, corrected_signals, in_yaml
from damper_estimator.diagnosis.diagnose import MODES, diagnose
from damper_estimator.diagnosis.diagnosis_data import ranges_of
from damper_estimator.diagnosis.division import all_divided
from damper_estimator.diagnosis.fitted_explanations import (
    Explanations,
    FittedExplanation,
    explanations,
    sensitivities,
)
from damper_estimator.diagnosis.improve import improve
from damper_estimator.diagnosis.improvement import Improvement, Step
from damper_estimator.diagnosis.local_fit import locally_fitted
from damper_estimator.diagnosis.misfit import with_misfit
from damper_estimator.diagnosis.phenomenon_scores import general_margin
from damper_estimator.diagnosis.result import (
    AtlasRow,
    Diagnosis,
    EvaluationSummary,
    Finding,
    Moved,
    RankedEffect,
    Structure,
)
from damper_estimator.diagnosis.thresholds import limits

__all__ = [
    "MODES",
    "TESTS",
    "AtlasCurve",
    "AtlasRow",
    "Diagnosis",
    "EvaluationSummary",
    "Explanations",
    "Finding",
    "FittedExplanation",
    "Improvement",
    "Moved",
    "RankedEffect",
    "Step",
    "Structure",
    "Template",
    "all_divided",
    "by_recording",
    "corrected",
    "corrected_signals",
    "diagnose",
    "explanations",
    "general_margin",
    "improve",
    "in_yaml",
    "independent",
    "limits",
    "locally_fitted",
    "ranges_of",
    "sensitivities",
    "with_misfit",
]
