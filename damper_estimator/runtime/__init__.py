"""Turns samples into estimates, live and offline: admission, filter, slow channels, model, status."""

from damper_estimator.runtime.damper_record import (
    BY_STATUS,
    COUNTS,
    DEGRADED,
    EXTRAPOLATING,
    GOOD,
    IMPLAUSIBLE,
    JUMPS,
    LATE,
    NOT_FINITE,
    REGION_ROWS,
    SILENT,
    SLOW,
    STALE,
    STUCK,
    SUSPECT,
    UNKNOWN,
    WARMING_UP,
)
from damper_estimator.runtime.deployed import Deployed, deployed
from damper_estimator.runtime.estimates import FIELDS, Estimates
from damper_estimator.runtime.estimator import DamperEstimator, HeldValues
from damper_estimator.runtime.line import Line
from damper_estimator.runtime.line_arrays import ABSENT, LineInput, LineOutput
from damper_estimator.runtime.line_warmup import compile_line_ahead
from damper_estimator.runtime.residual import ResidualLine, Residuals
from damper_estimator.runtime.vehicle import Arrivals, ForceMessages, SampleAndHold, VehicleLine, group_equal_keys

__all__ = [
    "ABSENT",
    "BY_STATUS",
    "COUNTS",
    "DEGRADED",
    "EXTRAPOLATING",
    "FIELDS",
    "GOOD",
    "IMPLAUSIBLE",
    "JUMPS",
    "LATE",
    "NOT_FINITE",
    "REGION_ROWS",
    "SILENT",
    "SLOW",
    "STALE",
    "STUCK",
    "SUSPECT",
    "UNKNOWN",
    "WARMING_UP",
    "Arrivals",
    "DamperEstimator",
    "Deployed",
    "Estimates",
    "ForceMessages",
    "HeldValues",
    "Line",
    "LineInput",
    "LineOutput",
    "ResidualLine",
    "Residuals",
    "SampleAndHold",
    "VehicleLine",
    "compile_line_ahead",
    "deployed",
    "group_equal_keys",
]
