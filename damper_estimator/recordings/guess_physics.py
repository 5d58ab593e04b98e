"""Physics in the numbers of a bench file: slopes, and the sign of the dissipated power."""

from dataclasses import dataclass

import numpy as np

_SLOW = 0.08  # of the largest velocity; below, the force is that of gas, spring and gauge zero
_STATIC = 0.04  # of the largest force; a smaller constant force has no meaning
_POWER = 0.25  # correlation below which force and velocity are not related
_MOST = 200_000  # samples that are evaluated


@dataclass(frozen=True, eq=False)
class Motion:
    """Velocity (n,) in m/s and force (n,) in N of the same samples."""

    velocity: np.ndarray
    force: np.ndarray


@dataclass(frozen=True)
class Signs:
    """The channels whose sign must be reversed, assumptions, and questions to decide."""

    reversed: tuple[str, ...] = ()
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
    """Factor between a velocity channel and the slope of a position, and their correlation."""
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
    """Checks signs: a damper dissipates energy, so force and velocity have the same sign; its gas pushes the rod out.

    The power shows whether one of the two is reversed; the constant force, which is negative if extension is positive,
    shows which one.
    """
    if motion is None or motion.velocity.std() == 0 or motion.force.std() == 0:
        return Signs(doubts=("displacement and force are constant; their signs are unknown",))
    v, force = motion.velocity, motion.force
    agreement = float(np.corrcoef(v, force)[0, 1])
    if abs(agreement) < _POWER:
        return Signs(
            doubts=(
                f"force and velocity are hardly related (correlation {agreement:.2f}): are these the right columns?",
            )
        )
    slow = np.abs(v) < _SLOW * np.percentile(np.abs(v), 99)
    static = float(np.median(force[slow])) if slow.sum() > 10 else 0.0
    is_clear = abs(static) > _STATIC * np.percentile(np.abs(force - np.median(force)), 99)
    if agreement > 0:
        if is_clear and static > 0:
            what = f"the force at rest is {static:.3g} N: either both signs are reversed, or the gauge's zero is wrong"
            return Signs(doubts=(what,))
        reason = (
            "the force at rest is that of gas, which pushes the rod out"
            if is_clear
            else "nothing in the file confirms it"
        )
        return Signs(assumed=(f"displacement is positive in extension ({reason})",))
    if not is_clear:
        return Signs(
            ("force",), doubts=("displacement and force have opposite signs, and nothing shows which one is reversed",)
        )
    wrong = "force" if static > 0 else "displacement"
    return Signs(
        (wrong,), (f"the sign of the {wrong} is reversed: a damper dissipates energy, and its gas pushes the rod out",)
    )
