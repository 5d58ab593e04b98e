"""What the numbers of a bench file tell: slopes, and the sign of the power that a damper takes out."""

from dataclasses import dataclass

import numpy as np

_SLOW = 0.08  # of the largest velocity; below, the force is that of gas, spring and gauge zero
_STATIC = 0.04  # of the largest force; a smaller constant force says nothing
_POWER = 0.25  # correlation of force and velocity below which they do not go together
_MOST = 200_000  # samples that are looked at


@dataclass(frozen=True, eq=False)
class Motion:
    """Velocity (n,) in m/s and force (n,) in N of the same samples."""

    velocity: np.ndarray
    force: np.ndarray


@dataclass(frozen=True)
class Signs:
    """Which channels are to be turned round; what was assumed, and what has to be decided."""

    turned: tuple[str, ...] = ()
    assumed: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()


def velocity_of(position: np.ndarray, seconds: np.ndarray) -> np.ndarray:
    """Slope (n,) of a position, over a few samples on either side; NaN across gaps and restarts."""
    reach = max(1, min(5, len(seconds) // 100))
    slope = np.full(len(seconds), np.nan)
    step = seconds[2 * reach :] - seconds[: -2 * reach]
    usual = np.median(step[step > 0]) if (step > 0).any() else np.nan
    good = (step > 0) & (step < 3 * usual)
    difference = position[2 * reach :] - position[: -2 * reach]
    slope[reach:-reach] = np.where(good, difference / np.where(good, step, 1.0), np.nan)
    return slope


def slope_of(position: np.ndarray, seconds: np.ndarray, velocity: np.ndarray) -> tuple[float, float]:
    """Factor between a channel of the velocity and the slope of a position, and their correlation."""
    slope = velocity_of(position[:_MOST], seconds[:_MOST])
    both = np.isfinite(slope) & np.isfinite(velocity[:_MOST])
    a, b = slope[both], velocity[:_MOST][both]
    if len(a) < 20 or a.std() == 0 or b.std() == 0:
        return float("nan"), 0.0
    agreement = float(np.corrcoef(a, b)[0, 1])
    return float(np.dot(b - b.mean(), a - a.mean()) / np.dot(a - a.mean(), a - a.mean())), agreement


def motion_of(position: np.ndarray, force: np.ndarray, seconds: np.ndarray) -> Motion | None:
    """Velocity and force where both are known; None if there are too few."""
    velocity = velocity_of(position[:_MOST], seconds[:_MOST])
    both = np.isfinite(velocity) & np.isfinite(force[:_MOST])
    return Motion(velocity[both], force[:_MOST][both]) if both.sum() > 50 else None


def check_signs(motion: Motion | None) -> Signs:
    """A damper takes energy out, so force and velocity have the same sign; its gas pushes the rod out.

    The power tells whether one of the two is turned round; the constant force, which is negative where extension is
    positive, tells which.
    """
    if motion is None or motion.velocity.std() == 0 or motion.force.std() == 0:
        return Signs(doubts=("displacement and force do not move; nothing tells their signs",))
    v, force = motion.velocity, motion.force
    agreement = float(np.corrcoef(v, force)[0, 1])
    if abs(agreement) < _POWER:
        return Signs(
            doubts=(f"force and velocity hardly go together (correlation {agreement:.2f}): are these the columns?",)
        )
    slow = np.abs(v) < _SLOW * np.percentile(np.abs(v), 99)
    static = float(np.median(force[slow])) if slow.sum() > 10 else 0.0
    tells = abs(static) > _STATIC * np.percentile(np.abs(force - np.median(force)), 99)
    if agreement > 0:
        if tells and static > 0:
            what = (
                f"the force at rest is {static:.3g} N: either both signs are turned round, or the gauge's zero is off"
            )
            return Signs(doubts=(what,))
        said = "the force at rest is that of gas, which pushes the rod out" if tells else "nothing in the file says so"
        return Signs(assumed=(f"displacement is positive in extension ({said})",))
    if not tells:
        return Signs(
            ("force",), doubts=("displacement and force have opposite signs, and nothing tells which is turned round",)
        )
    turned = "force" if static > 0 else "displacement"
    return Signs(
        (turned,), (f"the {turned} is turned round: the damper takes energy out, and its gas pushes the rod out",)
    )
