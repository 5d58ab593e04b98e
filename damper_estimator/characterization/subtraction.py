"""Subtracts diagrams of two settings at equal motion and phase: the semi-active part, the pressure part.

    F_SA(phase) = F_M(phase) - F_P(phase)

Source: Lozoya-Santos et al., eq. (4) and figures 15 to 17 (which find cavitation by subtracting two pressures).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.characterization.loops import Loop

_FREQUENCY, _AMPLITUDE = 0.06, 0.20  # largest relative difference of motions that count as equal


@dataclass(frozen=True)
class Difference:
    """The force that one setting adds to another.

    Attributes:
        loop: motion of ``minuend``, force of ``minuend`` minus that of ``subtrahend``.
        minuend, subtrahend: the two loops.
        quantity: ``command``, ``pressure``, or ``setting`` if the recordings do not show the change.
        velocity_difference: relative difference of their peak velocities.
    """

    loop: Loop
    minuend: Loop
    subtrahend: Loop
    quantity: str
    velocity_difference: float


def difference(minuend: Loop, loops: Sequence[Loop]) -> Difference | None:
    """The difference between a loop and the one of ``loops`` with the most similar motion; None if none is similar."""
    near = [(distance, i) for i, other in enumerate(loops) if (distance := _distance(minuend, other)) <= 1.0]
    if not near:
        return None
    subtrahend = loops[min(near)[1]]
    velocity_difference = abs(minuend.peak_velocity / subtrahend.peak_velocity - 1.0)
    return Difference(
        minuend.less(subtrahend), minuend, subtrahend, _changed_quantity(minuend, subtrahend), velocity_difference
    )


def semi_active(loops: Sequence[Loop]) -> tuple[list[Loop], list[Difference]]:
    """The loops at the smallest command, taken as passive, and the differences for every larger command."""
    commands = np.array([abs(loop.command) for loop in loops])
    known = commands[np.isfinite(commands)]
    if not known.size:
        return list(loops), []
    limit = known.min() + 0.04 * known.max()
    passive = [loop for loop, command in zip(loops, commands, strict=True) if not command > limit]
    driven = [loop for loop, command in zip(loops, commands, strict=True) if command > limit]
    return passive, [d for loop in driven if (d := difference(loop, passive)) is not None]


def _distance(a: Loop, b: Loop) -> float:
    return max(abs(np.log(a.frequency / b.frequency)) / _FREQUENCY, abs(np.log(a.amplitude / b.amplitude)) / _AMPLITUDE)


def _changed_quantity(a: Loop, b: Loop) -> str:
    if (
        np.isfinite(a.command)
        and np.isfinite(b.command)
        and abs(a.command - b.command) > 0.02 * max(abs(a.command), abs(b.command))
    ):
        return "command"
    if (
        np.isfinite(a.pressure)
        and np.isfinite(b.pressure)
        and abs(a.pressure - b.pressure) > 0.02 * max(a.pressure, b.pressure)
    ):
        return "pressure"
    return "setting"
