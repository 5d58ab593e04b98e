"""One damper under the example controller, which acts only on checked estimates with a usable status. Independent of
ROS.
"""

from dataclasses import dataclass
from math import isfinite

import numpy as np

from damper_estimator.control import Action, CornerController
from damper_estimator.node.controller_settings import ControllerSettings
from damper_estimator.node.wire import NANOSECONDS
from damper_estimator.runtime import EXTRAPOLATING, GOOD, STALE
from damper_estimator.signals.layout import DT, ROWS, A, V, X

MAX_GAP = 0.1  # s between two estimates, after which the law restarts
MOST_ACCELERATION = 500.0  # m/s^2; more than any body has


@dataclass
class CornerTally:
    """The outcome of the messages for one damper since the start; counts never decrease.

    Attributes:
        estimates: received.
        acted: estimates that the law answered; ``limited``: with a limited force, because they were EXTRAPOLATING.
        not_usable, not_felt, not_finite: estimates that it did not answer: because of the status, without a recent
            acceleration, because the law's force was not finite.
        silences: how often the estimates stopped.
        rejected: accelerations that are not finite or not plausible.
        ignored: added forces that are not finite.
    """

    estimates: int = 0
    acted: int = 0
    limited: int = 0
    not_usable: int = 0
    not_felt: int = 0
    not_finite: int = 0
    silences: int = 0
    rejected: int = 0
    ignored: int = 0


class ControlledCorner:
    """One damper and the body above it; final.

    Attributes:
        tally: counts.
        desired: N, the last desired force; NaN if there is none.
    """

    def __init__(self, controller: CornerController, settings: ControllerSettings) -> None:
        self.tally, self.desired = CornerTally(), float("nan")
        self._controller, self._settings = controller, settings
        self._sample = np.zeros(ROWS)
        self._stamp = 0
        self._felt = self._added = 0.0
        self._felt_at = self._added_at = self._estimated_at = float("-inf")
        self._is_silent = False

    def add_acceleration(self, acceleration: float, now: float) -> None:
        """Takes the body's acceleration in m/s^2; the last good one is kept if this one is implausible."""
        if not abs(acceleration) <= MOST_ACCELERATION:
            self.tally.rejected += 1
            return
        self._felt, self._felt_at = acceleration, now

    def add_force(self, force: float, now: float) -> None:
        """Takes a force in N that another controller adds; the last one is kept if this one is not finite."""
        if not isfinite(force):
            self.tally.ignored += 1
            return
        self._added, self._added_at = force, now

    def step(self, stamp: int, motion: tuple[float, float, float], status: int, now: float) -> Action | None:
        """Desired force and current for an estimate; None if it is not usable.

        Args:
            stamp: ns.
            motion: displacement, velocity and acceleration of the damper, SI.
            status: of the estimate.
            now: s.
        """
        self.tally.estimates += 1
        self._estimated_at, self._is_silent = now, False
        action = self._decide(stamp, motion, status, now)
        self.tally.acted += action is not None
        self.desired = float("nan") if action is None else action.wanted
        return action

    def is_silent(self, now: float) -> bool:
        """Whether no estimate has come for too long."""
        is_silent = not self._is_recent(self._estimated_at, now)
        self.tally.silences += is_silent and not self._is_silent
        self._is_silent = is_silent
        return is_silent

    def _decide(self, stamp: int, motion: tuple[float, float, float], status: int, now: float) -> Action | None:
        if status == STALE:  # repeated with its old stamp
            self.tally.not_usable += 1
            return None
        if not self._is_recent(self._felt_at, now):
            self._stamp = 0
            self.tally.not_felt += 1
            return None
        step = (stamp - self._stamp) / NANOSECONDS
        self._stamp = stamp
        self._sample[DT] = step if 0.0 < step <= MAX_GAP else 0.0
        self._sample[X], self._sample[V], self._sample[A] = motion
        added = self._added if self._is_recent(self._added_at, now) else 0.0
        limit = self._settings.extrapolating_limit if status == EXTRAPOLATING else float("inf")
        # The law processes every sample, so that it knows the body's velocity when the status is good again.
        action = self._controller.step(self._sample, self._felt, added, limit)
        if status not in (GOOD, EXTRAPOLATING):
            self.tally.not_usable += 1
            return None
        if not isfinite(action.wanted):
            self.tally.not_finite += 1
            return None
        self.tally.limited += abs(action.wanted - self._settings.rest_force) >= limit
        return action

    def _is_recent(self, at: float, now: float) -> bool:
        """Everything before a clock was set back is old."""
        return 0.0 <= now - at <= self._settings.timeout
