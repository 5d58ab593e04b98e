"""The live residual of one damper: estimate less measured force, as soon as the gauge reaches the estimate.

The gauge is linear between its samples and passes the same causal filter as the displacement, over the stamps of both,
so that the delay cancels: offline and live the numbers are the same. Estimates and gauge samples wait for each other;
each series is in order of its stamps.
"""

from dataclasses import dataclass

import numpy as np

from damper_estimator.runtime.estimates import Estimates
from damper_estimator.signals.admission import ACCEPTED, DUPLICATE, STEP_BACK, Admission
from damper_estimator.signals.butterworth import STATE_SIZE, differentiate
from damper_estimator.signals.signal_map import DamperSignals

_PATIENCE = 1_000_000_000  # ns that one side waits for the other


@dataclass(frozen=True)
class Residuals:
    """Residuals in order of stamp.

    Attributes:
        stamp: (n,) int64 ns, of the displacement.
        log: (n,) int64 ns, when the displacement was recorded.
        value: (n,) N, model - measured.
    """

    stamp: np.ndarray
    log: np.ndarray
    value: np.ndarray


class ResidualLine:
    """The running state of one damper's residual."""

    def __init__(self, signals: DamperSignals, cutoff: float, max_gap: float):
        """``signals`` of the damper, ``cutoff`` in Hz (0: unfiltered), ``max_gap`` in s."""
        self._signals, self._cutoff = signals, cutoff
        self._admission = Admission(max_gap)
        self._filter = np.zeros(STATE_SIZE)
        self._last: int | None = None
        self._origin: int | None = None
        # Rows: stamp, log, whether a stretch starts; and x, force.
        self._estimates = (np.zeros((3, 0), np.int64), np.zeros((2, 0)))
        # Rows: stamp, number of the stretch; and the force.
        self._gauge = (np.zeros((2, 0), np.int64), np.zeros(0))
        self._stretch = 0

    def block(self, estimates: Estimates | None, log: np.ndarray, stamp: np.ndarray, force: np.ndarray) -> Residuals:
        """Residuals that can now be computed.

        Args:
            estimates: new ones, or None; ``log`` (n,) ns belongs to them.
            stamp, force: (m,) ns and N, new gauge samples in order of arrival.
        """
        if estimates is not None:
            self._queue_estimates(estimates, log)
        self._queue_gauge(stamp - round(self._signals.force.skew * 1e9), force)
        parts = []
        while (part := self._advance()) is not None:
            parts.append(part)
        self._forget()
        if not parts:
            none = np.zeros(0, np.int64)
            return Residuals(none, none, np.zeros(0))
        return Residuals(
            *(np.concatenate([getattr(part, name) for part in parts]) for name in ("stamp", "log", "value"))
        )

    def _queue_estimates(self, estimates: Estimates, log: np.ndarray) -> None:
        kinematics = estimates.kinematics
        if np.any(estimates.verdict == STEP_BACK):
            # The waiting estimates belong to the time before the clock was set back.
            self._estimates = (np.zeros((3, 0), np.int64), np.zeros((2, 0)))
            first = int(np.flatnonzero(estimates.verdict[estimates.verdict < DUPLICATE] == STEP_BACK)[-1])
        else:
            first = 0
        whole = np.stack([kinematics.stamp, log, (kinematics.dt <= 0.0).astype(np.int64)])[:, first:]
        real = np.stack([kinematics.displacement, estimates.force])[:, first:]
        self._estimates = (np.hstack([self._estimates[0], whole]), np.hstack([self._estimates[1], real]))

    def _queue_gauge(self, stamp: np.ndarray, force: np.ndarray) -> None:
        verdict, _ = self._admission.block(stamp, force)
        good = verdict < DUPLICATE
        if np.any(verdict == STEP_BACK):
            self._gauge = (np.zeros((2, 0), np.int64), np.zeros(0))
            good[: np.flatnonzero(verdict == STEP_BACK)[-1]] = False
        stretch = self._stretch + np.cumsum(verdict[good] != ACCEPTED)
        self._stretch = int(stretch[-1]) if stretch.size else self._stretch
        rows = np.stack([stamp[good], stretch])
        self._gauge = (np.hstack([self._gauge[0], rows]), np.concatenate([self._gauge[1], force[good]]))

    def _advance(self) -> Residuals | None:
        """Processes the oldest stretch of the gauge as far as both sides reach; None if nothing can be computed."""
        (estimate_stamp, log, starts), (displacement, modelled) = self._estimates
        (gauge_stamp, number), gauge = self._gauge
        if not gauge_stamp.size or not estimate_stamp.size:
            return None
        size = int(np.searchsorted(number, number[0], side="right"))
        closed = size < number.size
        limit = min(int(gauge_stamp[size - 1]), int(estimate_stamp[-1]))
        first = max(int(gauge_stamp[0]), self._last + 1 if self._last is not None else int(gauge_stamp[0]))
        inside = (estimate_stamp >= first) & (estimate_stamp <= limit)
        residuals = None
        if limit >= first:
            value = self._filtered(
                gauge_stamp[:size], gauge[:size], estimate_stamp[inside], starts[inside] > 0, first, limit
            )
            measured = value - self._signals.spring_rate * displacement[inside] - self._signals.preload
            residuals = Residuals(estimate_stamp[inside], log[inside], modelled[inside] - measured)
        finished = closed and estimate_stamp[-1] >= gauge_stamp[size - 1]
        if not finished and residuals is None:
            return None
        self._drop(
            size if finished else int(np.searchsorted(gauge_stamp[:size], limit, side="right")) - 1, finished, limit
        )
        return residuals or Residuals(estimate_stamp[:0], log[:0], np.zeros(0))

    def _filtered(
        self, stamp: np.ndarray, value: np.ndarray, sought: np.ndarray, starts: np.ndarray, first: int, limit: int
    ) -> np.ndarray:
        """The filtered gauge at the ``sought`` stamps; the filter runs over both sides' stamps from first to limit."""
        if self._origin is None:
            self._origin = int(stamp[0])
        grid = np.union1d(stamp[(stamp >= first) & (stamp <= limit)], sought)
        dt = np.diff(grid, prepend=grid[:1] if self._last is None else [self._last]) / 1e9
        dt[np.searchsorted(grid, sought[starts])] = 0.0
        raw = np.interp((grid - self._origin).astype(float), (stamp - self._origin).astype(float), value)
        filtered, rate, second = np.empty((3, grid.size))
        differentiate(self._cutoff, dt, raw, self._filter, filtered, rate, second)
        return filtered[np.searchsorted(grid, sought)]

    def _drop(self, used: int, finished: bool, limit: int) -> None:
        """Drops the processed samples; the last gauge sample before the limit stays for interpolation."""
        used = max(used, 0)
        self._gauge = (self._gauge[0][:, used:], self._gauge[1][used:])
        self._last = None if finished else limit
        rest = self._estimates[0][0] > limit
        self._estimates = (self._estimates[0][:, rest], self._estimates[1][:, rest])

    def _forget(self) -> None:
        """Drops what has waited longer than a second, so that memory stays bounded if one side is silent."""
        (estimate_stamp, *_), _ = self._estimates
        (gauge_stamp, _), _ = self._gauge
        newest = max((int(s[-1]) for s in (estimate_stamp, gauge_stamp) if s.size), default=0)
        late = estimate_stamp > newest - _PATIENCE
        self._estimates = (self._estimates[0][:, late], self._estimates[1][:, late])
        fresh = gauge_stamp > newest - _PATIENCE
        self._gauge = (self._gauge[0][:, fresh], self._gauge[1][fresh])
