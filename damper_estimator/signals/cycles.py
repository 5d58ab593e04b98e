"""Cycles of a recording, found by the reversals of the motion: frequency, stroke and similarity to a sine."""

from dataclasses import dataclass

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.signals.kinematics import Kinematics

LEAST_STROKE = 0.01  # of the recording's whole range; smaller motion is noise or quantisation, not a stroke


@dataclass(frozen=True)
class Cycle:
    """From one reversal into extension to the next.

    Attributes:
        first, last: samples ``first`` to ``last`` - 1 lie inside.
        start, end: s, the reversals, between samples.
        amplitude: m, half the stroke, of the first harmonic.
        middle: m, mean displacement.
        peak_velocity: m/s, the largest speed.
        departure: 0 for a sine; rms of the displacement less its first harmonic, over the rms of the displacement.
    """

    first: int
    last: int
    start: float
    end: float
    amplitude: float
    middle: float
    peak_velocity: float
    departure: float

    @property
    def frequency(self) -> float:
        """Hz."""
        return 1.0 / (self.end - self.start)


@compiled
def turning_points(displacement, least, found):
    """Writes the indices of the extremes between which the displacement moves by ``least`` or more; returns how many.

    A reversal counts after the motion has come back by ``least``, so wobble around standstill has none.
    """
    count, low, high, direction = 0, 0, 0, 0
    for i in range(displacement.size):
        if displacement[i] > displacement[high]:
            high = i
        if displacement[i] < displacement[low]:
            low = i
        if direction >= 0 and displacement[high] - displacement[i] >= least:
            found[count] = high
            count += 1
            direction, low, high = -1, i, i
        elif direction <= 0 and displacement[i] - displacement[low] >= least:
            found[count] = low
            count += 1
            direction, low, high = 1, i, i
    return count


def reversals(kinematics: Kinematics, part: slice) -> np.ndarray:
    """Indices, counted from the start of the recording, of the turning points inside a stretch."""
    displacement = np.ascontiguousarray(kinematics.displacement[part])
    least = LEAST_STROKE * float(np.ptp(kinematics.displacement))
    if displacement.size < 3 or least <= 0.0:
        return np.zeros(0, np.int64)
    found = np.zeros(displacement.size, np.int64)
    return part.start + found[: turning_points(displacement, least, found)]


def find_cycles(kinematics: Kinematics, judged: np.ndarray | None = None) -> list[Cycle]:
    """All whole cycles, in order of time; only those whose samples are all ``judged`` (n,) if that is given."""
    cycles = []
    for part in kinematics.stretches():
        at = reversals(kinematics, part)
        # Into extension: the displacement is lower there than at the next turning point.
        starts = [
            i for i, j in zip(at, at[1:], strict=False) if kinematics.displacement[i] < kinematics.displacement[j]
        ]
        if at.size >= 2 and kinematics.displacement[at[-1]] < kinematics.displacement[at[-2]]:
            starts.append(at[-1])
        edges = [_crossing(kinematics, int(i), part) for i in starts]
        cycles += [cycle for a, b in zip(edges, edges[1:], strict=False) if (cycle := _cycle(kinematics, a, b, judged))]
    return cycles


def _crossing(kinematics: Kinematics, index: int, part: slice) -> float:
    """Time in s at which the velocity passes zero next to a lower turning point."""
    velocity, time = kinematics.velocity, kinematics.time
    for i in (index, index - 1):
        if part.start <= i and i + 1 < part.stop and velocity[i] <= 0.0 < velocity[i + 1]:
            return float(time[i] - velocity[i] * (time[i + 1] - time[i]) / (velocity[i + 1] - velocity[i]))
    return float(time[index])


def _cycle(kinematics: Kinematics, start: float, end: float, judged: np.ndarray | None) -> Cycle | None:
    first, last = np.searchsorted(kinematics.time, [start, end]).tolist()
    if last - first < 4 or (judged is not None and not judged[first:last].all()):
        return None
    angle = 2.0 * np.pi * (kinematics.time[first:last] - start) / (end - start)
    basis = np.stack([np.ones_like(angle), np.cos(angle), np.sin(angle)], axis=1)
    x = kinematics.displacement[first:last]
    share = np.linalg.lstsq(basis, x, rcond=None)[0]
    rest = x - basis @ share
    amplitude = float(np.hypot(share[1], share[2]))
    spread = float(np.sqrt(np.mean((x - share[0]) ** 2)))
    return Cycle(
        first=first,
        last=last,
        start=start,
        end=end,
        amplitude=amplitude,
        middle=float(share[0]),
        peak_velocity=float(np.abs(kinematics.velocity[first:last]).max()),
        departure=float(np.sqrt(np.mean(rest**2)) / spread) if spread > 0.0 else 1.0,
    )
