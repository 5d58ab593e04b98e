"""Velocity by differentiating the displacement against velocity by integrating a measured acceleration.

Neither is the true one (black-box paper, section 2 and figure 1): the first carries the displacement's noise, the
second the accelerometer's zero. Motion slower than 0.5 Hz is removed from both here, where integration drifts. How far
they agree says how far the velocity can be trusted, and whether the accelerometer measures the same motion at all.
"""

from dataclasses import dataclass

import numpy as np

from damper_estimator.signals import Measurement, low_pass_zero_phase

SLOWEST = 0.5  # Hz; slower motion is removed from both
_EDGE = 1.0  # s at both ends of a stretch that the high-pass spoils


@dataclass(frozen=True)
class VelocityAgreement:
    """Both velocities above 0.5 Hz, and how they agree.

    Attributes:
        differentiated, integrated: (n,) m/s; NaN where the acceleration has a hole.
        compared: (n,) bool, samples that count.
        correlation: Pearson's.
        gain: of the integrated over the differentiated one, by least squares through zero; 1 where both are right.
        rms_difference: m/s.
        relative_difference: over the rms of the differentiated one.
    """

    differentiated: np.ndarray
    integrated: np.ndarray
    compared: np.ndarray
    correlation: float
    gain: float
    rms_difference: float
    relative_difference: float

    def record(self) -> dict[str, float]:
        """For JSON: the numbers."""
        return {
            "correlation": self.correlation,
            "gain": self.gain,
            "rms_difference_m_s": self.rms_difference,
            "relative_difference": self.relative_difference,
        }


def velocity_agreement(measurement: Measurement) -> VelocityAgreement | None:
    """Compares the two ways; None without an accelerometer, or where no stretch is longer than 2 s."""
    if measurement.acceleration is None:
        return None
    kinematics = measurement.kinematics
    integrated = np.full(len(kinematics), np.nan)
    differentiated = np.full(len(kinematics), np.nan)
    compared = np.zeros(len(kinematics), bool)
    for part in _whole(measurement):
        time, dt = kinematics.time[part], kinematics.dt[part].copy()
        dt[0] = 0.0
        a = measurement.acceleration[part]
        steps = 0.5 * (a[1:] + a[:-1]) * dt[1:]
        integrated[part] = _high_pass(dt, time, np.concatenate([[0.0], np.cumsum(steps)]))
        differentiated[part] = _high_pass(dt, time, kinematics.velocity[part])
        compared[part] = (time > time[0] + _EDGE) & (time < time[-1] - _EDGE)
    if not compared.any():
        return None
    d, i = differentiated[compared], integrated[compared]
    rms = float(np.sqrt(np.mean(d**2)))
    difference = float(np.sqrt(np.mean((i - d) ** 2)))
    square = float(d @ d)
    spread = float(d.std() * i.std())
    return VelocityAgreement(
        differentiated=differentiated,
        integrated=integrated,
        compared=compared,
        correlation=float(np.mean((d - d.mean()) * (i - i.mean())) / spread) if spread > 0.0 else float("nan"),
        gain=float(d @ i) / square if square > 0.0 else float("nan"),
        rms_difference=difference,
        relative_difference=difference / rms if rms > 0.0 else float("nan"),
    )


def _whole(measurement: Measurement) -> list[slice]:
    """Stretches without a hole in the acceleration."""
    parts = []
    for part in measurement.kinematics.stretches():
        there = np.isfinite(measurement.acceleration[part])
        edges = np.flatnonzero(np.diff(there.astype(np.int8), prepend=0, append=0))
        parts += [slice(part.start + int(a), part.start + int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]
    return [part for part in parts if part.stop - part.start > 2]


def _high_pass(dt: np.ndarray, time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Without straight drift (the accelerometer's zero, integrated) and without motion slower than ``SLOWEST``."""
    straight = values - np.polyval(np.polyfit(time - time[0], values, 1), time - time[0])
    return straight - low_pass_zero_phase(SLOWEST, dt, straight)
