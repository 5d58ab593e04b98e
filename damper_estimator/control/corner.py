"""The controller of one corner, as it runs on a vehicle: kinematics and the body's acceleration in, current out.

    controller = CornerController(mixed(2500.0, 0.7), InverseCommand(inverse), rest_force=-330.0)
    action = controller.step(sample, body_acceleration)

The body's velocity comes from its accelerometer, the wheel's from the difference to that of the suspension. Table and
inverse model receive the same desired force and kinematics.
"""

from dataclasses import dataclass
from math import copysign
from typing import Protocol

import numpy as np

from damper_estimator.control.current_table import CurrentTable
from damper_estimator.control.inverse import InverseModel
from damper_estimator.control.laws import BodyVelocity, Law
from damper_estimator.signals.layout import DT, V


class Command(Protocol):
    """Converts a desired force to a current."""

    def current(self, sample: np.ndarray, wanted: float) -> float:
        """A, from a sample (8,) in the rows of ``signals.layout`` and a force in N; NaN if there is none."""


class InverseCommand:
    """Uses the inverse of a model; final."""

    def __init__(self, inverse: InverseModel):
        self._inverse = inverse

    def current(self, sample: np.ndarray, wanted: float) -> float:
        """See `Command`."""
        return self._inverse.solve(sample, wanted).current


class TableCommand:
    """Uses a look-up table; final."""

    def __init__(self, table: CurrentTable):
        self.table = table

    def current(self, sample: np.ndarray, wanted: float) -> float:
        """See `Command`."""
        return self.table.current_for(float(sample[V]), wanted)


class ConstantCommand:
    """Constant current, as of a passive damper; final."""

    def __init__(self, amperes: float):
        self._amperes = amperes

    def current(self, sample: np.ndarray, wanted: float) -> float:
        """See `Command`."""
        return self._amperes


@dataclass(frozen=True)
class Action:
    """A controller's decision: the desired force (N) and the current (A)."""

    wanted: float
    current: float


class CornerController:
    """The running controller of one corner; final."""

    def __init__(self, law: Law, command: Command, rest_force: float = 0.0, fallback: float = 0.0):
        """``rest_force`` in N is added to the force of the law; ``fallback`` in A is used if there is no current."""
        self._law, self._command = law, command
        self._rest_force, self._fallback = rest_force, fallback
        self._body = BodyVelocity()

    def step(
        self, sample: np.ndarray, body_acceleration: float, added: float = 0.0, limit: float = float("inf")
    ) -> Action:
        """Processes one sample of the sensors.

        Args:
            sample: (8,) in the rows of ``signals.layout``: kinematics of the suspension, and the present current.
            body_acceleration: m/s^2, upwards, without gravity.
            added: N, desired additionally by another controller.
            limit: N, largest desired force relative to the force at rest, in both directions.
        """
        body = self._body.step(body_acceleration, float(sample[DT]))
        wanted = added + self._law.force(body, body - float(sample[V]))
        wanted = self._rest_force + (copysign(limit, wanted) if abs(wanted) > limit else wanted)
        current = self._command.current(sample, wanted)
        return Action(wanted, current if np.isfinite(current) else self._fallback)
