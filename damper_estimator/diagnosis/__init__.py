"""Which physical effect a model lacks, how sure that is, and what else it could be."""

from damper_estimator.diagnosis.diagnose import diagnose
from damper_estimator.diagnosis.improve import improve
from damper_estimator.diagnosis.result import Diagnosis, Finding, Improvement, Judged, Judgement, Moved, Step, Structure

__all__ = [
    "Diagnosis",
    "Finding",
    "Improvement",
    "Judged",
    "Judgement",
    "Moved",
    "Step",
    "Structure",
    "diagnose",
    "improve",
]
