"""The model as recorded forces, so that it need not run again for what a hypothesis adds to it.

The forces are in additional rows of the block, below those of ``signals.layout``: the whole, and what of it acts on the
rod beside the oil's compressibility. What acts behind a compliance, in
parallel to the damper, moves by less than was measured: by the compliance's deflection under the measured force, its
losses left out.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect
from damper_estimator.identification.rows import Rows
from damper_estimator.model import DamperModel, Element
from damper_estimator.model.element import walk
from damper_estimator.signals.layout import ROWS, A, T, V, X

_LEAST_REACH, _MOST_REACH = 1e-6, 0.1  # m, of a spring's deflection
_GRID = 2001  # points of its curve
_GIVES_WAY = 0.1  # of its stiffness is left


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += the recorded force less what acts beside the oil; exactly the recorded force where that was added before."""
    for i in range(force.size):
        force[i] = (force[i] - kinematics[ROWS + 1, i]) + kinematics[ROWS, i]


@compiled
def kernel_beside(parameters, settings, kinematics, state, force):
    """F += the recorded force beside the oil."""
    for i in range(force.size):
        force[i] += kinematics[ROWS + 1, i]


RECORDED = Effect(kernel=kernel, kind="source", name="recorded_force", description="A force as it was recorded.")
BESIDE = replace(RECORDED, kernel=kernel_beside, name="recorded_force_beside", beside_oil=True)


def recorded_force_model(model: DamperModel) -> DamperModel:
    """A model that gives the recorded forces; the other's name stays."""
    return replace(model, effects=(Element(BESIDE), Element(RECORDED)), fixed=(), fit={})


def rows_with_force(model: DamperModel, rows: Sequence[Rows], inside: Sequence[Element] = ()) -> tuple[Rows, ...]:
    """The rows with the model's forces below the block, and the motion behind the series springs ``inside``."""
    recorded, beside_oil = [], [entry.effect.beside_oil for entry in walk(model.effects)]
    for part in rows:
        measurement = part.measurement
        block = measurement.kinematics.block
        force, parts = (np.nan_to_num(forces) for forces in model.stream().contributions(block))
        known = np.isfinite(measurement.force)
        for spring in inside:
            block = _behind(spring, block, measurement.in_band(np.where(known, measurement.force, force)))
        block = np.ascontiguousarray(np.vstack([block, force, parts[beside_oil].sum(axis=0)]))
        recorded.append(
            replace(part, measurement=replace(measurement, kinematics=replace(measurement.kinematics, block=block)))
        )
    return tuple(recorded)


def _behind(spring: Element, block: np.ndarray, force: np.ndarray) -> np.ndarray:
    """The block (8, n) with the motion behind a series spring that carries a force (n,) in N.

    Where it gives way, as a pocket of gas does that carries no more, its deflection says nothing of the force: it is
    that of the largest force at which it is still stiff.
    """
    alone = DamperModel("spring", "", (replace(spring, effect=replace(spring.effect, kind="source"), path=()),))
    reach = _LEAST_REACH
    while True:
        grid = np.linspace(-reach, reach, _GRID)
        over = np.zeros((ROWS, _GRID))
        over[X] = grid
        carried = alone.force(over)
        slope, middle = np.gradient(carried, grid), _GRID // 2
        low, high = middle - _stiff(slope[middle::-1]), middle + _stiff(slope[middle:])
        covers = (low > 0 or carried[0] <= force.min()) and (high < _GRID - 1 or carried[-1] >= force.max())
        if reach >= _MOST_REACH or covers:
            break
        reach *= 2.0
    deflection = np.interp(force, carried[low : high + 1], grid[low : high + 1])
    rate = np.gradient(deflection, block[T])
    moved = block.copy()
    moved[X] -= deflection
    moved[V] -= rate
    moved[A] -= np.gradient(rate, block[T])
    return moved


def _stiff(slope: np.ndarray) -> int:
    """The last of some stiffnesses (n,) from rest outwards before one that is far below the largest so far."""
    soft = slope < _GIVES_WAY * np.maximum.accumulate(slope)
    return max(int(np.argmax(soft)) - 1, 1) if soft.any() else slope.size - 1
