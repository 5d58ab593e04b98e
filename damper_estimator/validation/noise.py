"""The error that a perfect model would still show: gauge noise, and displacement noise carried through filter and
damper. It belongs to the recording: no model takes part in it.

Noise is white, and quantised. Its density comes from the part of a channel that neighbouring samples do not predict:
each sample less the cubic through two on either side, at the times of their stamps, so that neither motion nor uneven
sampling nor a lost sample counts. Motion and force at such high frequencies are excluded in two ways: by the quietest
second, and by the lowest part of the spectrum above a fifth of the rate, over the gain of the cubic; the smaller result
is used. A quantised channel that stands still for a second has less noise than would move it.

Both channels are then simulated: noise and quantisation are added to the signal without them (``denoised``). Those of
the gauge are carried through filter and band, those of the displacement through filter, a form-free damper behind a
spring (``sprung``), and band; without the spring, which is the compliance of oil and mount, steep curves would carry
too much. Quantisation coarser than the noise is not white; its error follows the signal.

While a damper moves, this is the perfect model's error; at rest it may be wrong by a multiple, for no motion shows how
friction is held.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy import signal
from scipy.special import ndtri

from damper_estimator.signals import Measurement
from damper_estimator.signals.butterworth import STATE_SIZE, differentiate
from damper_estimator.signals.layout import A, V, X
from damper_estimator.signals.rest import Rest, find_rests, quantum
from damper_estimator.validation.denoised import denoised, period_of
from damper_estimator.validation.rest_density import rest_density
from damper_estimator.validation.sprung import sprung

_KEPT = "_noise_floor"
_LEAST_SAMPLES = 100
_MOST_SAMPLES = 100_000  # more take longer without a better result
_LONGEST = 400_000  # samples of a signal whose noise is estimated
_SEGMENT = 512
_CUBIC = np.array([1.0, -4.0, 6.0, -4.0, 1.0]) / 6.0  # evenly sampled
_LOWEST, _HIGHEST, _PARTS = 0.2, 0.49, 6  # of the rate
_FAR = 3.0  # neighbours whose steps are longer than this many ordinary ones are no neighbours
_QUIET = 0.4  # s
_DITHERED = 0.3  # share of samples that must change in a quiet second: else its quantisation hides the noise
_ALIKE = 2.0  # variances of quiet seconds over that of the quietest
_COARSE = 2.0  # quantum over noise above which the signal is reconstructed from the moments of its changes
_LEAST_RATE = 400.0  # Hz, of the samples that the damper is fitted to, if there are as many
_SHARES = (0.0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.5, 0.7)  # noise over quantum that is tried then


def noise_floor(measurement: Measurement) -> float:
    """RMS error in N at the comparison's bandwidth; NaN where the recording is too short."""
    kept = vars(measurement)  # every model that is compared with it asks again
    if _KEPT not in kept:
        kept[_KEPT] = _floor(measurement)
    return kept[_KEPT]


def _floor(measurement: Measurement) -> float:
    measurement = measurement.part(0, min(len(measurement.kinematics), _MOST_SAMPLES))
    if not measurement.judged.any():
        return float("nan")
    # The errors are independent, so their squares add up.
    rests = find_rests(measurement.kinematics.stamp, measurement.raw_displacement, *_gauge(measurement))
    squares = [_gauge_square(measurement, rests), _damper_square(measurement, rests)]
    return float(np.sqrt(sum(squares)))


def noise_density(stamp: np.ndarray, value: np.ndarray) -> float:
    """One-sided power density of the white part in unit^2/Hz; NaN for fewer than a hundred samples in a row.

    Args:
        stamp: (n,) int64 ns, rising.
        value: (n,).
    """
    found = _moving_density(stamp, value)
    if not np.isfinite(found):
        return found
    step, rate = quantum(value), 1.0 / period_of(stamp)
    return min(found, 2.0 / rate * (_held(value, rate) ** 2 + step**2 / 12.0))


def _moving_density(stamp: np.ndarray, value: np.ndarray) -> float:
    """As ``noise_density``, but for what a quantised value shows by keeping still."""
    step = np.diff(stamp)
    good = np.concatenate([[True], step > 0])
    stamp, value = stamp[good], value[good]
    if value.size < _LEAST_SAMPLES:
        return float("nan")
    time = (stamp - stamp[0]) / 1e9
    period = float(np.median(np.diff(time)))
    residual, whole = _unpredicted(time, value, period)
    if np.count_nonzero(whole) < _LEAST_SAMPLES:
        return float("nan")
    changes, rate = (value[2:-2] != value[1:-3])[whole], 1.0 / period
    return min(_lowest_part(residual[whole], rate), _quietest(residual[whole], changes, rate))


def _unpredicted(time: np.ndarray, value: np.ndarray, period: float) -> tuple[np.ndarray, np.ndarray]:
    """Each sample less the cubic through its four neighbours, and where these are near; both (n - 4,)."""
    centre = time[2:-2]
    around = [time[i : time.size - 4 + i] - centre for i in (0, 1, 3, 4)]
    predicted = np.zeros(centre.size)
    for i, node in enumerate(around):
        weight = np.ones(centre.size)
        for j, other in enumerate(around):
            if j != i:
                weight *= other / (other - node)
        place = (0, 1, 3, 4)[i]
        predicted += weight * value[place : value.size - 4 + place]
    return value[2:-2] - predicted, around[3] - around[0] < _FAR * 4.0 * period


def _lowest_part(residual: np.ndarray, rate: float) -> float:
    """From the part of the spectrum with the lowest density; corrected for chance by white noise of the same length."""
    return 2.0 / rate * _lowest(residual) / _lowest_of_white(residual.size)


@lru_cache(maxsize=64)
def _lowest_of_white(size: int) -> float:
    return _lowest(_white(size))


def _lowest(residual: np.ndarray) -> float:
    """Density at a rate of 1."""
    size = min(_SEGMENT, residual.size)
    density = signal.welch(residual, 1.0, nperseg=size, window="hann", detrend=False, average="median")[1]
    angle = 2.0 * np.pi * np.fft.rfftfreq(size)
    gain = 1.0 - (4.0 * np.cos(angle) - np.cos(2.0 * angle)) / 3.0
    edges = np.linspace(_LOWEST, _HIGHEST, _PARTS + 1) * 2.0 * np.pi
    parts = [(angle >= low) & (angle < high) for low, high in zip(edges, edges[1:], strict=False)]
    return float(min(np.mean(density[part] / gain[part] ** 2) for part in parts if part.any()))


def _white(size: int) -> np.ndarray:
    """(size,) white noise less its prediction."""
    return np.convolve(np.random.default_rng(0).standard_normal(size + 4), _CUBIC, mode="valid")


def _held(value: np.ndarray, rate: float) -> float:
    """Most noise (standard deviation) with which a quantised value half-way between two edges changes as seldom as in
    some part of a second; infinite if it never keeps still.
    """
    size, step = max(round(_QUIET * rate), 64), quantum(value)
    changes = np.diff(value) != 0.0
    if step <= 0.0 or changes.size < 2 * size:
        return float("inf")
    sums = np.concatenate([[0], np.cumsum(changes)])
    share = max(float((sums[size:] - sums[:-size]).min()), 1.0) / size
    # Each sample beyond an edge makes two changes, and there are two edges.
    return -0.5 * step / float(ndtri(0.25 * share)) if share < _DITHERED else float("inf")


def _quietest(residual: np.ndarray, changes: np.ndarray, rate: float) -> float:
    """From the second with the smallest variance; corrected for chance by white noise of the same length."""
    size = max(round(_QUIET * rate), 64)
    if residual.size < 2 * size:
        return float("inf")
    starts = np.arange(0, residual.size - size + 1, size // 2)

    def means(values: np.ndarray) -> np.ndarray:
        sums = np.concatenate([[0.0], np.cumsum(values)])
        return (sums[starts + size] - sums[starts]) / size

    chosen = means(changes.astype(float)) >= _DITHERED
    if not chosen.any():
        return float("inf")
    variance, chance = means(residual**2)[chosen], means(_white(residual.size) ** 2)
    quiet = np.sort(variance)[: np.count_nonzero(variance <= _ALIKE * variance.min())]
    # Of so many quiet seconds in a row the mean is known; chance picked the lowest of all.
    alike = float(np.mean(chance[: quiet.size][chance[: quiet.size] <= _ALIKE * chance[: quiet.size].min()]))
    return 2.0 * float(quiet.mean() / alike) / rate


def white_density(value: np.ndarray, rate: float) -> float:
    """Density of an evenly sampled signal, see ``noise_density``, from the first part of a long one; ``rate`` in Hz."""
    if not np.isfinite(rate) or rate <= 0.0:
        return float("nan")
    value = value[:_LONGEST]
    return noise_density(np.round(np.arange(value.size) * 1e9 / rate).astype(np.int64), value)


@dataclass(frozen=True)
class _Channel:
    """The parts of a channel: (n,) signal without noise and steps, standard deviation of its white part, quantum.

    ``level`` is any of the values that quantisation leaves. They are set a quarter of a step off, so that a value at
    rest on one of them, or half-way between two at a reversal, is a quarter of a step away from an edge.
    """

    smooth: np.ndarray
    deviation: float
    step: float
    level: float

    def disturbed(self, seed: int) -> np.ndarray:
        """(n,) the signal with new noise and quantisation of the same size."""
        noisy = self.smooth + self.deviation * np.random.default_rng(seed).standard_normal(self.smooth.size)
        if self.step <= 0.0:
            return noisy
        level = self.level + 0.25 * self.step
        return level + self.step * np.round((noisy - level) / self.step)

    def error(self, seed: int) -> np.ndarray:
        """(n,) the change by noise and quantisation."""
        return self.disturbed(seed) - self.smooth


def _channel(m: Measurement, rests: Sequence[Rest], stamp: np.ndarray, value: np.ndarray) -> _Channel | None:
    """The parts of a channel; None where too little is known of it."""
    density = noise_density(stamp, value)
    if not np.isfinite(density):
        return None
    time = (stamp - m.kinematics.stamp[0]) / 1e9
    density = rest_density(rests, time, value, m.band or 0.5 * m.kinematics.rate, density)
    step = quantum(value)
    # One-sided density times half the rate.
    per_density = 0.5 / period_of(stamp)
    deviation = float(np.sqrt(max(per_density * density - step**2 / 12.0, 0.0)))
    if step <= _COARSE * deviation:
        return _Channel(denoised(stamp, value, density), deviation, step, float(value[0]))
    smooth = denoised(stamp, _without_steps(value), density)
    # Coarse steps are not white: search for the noise that reproduces the measured density.
    tried = step * np.array(_SHARES)
    level = float(value[0])
    made = [
        _moving_density(stamp, _Channel(smooth, tried_deviation, step, level).disturbed(2)) for tried_deviation in tried
    ]
    searched = np.interp(_moving_density(stamp, value), np.maximum.accumulate(made), tried)
    return _Channel(smooth, min(float(searched), _held(value, 1.0 / period_of(stamp))), step, level)


def _without_steps(value: np.ndarray) -> np.ndarray:
    """Straight lines between the moments at which a coarse signal changes."""
    changed = np.flatnonzero(np.diff(value))
    if changed.size < 2:
        return value
    return np.interp(np.arange(value.size), changed + 0.5, 0.5 * (value[changed] + value[changed + 1]))


def _gauge(m: Measurement) -> tuple[np.ndarray, np.ndarray]:
    """Stamps (k,) ns and values (k,) N of the gauge while there is displacement."""
    inside = _during(m)
    return (m.kinematics.stamp if m.gauge_stamp is None else m.gauge_stamp)[inside], m.gauge[inside]


def _during(m: Measurement) -> slice:
    displacement_stamp = m.kinematics.stamp
    stamp = displacement_stamp if m.gauge_stamp is None else m.gauge_stamp
    return slice(*np.searchsorted(stamp, [displacement_stamp[0], displacement_stamp[-1] + 1]).tolist())


def _gauge_square(m: Measurement, rests: Sequence[Rest]) -> float:
    """N^2, mean square in band of the filtered force's error due to noise and quantisation of the gauge."""
    channel = _channel(m, rests, *_gauge(m))
    if channel is None:
        return float("nan")
    error = np.zeros(m.gauge.size)
    error[_during(m)] = channel.error(0)
    return _square(m, m.as_gauge(error))


def _damper_square(m: Measurement, rests: Sequence[Rest]) -> float:
    """N^2, mean square in band of a perfect model's error due to noise and quantisation of the displacement."""
    k = m.kinematics
    channel = _channel(m, rests, k.stamp, m.raw_displacement)
    if channel is None:
        return float("nan")
    smooth, error = channel.smooth, channel.error(1)
    if channel.step <= _COARSE * channel.deviation:
        # Friction remembers where it started, and the error of that sample is known.
        starts = [part.start for part in k.stretches()]
        error[starts] = (m.raw_displacement - smooth)[starts]
    clean, noisy = k.block.copy(), k.block.copy()
    clean[[X, V, A]] = _filtered(m, smooth, smooth[0])
    noisy[[X, V, A]] = clean[[X, V, A]] + _filtered(m, error, 0.0)
    stride = max(int(k.rate / _LEAST_RATE), 1)
    seen, shaken = (replace(m, kinematics=replace(k, block=block)).thinned(stride) for block in (clean, noisy))
    damper = sprung(seen)
    return _square(seen, damper.force(shaken.kinematics.block) - damper.force(seen.kinematics.block))


def _square(m: Measurement, error: np.ndarray) -> float:
    return float(np.mean(m.in_band(error)[m.judged] ** 2))


def _filtered(m: Measurement, raw: np.ndarray, start: float) -> np.ndarray:
    """(3, n) displacement, velocity and acceleration of a raw displacement."""
    out = np.empty((3, raw.size))
    state = np.zeros(STATE_SIZE)
    state[[0, 3]] = start
    differentiate(m.cutoff, np.ascontiguousarray(m.kinematics.dt), raw, state, *out)
    return out
