"""The error that a perfect model would still show: gauge noise, and displacement noise carried through filter and
model.

Noise is taken as white. Its density comes from the quietest part of the spectrum above the comparison band, where a
damper's
force and motion have little left: an estimate from above where they have more, from below where the logger itself
filtered. Gauge noise then passes both low-passes (spectrally); displacement noise is carried by running filter and
model on the motion with a second helping of the same noise.
"""

import numpy as np
from scipy import signal

from damper_estimator.model import DamperModel
from damper_estimator.signals import Measurement
from damper_estimator.signals.butterworth import STATE_SIZE, differentiate
from damper_estimator.signals.layout import A, V, X

_SEGMENT = 512
_LEAST_SAMPLES = 2 * _SEGMENT
_MOST_SAMPLES = 200_000  # more would only take longer


def noise_floor(model: DamperModel, measurement: Measurement) -> float:
    """RMS error in N at the comparison's bandwidth; NaN where the rate leaves nothing to see above the band."""
    rate = measurement.kinematics.rate
    covered = max(measurement.counts.samples, 1)
    gauge_rate = rate * measurement.gauge.size / covered
    gauge = white_density(measurement.gauge, gauge_rate, measurement.band)
    displacement = white_density(measurement.raw_displacement, rate, measurement.band)
    if not np.isfinite(gauge) or not np.isfinite(displacement):
        return float("nan")
    through_gauge = gauge * _equivalent_bandwidth(measurement.cutoff, measurement.band, gauge_rate / 2.0)
    through_model = _carried(model, measurement, np.sqrt(displacement * rate / 2.0))
    return float(np.sqrt(through_gauge + through_model))


def white_density(value: np.ndarray, rate: float, band: float) -> float:
    """One-sided power density of the white part, unit^2/Hz, from above ``band``; NaN where that cannot be seen."""
    lowest = max(1.5 * band, 0.15 * rate)
    if value.size < _LEAST_SAMPLES or not np.isfinite(rate) or lowest > 0.4 * rate:
        return float("nan")
    frequency, density = signal.welch(value, rate, nperseg=_SEGMENT, window="blackmanharris", detrend="constant")
    edges = np.linspace(lowest, 0.48 * rate, 5)
    parts = [density[(frequency >= low) & (frequency < high)] for low, high in zip(edges, edges[1:], strict=False)]
    return float(min(np.median(part) for part in parts if part.size))


def _equivalent_bandwidth(cutoff: float, band: float, top: float) -> float:
    """Hz; integral of the squared gain of the causal low-pass and of the zero-phase one up to ``top``."""
    frequency = np.linspace(0.0, top, 2000)
    gain = np.ones_like(frequency)
    if cutoff > 0.0:
        gain /= 1.0 + (frequency / cutoff) ** 6
    if band > 0.0:
        gain /= (1.0 + (frequency / band) ** 6) ** 2
    return float(np.sum((gain[1:] + gain[:-1]) / 2.0) * (frequency[1] - frequency[0]))


def _carried(model: DamperModel, measurement: Measurement, deviation: float) -> float:
    """Mean square, N^2, of what displacement noise of this deviation (m) does to the modelled force in band."""
    measurement = measurement.part(0, min(len(measurement.kinematics), _MOST_SAMPLES))
    kinematics = measurement.kinematics
    noise = deviation * np.random.default_rng(0).standard_normal(len(kinematics))
    x, v, a = np.empty((3, noise.size))
    differentiate(measurement.cutoff, np.ascontiguousarray(kinematics.dt), noise, np.zeros(STATE_SIZE), x, v, a)
    shaken = kinematics.block.copy()
    shaken[X] += x
    shaken[V] += v
    shaken[A] += a
    change = model.force(shaken) - model.force(kinematics.block)
    judged = measurement.judged & np.isfinite(change)
    carried = measurement.in_band(np.where(np.isfinite(change), change, 0.0))
    return float(np.mean(carried[judged] ** 2)) if judged.any() else 0.0
