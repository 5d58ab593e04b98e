"""Roads: ISO 8608 profiles and single bumps, as height in m over time at a constant speed.

One-sided displacement PSD over spatial frequency n: G(n) = G(n0) (n / n0)^-2 with n0 = 0.1 1/m; the geometric means of
G(n0) are 16e-6 m^3 for class A and four times as much for each next class. Source: ISO 8608, annexes B and C.
"""

import numpy as np

REFERENCE_FREQUENCY = 0.1
"""1/m, n0."""

CLASSES = {letter: 16e-6 * 4.0**number for number, letter in enumerate("ABCDE")}
"""G(n0) in m^3, geometric mean of each class."""

LOWEST, HIGHEST = 0.011, 2.83
"""1/m, spatial frequencies for which the standard defines a profile, the only ones generated."""


def profile_spectrum(frequency: np.ndarray, road_class: str) -> np.ndarray:
    """G(n) in m^3 at spatial frequencies n in 1/m.

    Raises:
        KeyError: for a class other than A to E.
    """
    return CLASSES[road_class] * (frequency / REFERENCE_FREQUENCY) ** -2.0


def road_height(road_class: str, speed: float, count: int, step: float, seed: int) -> np.ndarray:
    """Height in m under a wheel that rolls at ``speed`` m/s, shape (count,), ``step`` in s; zero mean, periodic.

    A sum of sines with random phases and Rayleigh amplitudes: a Gaussian profile with the class's PSD. The same seed
        produces the same road at any step.

    Raises:
        ValueError: if the road is shorter than its longest waves.
    """
    length = count * step * speed
    frequency = np.fft.rfftfreq(count, step * speed)
    inside = np.flatnonzero((frequency >= LOWEST) & (frequency <= HIGHEST))
    if inside.size == 0:
        raise ValueError(f"{length:.0f} m of road are too short for the longest wave, {1.0 / LOWEST:.0f} m")
    normal = np.random.default_rng([seed, 8608]).standard_normal((2, inside.size))
    variance = profile_spectrum(frequency[inside], road_class) / length  # of each line, m^2
    spectrum = np.zeros(frequency.size, complex)
    spectrum[inside] = 0.5 * count * np.sqrt(variance) * (normal[0] + 1j * normal[1])
    return np.fft.irfft(spectrum, count)


def bump_height(height: float, length: float, speed: float, time: np.ndarray, start: float) -> np.ndarray:
    """A cosine bump of ``height`` m over ``length`` m, reached at ``start`` s; shape of ``time``."""
    share = np.clip((time - start) * speed / length, 0.0, 1.0)
    return 0.5 * height * (1.0 - np.cos(2.0 * np.pi * share))


def pothole_height(
    depth: float, length: float, edge: float, speed: float, time: np.ndarray, start: float
) -> np.ndarray:
    """A pothole of ``depth`` m over ``length`` m, reached at ``start`` s; shape of ``time``.

    Its edges fall and rise smoothly over ``edge`` m, about the length of the tyre's contact, which smooths sharper
    edges.
    """
    place = (time - start) * speed
    down = np.clip(place / edge, 0.0, 1.0)
    up = np.clip((place - length + edge) / edge, 0.0, 1.0)
    return -0.5 * depth * (np.cos(np.pi * up) - np.cos(np.pi * down))
