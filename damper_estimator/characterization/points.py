"""The eight characteristic points A to H of a mean loop and the lines a to h that lead to them.

In order of time: a to the return A (compression's peak speed), b to the restoring point B, c to the reversal C, d to
the yield point D, e to the return E (rebound's peak speed), f to the restoring point F, g to the reversal G, h to the
yield point H. Where a direction has no knee, its yield and restoring points coincide with the return (type 0), and
the lines between them have no length. Source: Lozoya-Santos et al., section 2.1 and figure 2.
"""

from dataclasses import dataclass

import numpy as np

from damper_estimator.characterization.halves import Half, halves
from damper_estimator.characterization.loops import Loop
from damper_estimator.characterization.patterns import yields

POINTS = "ABCDEFGH"
MEANINGS = {
    "A": "return, compression", "B": "restoring, compression", "C": "reversal into rebound", "D": "yield, rebound",
    "E": "return, rebound", "F": "restoring, rebound", "G": "reversal into compression", "H": "yield, compression",
}  # fmt: skip
_BENDS = 0.75  # slope beyond the knee over slope before it up to which a branch has a knee


@dataclass(frozen=True)
class Point:
    """A characteristic point: SI, displacement from the middle of the stroke; ``phase`` 0 to 1 from point C on."""

    name: str
    phase: float
    displacement: float
    velocity: float
    acceleration: float
    force: float


@dataclass(frozen=True)
class Line:
    """The section between two points: slopes by least squares; NaN if it has no length.

    Attributes:
        stiffness: N/m, in F-x.
        damping: N s/m, in F-v.
        mass: kg, in F-a.
    """

    name: str
    stiffness: float
    damping: float
    mass: float


def characteristic_points(loop: Loop) -> tuple[dict[str, Point], dict[str, Line]]:
    """Points A to H and lines a to h by name."""
    places = _places(loop)
    points = {name: _point(loop, name, places[name]) for name in POINTS}
    order = ["H", *POINTS]
    lines = {
        end.lower(): _line(loop, end.lower(), places[start], places[end])
        for start, end in zip(order, POINTS, strict=False)
    }
    return points, lines


def _places(loop: Loop) -> dict[str, float]:
    """Phase of each point, 0 to 1; those of a direction without a knee coincide."""
    size = loop.force.size
    rebound, compression = halves(loop)
    top = {1.0: int(np.argmax(loop.velocity)), -1.0: int(np.argmin(loop.velocity))}
    places = {"C": 0.0, "G": 0.5, "E": top[1.0] / size, "A": top[-1.0] / size}
    for half, start, names in ((rebound, 0.0, "DEF"), (compression, 0.5, "HAB")):
        yield_point, back, restoring = names
        knees = (half.before, half.after) if yields(half) else (None, None)
        rising, falling = (_knee(branch, half) for branch in knees)
        middle, end = places[back], start + 0.5
        places[yield_point] = _at_speed(loop, half, rising, start, middle) if rising else middle
        places[restoring] = _at_speed(loop, half, falling, end, middle) if falling else middle
    return places


def _knee(branch, half: Half) -> float | None:
    """Speed in m/s at which a branch bends; that of the mean curve if the branch has none."""
    if branch is None:
        return None
    bends = branch.high > 0.0 and branch.low <= _BENDS * branch.high
    return (branch.knee if bends else half.mean.knee) * half.peak_velocity


def _at_speed(loop: Loop, half: Half, speed: float, outer: float, top: float) -> float:
    """Phase between a reversal (``outer``) and the peak (``top``) at which the speed is reached."""
    size = loop.force.size
    steps = np.linspace(outer * size, top * size, 721)
    branch_speed = half.sign * _periodic(loop.velocity, steps)
    return float(np.interp(speed, np.maximum.accumulate(branch_speed), steps) / size)


def _periodic(values: np.ndarray, steps: np.ndarray | float) -> np.ndarray:
    return np.interp(np.mod(steps, values.size), np.arange(values.size + 1), np.append(values, values[0]))


def _point(loop: Loop, name: str, phase: float) -> Point:
    step = phase * loop.force.size
    x, v, a, f = (float(_periodic(c, step)) for c in (loop.displacement, loop.velocity, loop.acceleration, loop.force))
    return Point(name, phase % 1.0, x, v, a, f)


def _line(loop: Loop, name: str, start: float, end: float) -> Line:
    length = (end - start) % 1.0
    if length * loop.force.size < 1.0 or length > 0.75:
        return Line(name, np.nan, np.nan, np.nan)
    steps = (start + np.linspace(0.0, length, 61)) * loop.force.size
    force = _periodic(loop.force, steps)
    columns = (loop.displacement, loop.velocity, loop.acceleration)
    return Line(name, *(_slope(_periodic(column, steps), force) for column in columns))


def _slope(over: np.ndarray, force: np.ndarray) -> float:
    centred = over - over.mean()
    square = float(centred @ centred)
    return float(centred @ (force - force.mean()) / square) if square > 0.0 else float("nan")
