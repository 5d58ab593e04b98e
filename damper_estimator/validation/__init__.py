"""How far a model can be trusted: error measures, where it fails, and what the data allow."""

from damper_estimator.validation.channel_quality import ChannelQuality, channel_quality
from damper_estimator.validation.comparison import Comparison, compare, per_recording
from damper_estimator.validation.data_quality import DataQuality
from damper_estimator.validation.finding import SPOILING, DataFinding
from damper_estimator.validation.findings import data_findings
from damper_estimator.validation.form_free import reference_error
from damper_estimator.validation.magnitudes import in_millimetres
from damper_estimator.validation.measures import Measures, measures
from damper_estimator.validation.regions import Region
from damper_estimator.validation.spectra import partial_coherence
from damper_estimator.validation.step_check import JudgedStep, step_check
from damper_estimator.validation.suitability import Excitation, Verdict, excitation, verdict
from damper_estimator.validation.trace import Trace
from damper_estimator.validation.velocity import velocity_agreement

__all__ = [
    "SPOILING",
    "ChannelQuality",
    "Comparison",
    "DataFinding",
    "DataQuality",
    "Excitation",
    "JudgedStep",
    "Measures",
    "Region",
    "Trace",
    "Verdict",
    "channel_quality",
    "compare",
    "data_findings",
    "excitation",
    "in_millimetres",
    "measures",
    "partial_coherence",
    "per_recording",
    "reference_error",
    "step_check",
    "velocity_agreement",
    "verdict",
]
