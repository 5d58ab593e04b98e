"""The model as one recorded force, so that it need not run again for what a hypothesis adds to it.

The force is in an additional row of the block, below those of ``signals.layout``.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect
from damper_estimator.identification.rows import Rows
from damper_estimator.model import DamperModel, Element
from damper_estimator.signals.layout import ROWS


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += the recorded force."""
    for i in range(force.size):
        force[i] += kinematics[ROWS, i]


RECORDED = Effect(kernel=kernel, kind="source", name="recorded_force", description="A force as it was recorded.")


def recorded_force_model(model: DamperModel) -> DamperModel:
    """A model that gives the recorded force; the other's name stays."""
    return replace(model, effects=(Element(RECORDED),), fixed=(), fit={})


def rows_with_force(model: DamperModel, rows: Sequence[Rows]) -> tuple[Rows, ...]:
    """The rows with the model's force below the block."""
    recorded = []
    for part in rows:
        kinematics = part.measurement.kinematics
        force = np.nan_to_num(model.force(kinematics.block))
        block = np.ascontiguousarray(np.vstack([kinematics.block, force]))
        recorded.append(
            replace(part, measurement=replace(part.measurement, kinematics=replace(kinematics, block=block)))
        )
    return tuple(recorded)
