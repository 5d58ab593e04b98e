"""A form-free damper behind a spring: the regression of ``form_free`` at the motion that is left after the compliance.

Oil and mount yield in series with the damper, so fast small motion does not reach it. The spring's deflection is the
measured force over its stiffness, so a given stiffness keeps the regression linear. The stiffness is chosen by the
error of the simulated force, which has to find its deflection itself.
"""

from dataclasses import dataclass, replace

import numpy as np

from damper_estimator.compiled import compiled
from damper_estimator.signals import Measurement
from damper_estimator.signals.layout import DT, V, X
from damper_estimator.validation.form_free import FormFree, form_free

_STIFFNESS = (np.inf, 1.6e7, 8e6, 4e6, 2e6, 1e6, 5e5, 2.5e5, 1.25e5, 6e4)  # N/m
_FIRST = 3
_BETWEEN = (0.0, -0.25, 0.25, -0.5, 0.5)  # octaves from the best of them
_SEARCHED = 10_000  # samples in the middle of a recording; they show the stiffness as well as all
_LONGEST = 2e-3  # s, step (a tenth longer will do) of the simulation
_RIGID = 1e15  # N/m
_ITERATIONS = 30
_CLOSE = 1e-4  # N
_FAR = 1e5  # N, more than any force changes in a step


@dataclass(frozen=True)
class Sprung:
    """A regression behind a spring of ``stiffness`` in N/m, infinite for none."""

    damper: FormFree
    stiffness: float

    def force(self, block: np.ndarray) -> np.ndarray:
        """(n,) N on a sample block."""
        damper, out = self.damper, np.empty(block.shape[1])
        knots, heights, widths, held, static = damper.shape(block)
        if np.isfinite(self.stiffness):
            heights = np.maximum.accumulate(heights, axis=1)  # behind a spring a falling curve would jump
        stiffness = min(self.stiffness, _RIGID)
        dt = np.ascontiguousarray(block[DT])
        inside = dt[dt > 0.0]
        parts = round(float(np.median(inside)) / _LONGEST + 0.4) if inside.size and np.isfinite(self.stiffness) else 1
        x, v = (np.ascontiguousarray(block[row]) for row in (X, V))
        _simulate(dt, x, v, knots, heights, widths, held, static, stiffness, max(parts, 1), out)
        return out


def sprung(measurement: Measurement) -> Sprung:
    """The regression behind the spring with which it reproduces the force of a recording best."""
    first = max(len(measurement.kinematics) - _SEARCHED, 0) // 2
    middle = measurement.part(first, first + _SEARCHED) if first else measurement
    tried: dict[float, tuple[float, Sprung]] = {}

    def error(stiffness: float) -> float:
        if stiffness not in tried:
            tried[stiffness] = _fitted(middle, stiffness)
        return tried[stiffness][0]

    place = _FIRST
    for step in (1, -1):
        while 0 <= place + step < len(_STIFFNESS) and error(_STIFFNESS[place + step]) < error(_STIFFNESS[place]):
            place += step
    best = min((_STIFFNESS[place] * 2.0**octaves for octaves in _BETWEEN), key=error)
    return _fitted(measurement, best)[1] if first else tried[best][1]


def _fitted(m: Measurement, stiffness: float) -> tuple[float, Sprung]:
    """RMS error in N of the simulated force, and the damper."""
    k, force = m.kinematics, np.asarray(m.force)
    known = np.isfinite(force)
    force = np.interp(k.time, k.time[known], force[known]) if known.any() else np.zeros(len(k))
    block = k.block.copy()
    block[X] -= force / stiffness
    for part in k.stretches():
        if part.stop - part.start > 1:
            block[V, part] -= np.gradient(force[part], k.time[part]) / stiffness
    damper = form_free([replace(m, kinematics=replace(k, block=block))], with_acceleration=False, rising=True)
    found = Sprung(damper, stiffness)
    left = m.in_band(found.force(k.block) - force)[m.judged & known]
    error = float(np.sqrt(np.mean(left**2))) if left.size else float("inf")
    return error if np.isfinite(error) else float("inf"), found


@compiled
def _on_curve(speed, knots, heights):
    """Force of the curve through heights (k,), constant beyond its ends, and its slope; np.interp takes seconds to
    compile.
    """
    last = knots.size - 1
    if speed <= knots[0]:
        return heights[0], 0.0
    if speed >= knots[last]:
        return heights[last], 0.0
    k = 1
    while knots[k] < speed:
        k += 1
    slope = (heights[k] - heights[k - 1]) / (knots[k] - knots[k - 1])
    return heights[k - 1] + slope * (speed - knots[k - 1]), slope


@compiled
def _yielded(i, x, v, since, step, before, force, heights, knots, held, widths, plays, stiffness):
    """Force in N of the damper that is left to move, and its slope over the spring's force (>= 0)."""
    speed = v - (force - before) / (stiffness * step)
    total, rise = _on_curve(speed, knots, heights[i])
    slope = max(rise, 0.0) / (stiffness * step)
    moved = x - force / stiffness - since
    for j in range(widths.size):
        z = plays[j] + moved
        if abs(z) < widths[j]:
            slope += held[i, j] / (widths[j] * stiffness)
        total += held[i, j] * min(max(z / widths[j], -1.0), 1.0)
    return total, slope


@compiled
def _simulate(dt, x, v, knots, heights, widths, held, static, stiffness, parts, out):
    """Implicit steps: Newton's method, between bounds, for the force that damper and spring share."""
    plays = np.zeros(widths.size)
    before, since = 0.0, 0.0
    for i in range(x.size):
        if i == 0 or dt[i] <= 0.0:
            plays[:] = 0.0
            before = static[i] + _on_curve(v[i], knots, heights[i])[0]
            since = x[i] - before / stiffness
            out[i] = before
            continue
        step = dt[i] / parts
        for part in range(1, parts + 1):
            s = part / parts  # cubic between samples
            travel = (1.0 + 2.0 * s) * (1.0 - s) ** 2 * x[i - 1] + s * s * (3.0 - 2.0 * s) * x[i]
            travel += s * (1.0 - s) * ((1.0 - s) * v[i - 1] - s * v[i]) * dt[i]
            speed = v[i - 1] + s * (v[i] - v[i - 1])
            force, low, high = before, before - _FAR, before + _FAR
            for _ in range(_ITERATIONS):
                total, slope = _yielded(
                    i, travel, speed, since, step, before, force, heights, knots, held, widths, plays, stiffness
                )
                left = force - total - static[i]
                if left > 0.0:
                    high = force
                else:
                    low = force
                moved = force - left / (1.0 + slope)
                if moved <= low or moved >= high:
                    moved = 0.5 * (low + high)
                done = abs(moved - force) < _CLOSE
                force = moved
                if done:
                    break
            rod = travel - force / stiffness
            for j in range(widths.size):
                plays[j] = min(max(plays[j] + rod - since, -widths[j]), widths[j])
            since, before = rod, force
        out[i] = before
