"""Identification: the parameters with which a model agrees best with what was measured, and how far to trust them."""

from damper_estimator.identification.fit import Fit, FittedParameter, fit
from damper_estimator.identification.methods.contract import all_methods
from damper_estimator.identification.problem import Point, Problem
from damper_estimator.identification.rows import pooled_error, rows_of, usable
from damper_estimator.identification.selection import free_slots

__all__ = [
    "Fit",
    "FittedParameter",
    "Point",
    "Problem",
    "all_methods",
    "fit",
    "free_slots",
    "pooled_error",
    "rows_of",
    "usable",
]
