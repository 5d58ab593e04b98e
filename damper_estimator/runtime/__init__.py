"""What turns samples into estimates, live and off line: admission, filter, slow channels, model, status."""

from damper_estimator.runtime.deployed import Deployed, deployed
from damper_estimator.runtime.estimates import FIELDS, Estimates
from damper_estimator.runtime.estimator import DamperEstimator, Held
from damper_estimator.runtime.line import Line
from damper_estimator.runtime.messages import ABSENT, Answered, Arrived
from damper_estimator.runtime.record import (
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
    WARMING_UP,
)
from damper_estimator.runtime.residual import ResidualLine, Residuals
from damper_estimator.runtime.vehicle import Arrivals, ForceMessages, HeldChannel, VehicleLine, together

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
    "WARMING_UP",
    "Answered",
    "Arrivals",
    "Arrived",
    "DamperEstimator",
    "Deployed",
    "Estimates",
    "ForceMessages",
    "Held",
    "HeldChannel",
    "Line",
    "ResidualLine",
    "Residuals",
    "VehicleLine",
    "deployed",
    "together",
]
