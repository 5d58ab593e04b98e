"""The estimates against the strain gauges, live: residual messages, running error and drift. Independent of ROS.

Samples are collected as they come and compared a few times a second: gauge and displacement of the same instant arrive
one after the other anyway, and the estimates must not wait for the comparison.
"""

from collections.abc import Sequence

import numpy as np

from damper_estimator.node.displacement import JOINT_STATE, DisplacementInput
from damper_estimator.node.error_drift import Drift
from damper_estimator.node.wire import reader_of
from damper_estimator.recordings import joint_states
from damper_estimator.runtime import (
    ABSENT,
    FIELDS,
    SLOW,
    WARMING_UP,
    Estimates,
    ResidualLine,
    Residuals,
    group_equal_keys,
)
from damper_estimator.signals import DamperSignals, Kinematics
from damper_estimator.signals.admission import ACCEPTED, DUPLICATE
from damper_estimator.signals.layout import DT, ROWS, A, V, X

_SILENT = 40  # comparisons without a sample of a gauge until estimates are no longer compared
CAPACITY = 2048  # samples between two comparisons; more are not compared
_X, _V, _A = (FIELDS.index(name) for name in ("displacement", "velocity", "acceleration"))
_NO_STAMPS = np.zeros(0, np.int64)


class GaugeInput:
    """One topic of measured forces, of one or more dampers; final."""

    def __init__(self, signals: Sequence[DamperSignals]) -> None:
        """Raises InputError if a field path does not fit the message type."""
        self._channels = [damper.force for damper in signals]
        self._reader = reader_of("force", JOINT_STATE, self._channels)
        self._stamps = np.zeros(CAPACITY, np.int64)
        self._values = np.full((CAPACITY, len(signals)), np.nan)
        self._present = np.zeros((CAPACITY, len(signals)), bool)
        self._count = 0

    def take(self, data: bytes) -> None:
        """Keeps the values of one message until they are compared."""
        reading = self._reader.read(data)
        if self._count < CAPACITY:
            self._stamps[self._count] = reading.stamp
            self._values[self._count] = reading.values
            self._present[self._count] = reading.present
            self._count += 1

    @property
    def has_samples(self) -> bool:
        """Whether there are samples since the last comparison."""
        return self._count > 0

    def drain(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Stamps (n,) ns and SI values (n,) by damper since the last call."""
        count, self._count = self._count, 0
        stamps, values, present = (part[:count].copy() for part in (self._stamps, self._values, self._present))
        return [
            (stamps[present[:, d]], channel.value(values[present[:, d], d])) for d, channel in enumerate(self._channels)
        ]


class EstimateBuffer:
    """The estimates of one displacement topic since the last comparison; final."""

    def __init__(self, source: DisplacementInput) -> None:
        self._source = source
        self._count = 0
        self._allocate()

    def _allocate(self) -> None:
        k = len(self._source.line.names)
        self._stamps = np.zeros(CAPACITY, np.int64)
        self._verdicts, self._status = np.zeros((CAPACITY, k), np.int64), np.zeros((CAPACITY, k), np.uint8)
        self._numbers, self._modelled = np.zeros((CAPACITY, len(FIELDS), k)), np.zeros((CAPACITY, k))

    def keep(self, stamp: int) -> None:
        """Keeps the line's latest estimates."""
        line = self._source.line
        if self._verdicts.shape[1] != len(line.names):
            self._allocate()
            self._count = 0
        if self._count < CAPACITY:
            self._stamps[self._count] = stamp
            answered = line.output
            self._verdicts[self._count], self._status[self._count] = answered.verdict[0], answered.status[0]
            self._numbers[self._count], self._modelled[self._count] = answered.numbers[0], answered.modelled[0]
            self._count += 1

    def trim(self) -> None:
        """Drops all but the newest, when half full: those that the first samples of a gauge will be compared with."""
        if self._count > CAPACITY // 2:
            kept = slice(self._count - CAPACITY // 4, self._count)
            for part in (self._stamps, self._verdicts, self._status, self._numbers, self._modelled):
                part[: CAPACITY // 4] = part[kept]
            self._count = CAPACITY // 4

    def drain(self) -> list[Estimates]:
        """The estimates of each damper since the last call."""
        count, self._count = self._count, 0
        return [self._of(d, count) for d in range(self._verdicts.shape[1])]

    def _of(self, d: int, count: int) -> Estimates:
        verdict = self._verdicts[:count, d]
        came = verdict > ABSENT
        verdict = verdict[came]
        good = came & (self._verdicts[:count, d] < DUPLICATE)
        numbers = self._numbers[:count, :, d][good]
        block = np.full((ROWS, numbers.shape[0]), np.nan)
        block[X], block[V], block[A] = numbers[:, _X], numbers[:, _V], numbers[:, _A]
        block[DT] = np.where(verdict[verdict < DUPLICATE] == ACCEPTED, 1.0, 0.0)  # only zero or not matters
        modelled, status = self._modelled[:count, d][good], self._status[:count, d][good]
        force = np.where(np.isfinite(modelled), modelled, np.nan)
        return Estimates(Kinematics(self._stamps[:count][good], block), force, force, force, status, verdict)


class Comparison:
    """All dampers on one displacement topic against their gauges; final.

    Attributes:
        drifts: by damper.
    """

    def __init__(self, source: DisplacementInput, cutoff: float, max_gap: float, window: float, factor: float) -> None:
        """``cutoff`` in Hz, ``max_gap`` and ``window`` in s, ``factor`` as in `Drift`."""
        self._source = source
        self._settings = (cutoff, max_gap, window, factor)
        self.buffer = EstimateBuffer(source)
        self.drifts: dict[str, Drift] = {}
        self._silent = 0
        self._lines: dict[str, ResidualLine] = {}
        self._motion: dict[str, tuple[np.ndarray, ...]] = {}

    def compare(self, gauges: dict[str, tuple[np.ndarray, np.ndarray]]) -> list[bytes]:
        """The residual messages that are now complete; ``gauges`` are new samples by damper."""
        if not self._has_gauge(gauges):
            self.buffer.trim()
            return []
        cutoff, max_gap, window, factor = self._settings
        residuals: dict[str, Residuals] = {}
        for estimator, estimates in zip(self._source.estimators, self.buffer.drain(), strict=False):
            name = estimator.name
            stamp, force = gauges.get(name, (_NO_STAMPS, np.zeros(0)))
            if name not in self._lines:  # also before its gauge, whose first samples may arrive after the estimates
                self._lines[name] = ResidualLine(estimator.signals, cutoff, max_gap)
            if stamp.size and name not in self.drifts:
                self.drifts[name] = Drift(name, window, factor)
            residuals[name] = self._lines[name].block(estimates, estimates.kinematics.stamp, stamp, force)
            self._judge(name, estimates, residuals[name])
        messages = []
        for stamp, rows in group_equal_keys({name: residual.stamp for name, residual in residuals.items()}):
            effort = np.stack([residuals[name].value[row] for name, row in rows.items()], axis=1)
            messages += joint_states(list(rows), stamp, effort=effort)
        return messages

    def _has_gauge(self, gauges: dict[str, tuple[np.ndarray, np.ndarray]]) -> bool:
        """Whether a gauge was received in the last two seconds."""
        names = [estimator.name for estimator in self._source.estimators]
        is_received = any(gauges[name][0].size for name in names if name in gauges)
        self._silent = 0 if is_received else self._silent + 1
        return self._silent < _SILENT

    def _judge(self, name: str, estimates: Estimates, residuals: Residuals) -> None:
        """Passes the residuals of settled estimates to the damper's drift."""
        new = (estimates.kinematics.stamp, estimates.force, estimates.kinematics.velocity,
               estimates.kinematics.displacement, estimates.status.astype(float))  # fmt: skip
        kept = self._motion.get(name, tuple(part[:0] for part in new))
        stamp, force, velocity, displacement, status = (
            np.concatenate([old, added])[-CAPACITY:] for old, added in zip(kept, new, strict=True)
        )
        self._motion[name] = (stamp, force, velocity, displacement, status)
        rising = bool(np.all(np.diff(stamp) > 0))
        if not residuals.stamp.size or not rising:
            if not rising:
                self._motion[name] = new
            return
        row = np.clip(np.searchsorted(stamp, residuals.stamp), 0, stamp.size - 1)
        settled = (stamp[row] == residuals.stamp) & (status[row] != WARMING_UP)
        row, value = row[settled], residuals.value[settled]
        damper = self._source.line.names.index(name)
        temperature = float(self._source.line.records["held"][damper, SLOW.index("temperature")])
        self.drifts[name].add(stamp[row], value, force[row] - value, velocity[row], displacement[row], temperature)
        last = int(residuals.stamp[-1])
        self._motion[name] = tuple(part[stamp > last] for part in self._motion[name])
