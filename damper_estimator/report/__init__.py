"""Figures, tables and self-contained pages that open without a network."""

from damper_estimator.report.characteristic_page import characteristic_page, loops_over_velocity
from damper_estimator.report.comparison_page import Section, comparison_page, damper_section
from damper_estimator.report.curve_figures import command_unit, curves_figure
from damper_estimator.report.decimation import min_max_rows
from damper_estimator.report.diagnosis_page import DiagnosisSection, diagnosis_page, diagnosis_section
from damper_estimator.report.diagnosis_wording import correction_rows, plain_name, step_name
from damper_estimator.report.forces import estimates_figure, forces_figure, plotly_figure
from damper_estimator.report.front_page import front_page
from damper_estimator.report.import_page import column_rows, import_figures, import_page
from damper_estimator.report.improvement_page import improvement_page, improvement_section
from damper_estimator.report.page import plotly_from, save_plotly
from damper_estimator.report.plan_page import plan_figure, plan_page
from damper_estimator.report.ride_page import ride_figure, ride_page
from damper_estimator.report.story_page import Story, story_page
from damper_estimator.report.verdict_figures import ranking_figure, waterfall_figure

__all__ = [
    "DiagnosisSection",
    "Section",
    "Story",
    "characteristic_page",
    "column_rows",
    "command_unit",
    "comparison_page",
    "correction_rows",
    "curves_figure",
    "damper_section",
    "diagnosis_page",
    "diagnosis_section",
    "estimates_figure",
    "forces_figure",
    "front_page",
    "import_figures",
    "import_page",
    "improvement_page",
    "improvement_section",
    "loops_over_velocity",
    "min_max_rows",
    "plain_name",
    "plan_figure",
    "plan_page",
    "plotly_figure",
    "plotly_from",
    "ranking_figure",
    "ride_figure",
    "ride_page",
    "save_plotly",
    "step_name",
    "story_page",
    "waterfall_figure",
]
