"""Identification: the parameters with which a model agrees best with what was measured, and how far to trust them."""

from damper_estimator.identification.excitations import named
from damper_estimator.identification.fit import Fit, FittedParameter, fit
from damper_estimator.identification.joint import JointFit, fit_joint, settings_by_channel
from damper_estimator.identification.local_rows import LocalRows
from damper_estimator.identification.methods.contract import MethodOptions, all_methods
from damper_estimator.identification.pareto_front import Front, load_front
from damper_estimator.identification.problem import Point, Problem
from damper_estimator.identification.rows import check_motion, pooled_error, rows_of, usable
from damper_estimator.identification.selection import free_slots

__all__ = [
    "Fit",
    "FittedParameter",
    "Front",
    "JointFit",
    "LocalRows",
    "MethodOptions",
    "Point",
    "Problem",
    "all_methods",
    "check_motion",
    "fit",
    "fit_joint",
    "free_slots",
    "load_front",
    "named",
    "pooled_error",
    "rows_of",
    "settings_by_channel",
    "usable",
]
