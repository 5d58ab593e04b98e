"""Diagrams of two settings subtracted at the same motion and phase: the semi-active part, the pressure part.

    F_SA(phase) = F_M(phase) - F_P(phase)

Source: Lozoya-Santos et al., eq. (4) and figures 15 to 17 (which find cavitation by subtracting two pressures).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.characterization.loops import Loop

_FREQUENCY, _AMPLITUDE = 0.06, 0.20  # how far two motions may be apart to count as the same, relative


@dataclass(frozen=True)
class Difference:
    """What one setting adds to another.

    Attributes:
        loop: motion of ``minuend``, force of ``minuend`` less that of ``subtrahend``.
        minuend, subtrahend: the two loops.
        what: ``command``, ``pressure``, or ``setting`` where the recordings do not say what was changed.
        apart: relative difference of their peak velocities.
    """

    loop: Loop
    minuend: Loop
    subtrahend: Loop
    what: str
    apart: float


def difference(minuend: Loop, loops: Sequence[Loop]) -> Difference | None:
    """What a loop adds to the one of ``loops`` whose motion is most like its own; None where none is like it."""
    near = [(distance, i) for i, other in enumerate(loops) if (distance := _distance(minuend, other)) <= 1.0]
    if not near:
        return None
    subtrahend = loops[min(near)[1]]
    apart = abs(minuend.peak_velocity / subtrahend.peak_velocity - 1.0)
    return Difference(minuend.less(subtrahend), minuend, subtrahend, _what(minuend, subtrahend), apart)


def semi_active(loops: Sequence[Loop]) -> tuple[list[Loop], list[Difference]]:
    """The loops at the smallest command, which are passive, and what every larger command adds to them."""
    commands = np.array([abs(loop.command) for loop in loops])
    known = commands[np.isfinite(commands)]
    if not known.size:
        return list(loops), []
    limit = known.min() + 0.04 * known.max()
    passive = [loop for loop, own in zip(loops, commands, strict=True) if not own > limit]
    driven = [loop for loop, own in zip(loops, commands, strict=True) if own > limit]
    return passive, [d for loop in driven if (d := difference(loop, passive)) is not None]


def _distance(a: Loop, b: Loop) -> float:
    return max(abs(np.log(a.frequency / b.frequency)) / _FREQUENCY, abs(np.log(a.amplitude / b.amplitude)) / _AMPLITUDE)


def _what(a: Loop, b: Loop) -> str:
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
