"""What people look at: figures, tables, and one self-contained page that opens without a network."""

from damper_estimator.report.comparison_page import Section, comparison_page, damper_section
from damper_estimator.report.decimation import min_max_rows
from damper_estimator.report.diagnosis_page import DiagnosisSection, diagnosis_page, diagnosis_section
from damper_estimator.report.improvement_page import improvement_page, improvement_section

__all__ = [
    "DiagnosisSection",
    "Section",
    "comparison_page",
    "damper_section",
    "diagnosis_page",
    "diagnosis_section",
    "improvement_page",
    "improvement_section",
    "min_max_rows",
]
