"""Where a search begins: the model's values, values of the data's size, and points spread evenly around them.

A parameter's size follows from its unit: a force is measured by the recording's rms force, a length by its rms
displacement and a time by the ratio of that to the rms velocity, so ``N s/m`` becomes rms force over rms velocity.
Only parameters with a force or a velocity in their unit are sized so; times, gains and volumes belong to the damper
and not to the recording, and keep the model's values.
"""

import re

import numpy as np

from damper_estimator.identification.problem import Problem
from damper_estimator.model import Slot

SPREAD = 6  # points around the start per searched parameter
MOST = 40  # points in total
_DECADE = 10.0  # factor up and down in which a parameter of known size is searched
_NARROW = 5.0  # the same for one that keeps the model's value
_LEAST = 1e-4  # of the distance of the bounds: no parameter is smaller
_UNIT = re.compile(r"([A-Za-z]+)(?:\^(-?[0-9.]+))?")
# Exponents of force, length and time, and how many of the unit make one SI unit.
_BASE = {
    "N": (1.0, 0.0, 0.0, 1.0),
    "m": (0.0, 1.0, 0.0, 1.0),
    "mm": (0.0, 1.0, 0.0, 1e3),
    "s": (0.0, 0.0, 1.0, 1.0),
    "kg": (1.0, -1.0, 2.0, 1.0),
}


def candidates(problem: Problem, seed: int, count: int | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Start points (s, q), the model's values first, and the size (q,) of each searched parameter.

    ``count`` points are spread with low discrepancy (by default six per parameter, at most 40); ``seed`` shifts
    them. With ``count`` 0 the model's values are the only point.
    """
    natural = problem.natural_sizes()
    start = problem.start
    slots = [problem.slots[i] for i in problem.searched]
    if not slots:
        return start[None, :], start
    sized = np.array([_from_unit(slot.parameter.unit, natural) for slot in slots])
    spans = np.array([slot.parameter.upper - slot.parameter.lower for slot in slots])
    size = np.fmax(np.maximum(np.abs(start), _LEAST * spans), sized)
    if count == 0:
        return start[None, :], size
    # The size of a parameter that can have either sign does not determine its sign.
    signs = np.array([-1.0 if slot.parameter.upper <= 0.0 else 1.0 for slot in slots])
    signed = np.isfinite(sized) & np.array([not _either_sign(slot) for slot in slots])
    centre = problem.clipped(np.where(signed, signs * np.nan_to_num(sized), start))
    count = min(SPREAD * len(slots), MOST) if count is None else count
    shares = _low_discrepancy(count, len(slots), seed)
    spread = np.array([_placed(slot, start[j], sized[j], shares[:, j]) for j, slot in enumerate(slots)]).T
    return np.vstack([start, centre, problem.clipped(spread)]), size


def _either_sign(slot: Slot) -> bool:
    return slot.parameter.lower < 0.0 < slot.parameter.upper


def _from_unit(unit: str, natural: tuple[float, float, float]) -> float:
    """Size of a parameter from its unit; NaN where the recording does not determine it."""
    top, _, bottom = unit.partition("/")
    exponents, factor = np.zeros(3), 1.0
    for text, sign in ((top, 1.0), (bottom, -1.0)):
        for symbol, power in _UNIT.findall(text):
            if symbol not in _BASE:
                return float("nan")
            power = sign * float(power or 1.0)
            exponents += power * np.array(_BASE[symbol][:3])
            factor *= _BASE[symbol][3] ** power
    force, length, time = exponents
    velocity = force == 0.0 and length != 0.0 and length == -time
    with np.errstate(all="ignore"):
        size = factor * float(np.prod(np.array(natural) ** exponents))
    return size if (force != 0.0 or velocity) and np.isfinite(size) and size > 0.0 else float("nan")


def _low_discrepancy(count: int, dimensions: int, seed: int) -> np.ndarray:
    """(count, dimensions) points in the unit cube: Roberts' additive recurrence, shifted at random by the seed."""
    golden = 2.0
    for _ in range(60):
        golden = (1.0 + golden) ** (1.0 / (dimensions + 1))
    steps = golden ** -np.arange(1.0, dimensions + 1)
    shift = np.random.default_rng(seed).uniform(size=dimensions)
    return (shift + np.outer(np.arange(1, count + 1), steps)) % 1.0


def _placed(slot: Slot, value: float, sized: float, shares: np.ndarray) -> np.ndarray:
    """Values of a parameter at shares (s,) of the range in which it is searched; by ratio where it has one sign."""
    lower, upper = slot.parameter.lower, slot.parameter.upper
    known = np.isfinite(sized)
    if _either_sign(slot):
        reach = max(5.0 * abs(value), 3.0 * sized if known else 0.2 * min(-lower, upper))
        low, high = max(lower, -reach), min(upper, reach)
        return low + shares * (high - low)
    smallest, largest = sorted((abs(lower), abs(upper)))
    middle = sized if known else abs(value) if value != 0.0 else max(smallest, 0.01 * largest)
    factor = _DECADE if known else _NARROW
    middle = min(max(middle, smallest, _LEAST * largest), largest)
    low, high = max(middle / factor, smallest), min(middle * factor, largest)
    return (-1.0 if upper <= 0.0 else 1.0) * low * (high / low) ** shares
