"""A model's input from a recording or a live signal: blocks of samples, filtered and differentiated."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.signals.admission import DUPLICATE, Admission, Counts
from damper_estimator.signals.butterworth import STATE_SIZE, differentiate
from damper_estimator.signals.fusion import FUSION_SIZE, Fusion, fuse
from damper_estimator.signals.layout import COMMAND, DT, PRESSURE, ROWS, TEMPERATURE, A, T, V, X

WARM_UP = 0.2  # s after a reset in which estimates are not judged


@dataclass(frozen=True)
class Kinematics:
    """Samples of one damper in order of time.

    Attributes:
        stamp: (n,) int64 ns.
        block: (8, n) float64, contiguous, rows as in ``signals.layout``.
    """

    stamp: np.ndarray
    block: np.ndarray

    def __len__(self) -> int:
        return self.stamp.size

    @property
    def time(self) -> np.ndarray:
        """(n,) s since the first sample."""
        return self.block[T]

    @property
    def dt(self) -> np.ndarray:
        """(n,) s; 0 at a start."""
        return self.block[DT]

    @property
    def displacement(self) -> np.ndarray:
        """(n,) m, positive in extension."""
        return self.block[X]

    @property
    def velocity(self) -> np.ndarray:
        """(n,) m/s."""
        return self.block[V]

    @property
    def acceleration(self) -> np.ndarray:
        """(n,) m/s^2."""
        return self.block[A]

    @property
    def command(self) -> np.ndarray:
        """(n,) A, NaN if there is none."""
        return self.block[COMMAND]

    @property
    def temperature(self) -> np.ndarray:
        """(n,) deg C, NaN if there is none."""
        return self.block[TEMPERATURE]

    @property
    def pressure(self) -> np.ndarray:
        """(n,) Pa, NaN if there is none."""
        return self.block[PRESSURE]

    @property
    def rate(self) -> float:
        """Hz, from the steps inside the stretches; NaN for fewer than two samples."""
        inside = self.dt > 0.0
        return float(np.count_nonzero(inside) / self.dt[inside].sum()) if inside.any() else float("nan")

    def stretches(self) -> list[slice]:
        """The continuous parts between resets."""
        starts = np.flatnonzero(self.dt <= 0.0)
        return [slice(int(a), int(b)) for a, b in zip(starts, [*starts[1:], len(self)], strict=True)]

    def warm(self) -> np.ndarray:
        """(n,) bool: at least ``WARM_UP`` after the last reset."""
        warm = np.zeros(len(self), bool)
        for part in self.stretches():
            warm[part] = self.stamp[part] - self.stamp[part.start] >= round(WARM_UP * 1e9)
        return warm

    def select(self, part: slice) -> "Kinematics":
        """A part as a separate recording; its first sample is a start."""
        block = np.ascontiguousarray(self.block[:, part])
        if block.shape[1]:
            block[DT, 0] = 0.0
        return Kinematics(self.stamp[part], block)

    @staticmethod
    def joined(parts: Sequence["Kinematics"]) -> "Kinematics":
        """Parts in order of time as one recording with gaps."""
        if len(parts) == 1:
            return parts[0]
        return Kinematics(
            np.concatenate([p.stamp for p in parts] or [np.zeros(0, np.int64)]),
            np.concatenate([p.block for p in parts], axis=1) if parts else np.zeros((ROWS, 0)),
        )

    def thinned(self, stride: int) -> np.ndarray:
        """Positions of every ``stride``-th sample of each stretch."""
        return np.concatenate([np.arange(0)] + [np.arange(p.start, p.stop, stride) for p in self.stretches()])

    def at(self, places: np.ndarray) -> "Kinematics":
        """Only the samples at ``places`` (k,), rising; they stay filtered and differentiated at the full rate."""
        block = np.ascontiguousarray(self.block[:, places])
        since = np.diff(np.cumsum(self.dt)[places], prepend=0.0)
        block[DT] = np.where(block[DT] > 0.0, since, 0.0)
        return Kinematics(self.stamp[places], block)


class Differentiator:
    """Turns stamps and raw displacement into kinematics, sample by sample or in blocks of any size, with equal bits.

    Attributes:
        alone: (n,) uint8, 1 for the samples of the last block without acceleration.
    """

    def __init__(self, cutoff: float, max_gap: float, fusion: Fusion | None = None):
        """``cutoff`` in Hz (0: unfiltered), ``max_gap`` in s; ``fusion`` of accelerations, or None."""
        self._cutoff, self._noises = cutoff, None if fusion is None else fusion.noises()
        self._fused, self.alone = np.zeros(FUSION_SIZE), np.zeros(0, np.uint8)
        self._admission = Admission(max_gap)
        self._state = np.zeros(STATE_SIZE)
        self._origin: int | None = None

    def block(
        self,
        stamp: np.ndarray,
        displacement: np.ndarray,
        command: np.ndarray | float = np.nan,
        temperature: np.ndarray | float = np.nan,
        pressure: np.ndarray | float = np.nan,
        acceleration: np.ndarray | float = np.nan,
    ) -> tuple[Kinematics, np.ndarray]:
        """Kinematics of the good samples, and the verdict (n,) on every one.

        Args:
            stamp: (n,) int64 ns, in order of arrival.
            displacement: (n,) m.
            command, temperature, pressure: (n,) or one value, NaN if there is none.
            acceleration: the same, m/s^2, of the accelerometer; used with fusion.
        """
        verdict, dt = self._admission.block(stamp, displacement)
        good = verdict < DUPLICATE
        if not good.all():
            stamp, displacement, dt = stamp[good], displacement[good], dt[good]
            command, temperature, pressure, acceleration = (
                value[good] if np.ndim(value) else value for value in (command, temperature, pressure, acceleration)
            )
        if self._origin is None and stamp.size:
            self._origin = int(stamp[0])
        block = np.empty((ROWS, stamp.size))
        block[T] = (stamp - (self._origin or 0)) / 1e9
        block[DT] = dt
        differentiate(self._cutoff, dt, displacement, self._state, block[X], block[V], block[A])
        self.alone = np.zeros(stamp.size, np.uint8)
        if self._noises is not None:
            accelerations = np.ascontiguousarray(np.broadcast_to(acceleration, stamp.shape), float)
            fuse(
                self._noises,
                dt,
                displacement,
                accelerations,
                self._fused,
                block[X],
                block[V],
                block[A],
                self.alone,
            )
        block[COMMAND], block[TEMPERATURE], block[PRESSURE] = command, temperature, pressure
        return Kinematics(stamp, block), verdict

    def reset(self) -> None:
        """The next sample is a new start."""
        self._admission.reset()


def differentiate_recording(
    stamp: np.ndarray, displacement: np.ndarray, cutoff: float, max_gap: float, **slow: np.ndarray
) -> tuple[Kinematics, Counts]:
    """A whole recording at once: kinematics of the good samples and the counts of the others."""
    kinematics, verdict = Differentiator(cutoff, max_gap).block(stamp, displacement, **slow)
    return kinematics, Counts.of(verdict)
