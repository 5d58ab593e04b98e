"""One direction of a mean loop: force over speed while the speed rises and while it falls, and where it bends.

    f(u) = alpha + beta u + gamma max(u - k, 0),      u = |v| / max |v|

Two straight lines that meet at the knee k, by least squares; the slopes before and beyond it are the high and the low
damping of Lozoya-Santos et al., section 2.1.
"""

from dataclasses import dataclass

import numpy as np

from damper_estimator.characterization.loops import Loop

GRID = np.linspace(0.0, 1.0, 101)  # u, relative speed
_KNEES = np.linspace(0.03, 0.9, 88)


@dataclass(frozen=True)
class Hinge:
    """Two straight lines; slopes in N per unit of relative speed.

    Attributes:
        knee: u where they meet.
        high, low: slopes before and beyond the knee.
        at_zero, at_knee: N, values of the lines.
    """

    knee: float
    high: float
    low: float
    at_zero: float
    at_knee: float


@dataclass(frozen=True)
class Half:
    """One direction of motion, forces positive if they resist it, relative to the loop's offset.

    Attributes:
        sign: +1 rebound, -1 compression.
        peak_velocity: m/s, absolute.
        rising, falling: (101,) N over ``GRID``, while the speed rises and falls.
        before, after: the same two branches as two lines.
        mean: their mean as two lines, free of the effects of springs and masses.
    """

    sign: float
    peak_velocity: float
    rising: np.ndarray
    falling: np.ndarray
    before: Hinge
    after: Hinge
    mean: Hinge

    @property
    def middle(self) -> np.ndarray:
        """(101,) N, mean of both branches."""
        return 0.5 * (self.rising + self.falling)

    @property
    def hysteresis(self) -> np.ndarray:
        """(101,) N, falling - rising: positive where the force lags."""
        return self.falling - self.rising


def offset(loop: Loop) -> float:
    """Mean force at the reversals, N: gas force and gauge offset; springs cancel."""
    quarter = loop.force.size // 2
    return 0.5 * float(loop.force[0] + loop.force[quarter])


def halves(loop: Loop) -> tuple[Half, Half]:
    """Rebound and compression."""
    middle = loop.force.size // 2
    turned = np.roll(np.arange(loop.force.size), -middle)
    everything = np.arange(loop.force.size)
    return _half(loop, everything[: middle + 1], 1.0), _half(loop, turned[: middle + 1], -1.0)


def _half(loop: Loop, inside: np.ndarray, sign: float) -> Half:
    speed = sign * loop.velocity[inside]
    force = sign * (loop.force[inside] - offset(loop))
    top = int(np.argmax(speed))
    peak = float(speed[top])
    rising = np.interp(GRID, np.maximum.accumulate(speed[: top + 1]) / peak, force[: top + 1])
    falling = np.interp(GRID, np.maximum.accumulate(speed[top:][::-1]) / peak, force[top:][::-1])
    return Half(sign, peak, rising, falling, hinge(rising), hinge(falling), hinge(0.5 * (rising + falling)))


def hinge(force: np.ndarray) -> Hinge:
    """The two lines nearest to a force (101,) over ``GRID``."""
    best = (np.inf, 0.0, np.zeros(3))
    for knee in _KNEES:
        basis = np.stack([np.ones_like(GRID), GRID, np.maximum(GRID - knee, 0.0)], axis=1)
        # Normal equations: three well-scaled columns, and faster than a factorisation.
        share = np.linalg.solve(basis.T @ basis, basis.T @ force)
        error = float(np.sum((force - basis @ share) ** 2))
        if error < best[0]:
            best = (error, float(knee), share)
    _, knee, (alpha, beta, gamma) = best
    return Hinge(knee, float(beta), float(beta + gamma), float(alpha), float(alpha + beta * knee))
