"""Laws for the desired force of a semi-active damper: skyhook, groundhook, mixed, and passive for reference.

With z upwards, positive forces resisting extension, v_b = z_b' of the body and v_w = z_w' of the wheel:

    skyhook      F = c v_b                      the body is damped against a fixed sky
    groundhook   F = -c v_w                     the wheel is damped against the ground
    mixed        F = c (s v_b - (1 - s) v_w)    s from 0 (groundhook) to 1 (skyhook)
    passive      F = c (v_b - v_w)              an ordinary linear damper

A damper can only dissipate: the inverse limits the desired force to the reachable range. The gas force at rest, which
the springs balance, must be added to the desired force. Sources: D. Karnopp, M. J. Crosby, R. A. Harwood,
Vibration control using semi-active force generators, J. Eng. Ind. 96 (1974); M. Valasek et al., Extended ground-hook,
Vehicle System Dynamics 27 (1997).
"""

from dataclasses import dataclass
from math import pi


@dataclass(frozen=True)
class Law:
    """A linear law: F = body v_b - wheel v_w.

    Attributes:
        name: of the law.
        body, wheel: N s/m.
    """

    name: str
    body: float
    wheel: float

    def force(self, body_velocity: float, wheel_velocity: float) -> float:
        """Desired force in N, without the force at rest; velocities in m/s, upwards."""
        return self.body * body_velocity - self.wheel * wheel_velocity


def skyhook(damping: float) -> Law:
    """``damping`` c in N s/m."""
    return Law("skyhook", damping, 0.0)


def groundhook(damping: float) -> Law:
    """``damping`` c in N s/m."""
    return Law("groundhook", 0.0, damping)


def mixed(damping: float, share: float) -> Law:
    """``damping`` c in N s/m, ``share`` s of the skyhook, from 0 to 1.

    Raises:
        ValueError: for another share.
    """
    if not 0.0 <= share <= 1.0:
        raise ValueError(f"share {share:g} of the skyhook is not between 0 and 1")
    return Law("mixed", damping * share, damping * (1.0 - share))


def passive(damping: float) -> Law:
    """``damping`` c in N s/m."""
    return Law("passive", damping, damping)


LAWS = {"skyhook": skyhook, "groundhook": groundhook, "passive": passive}
"""Laws with one number by name; ``mixed`` has two."""


class BodyVelocity:
    """Velocity of the body from its acceleration: integrated, with a high-pass that removes the sensor's offset.

        v = s / (s^2 + 2 d w s + w^2) a,      w = 2 pi corner, d = 1 / sqrt(2)

    Mean acceleration over each step; first order in the step, whose share w dt is below 1 % at a hundred samples per
    second.
    """

    def __init__(self, corner: float = 0.15):
        """``corner`` in Hz; velocities well above it are accurate, an offset of the accelerometer is removed."""
        self._frequency = 2.0 * pi * corner
        self._velocity = self._position = 0.0
        self._before: float | None = None

    def step(self, acceleration: float, dt: float) -> float:
        """Velocity in m/s after a sample (m/s^2) that came ``dt`` s after the one before; 0 resets."""
        if dt <= 0.0 or self._before is None:
            self._velocity = self._position = 0.0
        else:
            w = self._frequency
            push = 0.5 * (acceleration + self._before) - 2.0**0.5 * w * self._velocity - w * w * self._position
            self._velocity += dt * push
            self._position += dt * self._velocity
        self._before = acceleration
        return self._velocity
