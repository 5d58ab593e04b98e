"""Excitations of a test bench: smooth, band-limited displacements in m, reproducible from a seed.

Every record starts with two seconds and ends with half a second at rest, so that gauges can be zeroed.
"""

from collections.abc import Callable

import numpy as np

from damper_estimator.plant.damper import Damper
from damper_estimator.plant.simulation import STEP, Drive

REST_BEFORE, REST_AFTER = 2.0, 0.5
"""s, at rest at the start and the end of every record."""

USABLE_STROKE = 0.9
"""Share of the stroke that a bench uses."""

DYNO_BLOCKS = (  # Hz, m: large strokes for the curve, small ones for frequency dependence
    (0.5, 0.025), (1.0, 0.025), (2.0, 0.025), (3.0, 0.025), (5.0, 0.025),
    (1.5, 0.005), (3.0, 0.005), (6.0, 0.005), (12.0, 0.005), (8.0, 0.002), (15.0, 0.002),
)  # fmt: skip


def bench_drive(name: str, damper: Damper, seconds: float, seed: int, step: float = STEP) -> Drive:
    """A bench excitation by name (``BENCH_EXCITATIONS``), within the damper's stroke, without current.

    Raises:
        KeyError: for an unknown name.
        ValueError: if ``seconds`` is too short for the rests.
    """
    count = round((seconds - REST_BEFORE - REST_AFTER) / step)
    if count * step < 2.0:
        raise ValueError(f"{seconds:g} s are too short; at least {REST_BEFORE + REST_AFTER + 2.0:g} s are needed")
    limit = USABLE_STROKE * min(damper.geometry.rebound_stroke, damper.geometry.compression_stroke)
    motion = BENCH_EXCITATIONS[name](step * np.arange(count), limit, np.random.default_rng(seed))
    displacement = np.zeros(round(seconds / step))
    start = round(REST_BEFORE / step)
    displacement[start : start + count] = motion
    return Drive(name, step, displacement, np.zeros_like(displacement), seed)


def current_steps(seconds: float, seed: int, step: float = STEP, highest: float = 2.0) -> np.ndarray:
    """Coil current in A: steps to random levels up to ``highest`` every 0.8 to 2.5 s, shape (seconds / step,)."""
    rng = np.random.default_rng([seed, 71])
    count = round(seconds / step)
    current, start = np.zeros(count), 0
    while start < count:
        end = start + round(rng.uniform(0.8, 2.5) / step)
        current[start:end] = round(rng.uniform(0.0, highest), 2)
        start = end
    return current


def band_noise(count: int, step: float, low: float, high: float, corner: float, rng: np.random.Generator) -> np.ndarray:
    """Gaussian noise of unit variance, shape (count,): PSD 1 / (1 + (f/corner)^2) from ``low`` to ``high`` Hz, else 0.

    The same seed and length in seconds produce the same noise at any step.
    """
    frequency = np.fft.rfftfreq(count, step)
    inside = np.flatnonzero((frequency >= low) & (frequency <= high))
    spectrum = np.zeros(frequency.size, complex)
    normal = rng.standard_normal((2, inside.size))
    spectrum[inside] = (normal[0] + 1j * normal[1]) / np.sqrt(1.0 + (frequency[inside] / corner) ** 2)
    noise = np.fft.irfft(spectrum, count)
    return noise / noise.std()


def fade(time: np.ndarray, length: float, rise: float) -> np.ndarray:
    """Envelope from 0 to 1 within ``rise`` s, and back before ``length``, with two continuous derivatives."""
    edge = np.clip(np.minimum(time, length - time) / rise, 0.0, 1.0)
    return edge**3 * (10.0 - 15.0 * edge + 6.0 * edge**2)


def within(displacement: np.ndarray, compression: float, rebound: float) -> np.ndarray:
    """Limits a displacement in m smoothly to -compression and rebound; at 80 % of them it is 0.2 % smaller."""
    limit = np.where(displacement > 0.0, rebound, compression)
    return displacement / (1.0 + (displacement / limit) ** 16) ** (1.0 / 16.0)


def _length(time: np.ndarray) -> float:
    """Seconds; independent of the step, unlike ``time[-1]``."""
    return time.size * time[1]


def _random(rms: float) -> Callable[[np.ndarray, float, np.random.Generator], np.ndarray]:
    def motion(time: np.ndarray, limit: float, rng: np.random.Generator) -> np.ndarray:
        # Above 2 Hz the velocity's spectrum is flat: 10 mm RMS gives 0.28 m/s RMS and peaks of about 1 m/s.
        noise = rms * band_noise(time.size, time[1], 0.1, 20.0, 2.0, rng) * fade(time, _length(time), 0.8)
        return within(noise, limit, limit)

    return motion


def _dyno(time: np.ndarray, limit: float, rng: np.random.Generator) -> np.ndarray:
    motion = np.zeros_like(time)
    slot = _length(time) / len(DYNO_BLOCKS)
    blocks = [(f * rng.uniform(0.9, 1.1), a * rng.uniform(0.85, 1.0)) for f, a in DYNO_BLOCKS]
    for number, (frequency, amplitude) in enumerate(blocks):
        local = time - number * slot
        cycles = np.floor((slot - 0.15) * frequency)
        if cycles < 1.0:  # too slow for the available time: one cycle, faster
            frequency, cycles = 1.0 / (slot - 0.15), 1.0
        inside = (local >= 0.0) & (local < cycles / frequency)
        local = local[inside]
        envelope = fade(local, cycles / frequency, 0.5 / frequency)
        motion[inside] = min(amplitude, limit) * np.sin(2.0 * np.pi * frequency * local) * envelope
    return motion


def _slow(time: np.ndarray, limit: float, rng: np.random.Generator) -> np.ndarray:
    """Triangle at 5 mm/s, corners rounded within 80 ms."""
    length = _length(time)
    cycles = max(1, round(length / 20.0))
    amplitude = min(0.005 * length / cycles / 4.0, limit)
    phase = cycles * time / length
    triangle = 4.0 * np.abs(np.mod(phase - 0.25, 1.0) - 0.5) - 1.0
    window = np.hanning(2 * round(0.04 / time[1]) + 1)
    padded = np.pad(triangle, window.size // 2)  # starts and ends at zero displacement
    motion = np.convolve(padded, window / window.sum(), mode="valid")
    return rng.choice((-1.0, 1.0)) * amplitude * motion * fade(time, length, 0.2)


def _step(time: np.ndarray, limit: float, rng: np.random.Generator) -> np.ndarray:
    """Steps of 50 mm between -25 and +25 mm, each in about 0.1 s, with rests of about 1 s."""
    length = _length(time)
    motion, level, start = np.zeros_like(time), 0.0, 0.3
    height = min(0.025, limit) * rng.choice((-1.0, 1.0))
    while start < length - 0.8:
        target = -level if level else height
        motion += (target - level) * _rise((time - start) / rng.uniform(0.08, 0.16))
        level, start = target, start + rng.uniform(0.8, 1.3)
    return motion - level * _rise((time - length + 0.3) / 0.2)


def _rise(share: np.ndarray) -> np.ndarray:
    """From 0 to 1 with three continuous derivatives."""
    share = np.clip(share, 0.0, 1.0)
    return share**4 * (35.0 - 84.0 * share + 70.0 * share**2 - 20.0 * share**3)


BENCH_EXCITATIONS = {
    "random": _random(0.005),
    "random10": _random(0.010),
    "dyno": _dyno,
    "slow": _slow,
    "step": _step,
}
"""Names: displacement of 5 and 10 mm RMS from 0.1 to 20 Hz, sine series, 5 mm/s triangle, 50 mm steps."""
