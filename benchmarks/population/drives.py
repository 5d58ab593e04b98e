"""Drives of the damper: roads, random motion, sweeps, series of sines, slow strokes; and current and temperature."""

from dataclasses import dataclass

import numpy as np

RATE = 5000
"""Hz, of the simulation."""

KINDS = ("road", "random", "sweep", "sines", "mixed")


@dataclass(frozen=True)
class Drive:
    """The prescribed quantities, each (n,) at ``RATE``: m, m/s, m/s^2, A, deg C."""

    kind: str
    x: np.ndarray
    v: np.ndarray
    a: np.ndarray
    current: np.ndarray
    temperature: np.ndarray

    @property
    def time(self) -> np.ndarray:
        """(n,) s."""
        return np.arange(self.x.size) / RATE


def drawn(
    rng: np.random.Generator, kind: str, seconds: float, speed: float, limit: float, warming: float, highest: float
) -> Drive:
    """A drive that starts and ends at rest.

    Args:
        speed: m/s, 99 % quantile of the speeds, as far as ``limit`` allows.
        limit: m to either side.
        warming: K, from its beginning to its end.
        highest: A, of the current's random steps; 0 for a constant current.
    """
    count = round(seconds * RATE)
    rest = round(rng.uniform(0.8, 2.0) * RATE)
    inner = count - rest - round(0.4 * RATE)
    time = np.arange(inner) / RATE
    shape = {"road": _road, "random": _random, "sweep": _sweep, "sines": _sines, "mixed": _mixed}[kind](rng, time)
    length = inner / RATE
    edge = np.clip(np.minimum(time, length - time) / 0.6, 0.0, 1.0)
    shape = shape * edge**3 * (10.0 - 15.0 * edge + 6.0 * edge**2)
    rate = np.gradient(shape, 1.0 / RATE)
    shape *= speed / np.quantile(np.abs(rate), 0.99)
    reach = np.abs(shape).max()
    if reach > 1.6 * limit:
        shape *= 1.6 * limit / reach
    shape /= (1.0 + (np.abs(shape) / limit) ** 8) ** 0.125
    x = np.zeros(count)
    x[rest : rest + inner] = shape
    v = np.gradient(x, 1.0 / RATE)
    a = np.gradient(v, 1.0 / RATE)
    return Drive(kind, x, v, a, _current(rng, count, highest), _temperature(rng, v, warming))


def noise(rng: np.random.Generator, count: int, low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
    """White spectrum between ``low`` and ``high`` Hz: frequencies (m,), complex amplitudes (m,)."""
    frequency = np.fft.rfftfreq(count, 1.0 / RATE)
    inside = (frequency >= low) & (frequency <= high)
    spectrum = np.zeros(frequency.size, complex)
    spectrum[inside] = rng.standard_normal(inside.sum()) + 1j * rng.standard_normal(inside.sum())
    return frequency, spectrum


def _random(rng: np.random.Generator, time: np.ndarray) -> np.ndarray:
    frequency, spectrum = noise(rng, time.size, rng.uniform(0.1, 0.4), rng.uniform(12.0, 25.0))
    corner, order = rng.uniform(1.0, 4.0), rng.uniform(0.8, 1.5)
    return np.fft.irfft(spectrum / (1.0 + (frequency / corner) ** 2) ** (0.5 * order), time.size)


def _road(rng: np.random.Generator, time: np.ndarray) -> np.ndarray:
    """Deflection of a linear quarter-car on a road of white slope."""
    frequency, spectrum = noise(rng, time.size, 0.15, 28.0)
    s = 2j * np.pi * np.maximum(frequency, 0.05)
    body, wheel = rng.uniform(250.0, 450.0), rng.uniform(25.0, 50.0)
    spring = body * (2.0 * np.pi * rng.uniform(1.0, 1.8)) ** 2
    damping = 2.0 * rng.uniform(0.2, 0.4) * np.sqrt(spring * body)
    tyre = rng.uniform(1.5e5, 2.5e5)
    between = spring + damping * s
    # deflection over road height
    up = body * s * s
    ratio = -up * tyre / ((up + between) * (wheel * s * s + tyre) + up * between)
    return np.fft.irfft(spectrum / np.abs(s) * ratio, time.size)


def _sweep(rng: np.random.Generator, time: np.ndarray) -> np.ndarray:
    """Sweeps up and down whose speed amplitude changes slowly."""
    length = time[-1]
    low, high, turns = rng.uniform(0.2, 0.6), rng.uniform(8.0, 18.0), rng.integers(1, 4)
    saw = np.abs(2.0 * np.mod(turns * time / length, 1.0) - 1.0)
    frequency = high * (low / high) ** saw
    phase = 2.0 * np.pi * np.cumsum(frequency) / RATE
    size = 0.4 + 0.6 * np.abs(np.sin(np.pi * time * rng.uniform(0.08, 0.2)))
    return size * np.sin(phase) / frequency ** rng.uniform(0.8, 1.0)


def _sines(rng: np.random.Generator, time: np.ndarray) -> np.ndarray:
    """Blocks of sines, each with whole cycles, fading in and out."""
    length, shape, start = time[-1], np.zeros(time.size), 0.0
    while start < length - 2.5:
        frequency = np.exp(rng.uniform(np.log(0.4), np.log(14.0)))
        block = min(max(rng.integers(3, 9) / frequency, 1.2), length - start)
        block_samples = (time >= start) & (time < start + block)
        local = time[block_samples] - start
        edge = np.clip(np.minimum(local, block - local) / min(0.5 / frequency, 0.4 * block), 0.0, 1.0)
        speed = rng.choice([0.15, 0.35, 0.7, 1.0])
        shape[block_samples] = (
            speed / frequency * np.sin(2.0 * np.pi * frequency * local) * edge**3 * (10 - 15 * edge + 6 * edge**2)
        )
        start += block
    return shape


def _mixed(rng: np.random.Generator, time: np.ndarray) -> np.ndarray:
    """Slow wide strokes with fast small motion on them."""
    slow = np.zeros(time.size)
    for frequency in rng.uniform(0.1, 0.6, 4):
        slow += np.sin(2.0 * np.pi * (frequency * time + rng.random()))
    fast = _random(rng, time)
    return slow / slow.std() + rng.uniform(0.2, 0.6) * fast / fast.std()


def _current(rng: np.random.Generator, count: int, highest: float) -> np.ndarray:
    if highest <= 0.0:
        return np.full(count, 0.5)
    if rng.random() < 0.3:  # a slow sine
        phase = 2.0 * np.pi * rng.uniform(0.1, 0.6) * np.arange(count) / RATE
        return 0.5 * highest * (1.0 - np.cos(phase))
    current, start = np.zeros(count), 0
    while start < count:
        end = start + round(rng.uniform(0.4, 2.5) * RATE)
        current[start:end] = round(rng.uniform(0.0, highest), 2)
        start = end
    return current


def _temperature(rng: np.random.Generator, v: np.ndarray, warming: float) -> np.ndarray:
    """Rises with the dissipated work, cools slowly; its mean is near 30 deg C."""
    work = np.cumsum(np.abs(v) ** 1.8)
    share = work / work[-1]
    bend = rng.uniform(0.3, 2.0)
    rise = warming * (1.0 - np.exp(-bend * share)) / (1.0 - np.exp(-bend))
    return 30.0 - warming * rng.uniform(0.35, 0.65) + rise
