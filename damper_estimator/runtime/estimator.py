"""The line of one damper over blocks of any size."""

from dataclasses import dataclass

import numpy as np

from damper_estimator.runtime.damper_record import SLOW
from damper_estimator.runtime.deployed import Deployed
from damper_estimator.runtime.estimates import Estimates
from damper_estimator.runtime.line import Line
from damper_estimator.runtime.line_arrays import LineInput


@dataclass(frozen=True, eq=False)
class HeldValues:
    """The last value of one slow channel at each of n samples.

    Attributes:
        value: (n,) or one, last value, NaN before the first.
        received: (n,) or one, int64, number of messages so far.
        stamp: (n,) or one, int64 ns, of the last message.
    """

    value: np.ndarray | float = np.nan
    received: np.ndarray | int = 0
    stamp: np.ndarray | int = 0


class DamperEstimator:
    """Filter, model and status of one damper; final."""

    def __init__(self, damper: Deployed) -> None:
        self.line = Line()
        self.line.add("", damper)
        self._count = 0
        self._received = dict.fromkeys(SLOW, 0)

    def block(
        self,
        stamp: np.ndarray,
        displacement: np.ndarray,
        command: np.ndarray | float = np.nan,
        temperature: np.ndarray | float = np.nan,
        pressure: np.ndarray | float = np.nan,
        acceleration: np.ndarray | float = np.nan,
        acceleration_stamp: np.ndarray | int = 0,
    ) -> Estimates:
        """Estimates for the next samples in order of arrival, each with slow channels that have just arrived; a NaN
        among their values means no message.

        Args:
            stamp: (n,) int64 ns.
            displacement: (n,) m.
            command, temperature, pressure: (n,) or one value each, NaN if there is none.
            acceleration, acceleration_stamp: the same, m/s^2 and int64 ns, of the accelerometer; used with fusion.
        """
        each = self._count + 1 + np.arange(stamp.size)
        self._count += stamp.size
        held = {"acceleration": HeldValues(acceleration, 0, acceleration_stamp)}
        for role, value in zip(SLOW, (command, temperature, pressure), strict=True):
            received = np.maximum.accumulate(np.where(np.isnan(value), self._received[role], each))
            self._received[role] = int(received[-1]) if received.size else self._received[role]
            held[role] = HeldValues(value, received)
        return self.take(stamp, displacement, held)

    def take(self, stamp: np.ndarray, displacement: np.ndarray, held: dict[str, HeldValues]) -> Estimates:
        """The same with the held values of slow channels and acceleration, by role, at each sample."""
        samples = LineInput.empty(stamp.size, 1)
        samples.stamp[:], samples.displacement[:, 0] = stamp, displacement
        for row, role in enumerate(SLOW):
            if role in held:
                samples.slow[:, row, 0], samples.received[:, row, 0] = held[role].value, held[role].received
        if "acceleration" in held:
            samples.acceleration[:, 0], samples.acceleration_stamp[:, 0] = (
                held["acceleration"].value,
                held["acceleration"].stamp,
            )
        return self.line.run(samples).of(0, samples.stamp)
