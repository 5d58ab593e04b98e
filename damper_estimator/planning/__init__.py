"""Which test tells tied explanations apart: rigs and their limits, steps to drive, the criterion, the search."""

from damper_estimator.planning.limits import Limits, limits_of
from damper_estimator.planning.motions import KINDS, acceleration_of, motion, speed_of
from damper_estimator.planning.plan import LONGEST, plan
from damper_estimator.planning.result import HOPELESS, LIKELY, SURE, Curve, Plan, Sharpened
from damper_estimator.planning.rig import Manoeuvre, Rig, library_rigs, load_rig, parse_rig
from damper_estimator.planning.steps import Step, steps_of
from damper_estimator.planning.written import drive_csv, plan_yaml

__all__ = [
    "HOPELESS",
    "KINDS",
    "LIKELY",
    "LONGEST",
    "SURE",
    "Curve",
    "Limits",
    "Manoeuvre",
    "Plan",
    "Rig",
    "Sharpened",
    "Step",
    "acceleration_of",
    "drive_csv",
    "library_rigs",
    "limits_of",
    "load_rig",
    "motion",
    "parse_rig",
    "plan",
    "plan_yaml",
    "speed_of",
    "steps_of",
]
