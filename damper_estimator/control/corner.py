"""The controller of one corner, as it runs on a vehicle: kinematics and the body's acceleration in, current out.

    controller = CornerController(mixed(2500.0, 0.7), InverseCommand(inverse), rest_force=-330.0)
    action = controller.step(sample, body_acceleration)

The body's velocity comes from its accelerometer, the wheel's from the difference to that of the suspension. Table and
inverse model receive the same desired force and kinematics.

A command acts on the motion after the sample. The law therefore desires the force for the same later moment, both
``lead`` seconds ahead with constant accelerations: the force desired for the present, reached at another velocity, is
right at neither moment (docs/control.md).
"""

from dataclasses import dataclass
from math import copysign
from typing import Protocol

import numpy as np

from damper_estimator.control.current_table import CurrentTable
from damper_estimator.control.inverse import InverseModel
from damper_estimator.control.laws import BodyVelocity, Law
from damper_estimator.signals.layout import DT, A, V


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
    """Uses a look-up table, at the velocity ``lead`` s after the sample; final."""

    def __init__(self, table: CurrentTable, lead: float = 0.0):
        self._table, self._lead = table, lead

    def current(self, sample: np.ndarray, wanted: float) -> float:
        """See `Command`."""
        return self._table.current_for(float(sample[V] + self._lead * sample[A]), wanted)


class ConstantCommand:
    """Constant current, as of a passive damper; final."""

    def __init__(self, amperes: float):
        self._amperes = amperes

    def current(self, sample: np.ndarray, wanted: float) -> float:
        """See `Command`."""
        return self._amperes


@dataclass(frozen=True)
class Action:
    """A controller's decision: the desired force (N), for the time ``lead`` after the sample, and the current (A)."""

    wanted: float
    current: float


class CornerController:
    """The running controller of one corner; final."""

    def __init__(self, law: Law, command: Command, rest_force: float = 0.0, fallback: float = 0.0, lead: float = 0.0):
        """Starts at rest.

        Args:
            rest_force: N, added to the force of the law.
            fallback: A, used if there is no current.
            lead: s after a sample for which the force is desired; that of the command.
        """
        self._law, self._command = law, command
        self._rest_force, self._fallback, self._lead = rest_force, fallback, lead
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
        lead = self._lead
        body = self._body.step(body_acceleration, float(sample[DT])) + lead * body_acceleration
        wanted = added + self._law.force(body, body - float(sample[V] + lead * sample[A]))
        wanted = self._rest_force + (copysign(limit, wanted) if abs(wanted) > limit else wanted)
        current = self._command.current(sample, wanted)
        return Action(wanted, current if np.isfinite(current) else self._fallback)
