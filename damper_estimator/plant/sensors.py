"""Imperfect sensors: a logger's recording of a simulated record."""

from dataclasses import dataclass

import numpy as np

from damper_estimator.plant.simulation import Truth

SLOW_RATE = 10.0
"""Hz, temperature channel."""


@dataclass(frozen=True)
class Sensors:
    """Measurement chain; raw force: gain (F + (k + dk) x + preload) + offset + drift + noise, late and quantised."""

    rate: float = 500.0  # Hz
    displacement_noise: float = 1.2e-5  # m, rms
    displacement_step: float = 1.0e-5  # m, quantisation
    force_noise: float = 5.0  # N, rms
    force_step: float = 1.0  # N, quantisation
    force_offset: float = 0.0  # N
    force_gain: float = 1.0  # 1
    force_drift: float = 2.0  # N, amplitude of a slow wander of the gauge's zero
    saturation: float = np.inf  # N, the gauge clips at it
    skew: float = 0.0  # s, positive where force is late
    clock_jitter: float = 4.0e-5  # s rms, unevenness of the sampling, included in the stamps
    stamp_jitter: float = 1.0e-5  # s rms, error of the stamps
    latency: float = 3.0e-4  # s, mean from stamp to arrival
    drop_out: float = 2.0e-4  # probability that a message is lost
    spring_rate: float = 0.0  # N/m, parallel coil spring in the gauge's force, as the signal map states it
    spring_rate_error: float = 0.0  # N/m, true rate less the stated one
    preload: float = 0.0  # N, the spring's force at displacement 0 (negative: compressed)
    temperature_noise: float = 0.1  # K, rms


@dataclass(frozen=True)
class Channel:
    """Messages of one topic in order of arrival: ``log`` and ``stamp`` (n,) int64 ns from the start, ``value`` (n,)."""

    log: np.ndarray
    stamp: np.ndarray
    value: np.ndarray


@dataclass(frozen=True)
class Sensed:
    """A recording; ``true_force`` (N) and ``true_displacement`` (m) are noise-free, at displacement's stamps."""

    displacement: Channel
    force: Channel
    current: Channel
    temperature: Channel
    true_displacement: Channel
    true_force: Channel


def ideal_force(truth: Truth, sensors: Sensors) -> np.ndarray:
    """The damper's force in N, (n,), from a noise-free chain with these errors.

    The stated spring is subtracted. It includes gain, offset, skew and the spring rate's error, not noise, drift,
    quantisation and loss.
    """
    late = np.interp(truth.time - sensors.skew, truth.time, truth.force)
    travel = np.interp(truth.time - sensors.skew, truth.time, truth.drive.displacement)
    return sensors.force_gain * (late + sensors.spring_rate_error * travel) + sensors.force_offset


def measure(truth: Truth, sensors: Sensors, seed: int, clock_seed: int | None = None) -> Sensed:
    """Samples a record with imperfect sensors.

    Dampers with the same ``clock_seed`` (default: ``seed``) and length have the same stamps and can share messages.
    """
    rng = np.random.default_rng([seed, 1])
    clock = np.random.default_rng([seed if clock_seed is None else clock_seed, 2])
    seconds = truth.time[-1]
    taken, stamp, log, kept = _clock(sensors, sensors.rate, seconds, clock)
    force_taken, force_stamp, force_log, force_kept = _clock(sensors, sensors.rate, seconds, clock)
    slow_taken, slow_stamp, slow_log, slow_kept = _clock(sensors, min(SLOW_RATE, sensors.rate), seconds, clock)

    def at(moment: np.ndarray, values: np.ndarray) -> np.ndarray:
        return np.interp(moment, truth.time, values)

    travel = at(taken, truth.drive.displacement)
    noisy = _quantised(travel + sensors.displacement_noise * rng.standard_normal(taken.size), sensors.displacement_step)
    force = _gauge(truth, sensors, force_taken, rng)
    warm = at(slow_taken, truth.temperature) + sensors.temperature_noise * rng.standard_normal(slow_taken.size)
    held = truth.drive.current[np.searchsorted(truth.time, taken, side="right") - 1]  # commands change in steps
    return Sensed(
        displacement=Channel(log[kept], stamp[kept], noisy[kept]),
        force=Channel(force_log[force_kept], force_stamp[force_kept], force[force_kept]),
        current=Channel(log[kept], stamp[kept], held[kept]),
        temperature=Channel(slow_log[slow_kept], slow_stamp[slow_kept], np.round(warm, 2)[slow_kept]),
        true_displacement=Channel(log[kept], stamp[kept], travel[kept]),
        true_force=Channel(log[kept], stamp[kept], at(taken, truth.force)[kept]),
    )


def _clock(
    sensors: Sensors, rate: float, seconds: float, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Moments of sampling (s), stamps and arrivals (ns), and which messages arrived; all (n,)."""
    period = 1.0 / rate
    count = int(seconds * rate)
    uneven = np.clip(sensors.clock_jitter * rng.standard_normal(count), -0.3 * period, 0.3 * period)
    wrong = np.clip(sensors.stamp_jitter * rng.standard_normal(count), -0.15 * period, 0.15 * period)
    taken = (np.arange(count) + 0.5) * period + uneven
    stamp = 1000 * np.round(1e6 * (taken + wrong)).astype(np.int64)  # loggers count microseconds
    late = sensors.latency * (0.6 + 0.4 * np.minimum(rng.exponential(size=count), 4.0))
    log = np.maximum.accumulate(stamp + 1000 * np.round(1e6 * late).astype(np.int64))  # one transport keeps the order
    return taken, stamp, log, rng.random(count) >= sensors.drop_out


def _gauge(truth: Truth, sensors: Sensors, taken: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    moment = taken - sensors.skew
    force = np.interp(moment, truth.time, truth.force)
    rate = sensors.spring_rate + sensors.spring_rate_error
    force = force + rate * np.interp(moment, truth.time, truth.drive.displacement) + sensors.preload
    period, phase = rng.uniform(0.7, 1.6) * truth.time[-1], rng.uniform(0.0, 2.0 * np.pi)
    drift = sensors.force_drift * (np.sin(2.0 * np.pi * taken / period + phase) - np.sin(phase))
    raw = sensors.force_gain * force + sensors.force_offset + drift
    raw = raw + sensors.force_noise * rng.standard_normal(taken.size)
    return np.clip(_quantised(raw, sensors.force_step), -sensors.saturation, sensors.saturation)


def _quantised(values: np.ndarray, step: float) -> np.ndarray:
    return step * np.round(values / step) if step > 0.0 else values
