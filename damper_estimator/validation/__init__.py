"""How far a model can be trusted: error measures, where it fails, what the data allow."""

from damper_estimator.validation.comparison import Comparison, compare, per_recording
from damper_estimator.validation.finding import DataFinding
from damper_estimator.validation.findings import data_findings
from damper_estimator.validation.measures import Measures, measures
from damper_estimator.validation.quality import DataQuality
from damper_estimator.validation.regions import Region
from damper_estimator.validation.trace import Trace

__all__ = [
    "Comparison",
    "DataFinding",
    "DataQuality",
    "Measures",
    "Region",
    "Trace",
    "compare",
    "data_findings",
    "measures",
    "per_recording",
]
