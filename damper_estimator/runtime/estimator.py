"""The line of one damper over blocks of any size."""

from dataclasses import dataclass

import numpy as np

from damper_estimator.runtime.deployed import Deployed
from damper_estimator.runtime.estimates import Estimates
from damper_estimator.runtime.line import Line
from damper_estimator.runtime.messages import Arrived
from damper_estimator.runtime.record import SLOW


@dataclass(frozen=True, eq=False)
class Held:
    """What one slow channel has brought at each of n samples.

    Attributes:
        value: (n,) or one, last value, NaN before the first.
        heard: (n,) or one, int64, how many messages had arrived.
        stamp: (n,) or one, int64 ns, of the last message.
    """

    value: np.ndarray | float = np.nan
    heard: np.ndarray | int = 0
    stamp: np.ndarray | int = 0


class DamperEstimator:
    """Filter, model and status of one damper; final."""

    def __init__(self, damper: Deployed) -> None:
        self.line = Line()
        self.line.add("", damper)
        self._taken = 0
        self._heard = dict.fromkeys(SLOW, 0)

    def block(
        self,
        stamp: np.ndarray,
        displacement: np.ndarray,
        command: np.ndarray | float = np.nan,
        temperature: np.ndarray | float = np.nan,
        pressure: np.ndarray | float = np.nan,
        acceleration: np.ndarray | float = np.nan,
        felt_at: np.ndarray | int = 0,
    ) -> Estimates:
        """Estimates for the next samples in order of arrival, each with slow channels that have just arrived; a NaN
        among their values means that no message came.

        Args:
            stamp: (n,) int64 ns.
            displacement: (n,) m.
            command, temperature, pressure: (n,) or one value each, NaN if there is none.
            acceleration, felt_at: the same, m/s^2 and int64 ns, of the accelerometer where there is fusion.
        """
        each = self._taken + 1 + np.arange(stamp.size)
        self._taken += stamp.size
        held = {"acceleration": Held(acceleration, 0, felt_at)}
        for role, value in zip(SLOW, (command, temperature, pressure), strict=True):
            heard = np.maximum.accumulate(np.where(np.isnan(value), self._heard[role], each))
            self._heard[role] = int(heard[-1]) if heard.size else self._heard[role]
            held[role] = Held(value, heard)
        return self.take(stamp, displacement, held)

    def take(self, stamp: np.ndarray, displacement: np.ndarray, held: dict[str, Held]) -> Estimates:
        """The same with slow channels and acceleration, by role, as they were held at each sample."""
        arrived = Arrived.nothing(stamp.size, 1)
        arrived.stamp[:], arrived.displacement[:, 0] = stamp, displacement
        for row, role in enumerate(SLOW):
            if role in held:
                arrived.slow[:, row, 0], arrived.heard[:, row, 0] = held[role].value, held[role].heard
        if "acceleration" in held:
            arrived.felt[:, 0], arrived.felt_at[:, 0] = held["acceleration"].value, held["acceleration"].stamp
        return self.line.run(arrived).of(0, arrived.stamp)
