"""What people look at: figures, tables, and one self-contained page that opens without a network."""

from damper_estimator.report.comparison_page import Section, comparison_page, damper_section
from damper_estimator.report.decimation import min_max_rows

__all__ = ["Section", "comparison_page", "damper_section", "min_max_rows"]
