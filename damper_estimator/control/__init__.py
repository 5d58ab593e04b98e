"""Control of semi-active dampers: the inverse of a model, laws for the desired force, look-up tables.

inverse = InverseModel(model, (0.0, 2.0))
answer = inverse.solve(sample, wanted=800.0)      # current, force_min, force_max, dforce_dcurrent
"""

from damper_estimator.control.command_limits import usable_limits
from damper_estimator.control.corner import (
    Action,
    Command,
    ConstantCommand,
    CornerController,
    InverseCommand,
    TableCommand,
)
from damper_estimator.control.current_table import CurrentTable, load_table, table_from_samples
from damper_estimator.control.influence import checked_limits, influence
from damper_estimator.control.inverse import LEAD, Inverse, InverseModel
from damper_estimator.control.laws import LAWS, BodyVelocity, Law, groundhook, mixed, passive, skyhook

__all__ = [
    "LAWS",
    "LEAD",
    "Action",
    "BodyVelocity",
    "Command",
    "ConstantCommand",
    "CornerController",
    "CurrentTable",
    "Inverse",
    "InverseCommand",
    "InverseModel",
    "Law",
    "TableCommand",
    "checked_limits",
    "groundhook",
    "influence",
    "load_table",
    "mixed",
    "passive",
    "skyhook",
    "table_from_samples",
    "usable_limits",
]
