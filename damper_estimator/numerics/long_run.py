"""The randomness of an autocorrelated residual: variances of sums, not of single samples.

A sum of n samples of a stationary residual e has the variance n s^2 with the long-run variance

    s^2 = sum over all lags k of  c(k),      c(k) = E[e(i) e(i + k)]

Evenly sampled residuals: c is estimated up to ``MEMORY`` seconds, with Parzen's taper, which keeps the sum from
becoming negative. Unevenly spaced ones, such as means of cycles: from the scatter of the sums over blocks.
Source: Andrews 1991 (tapers); Kuensch 1989 (blocks).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

MEMORY = 1.0  # s, longest correlation of the residual that is considered


def score_covariance(
    residuals: Sequence[np.ndarray], scores: Sequence[np.ndarray], rates: Sequence[float]
) -> tuple[np.ndarray, float]:
    """Covariance (d, d) of sum(scores' e) for a residual that is stationary within each recording, and the effective
    number of samples, those over the correlation length; both are sums over the recordings.

    Args:
        residuals: (n,) of each recording; one with fewer than two samples is ignored.
        scores: (n, d) of each.
        rates: Hz of each.
    """
    count = scores[0].shape[1]
    total, effective = np.zeros((count, count)), 0.0
    for residual, score, rate in zip(residuals, scores, rates, strict=True):
        if residual.size < 2:
            continue
        spectrum, correlation = _spectrum(residual, rate)
        total += _weighed(score, spectrum)
        effective += residual.size / correlation
    return total, effective


@dataclass(frozen=True)
class Spectrum:
    """How a residual's power spreads over frequency, relative to white noise of the same variance.

    Attributes:
        frequency: (m,) Hz, ascending from 0.
        density: (m,) >= 0; 1 everywhere if the residual is white.
    """

    frequency: np.ndarray
    density: np.ndarray

    def score_covariance(self, scores: np.ndarray, rate: float) -> np.ndarray:
        """Covariance (d, d) of sum(scores' e) for a residual of unit variance, scores (n, d) at ``rate`` Hz."""
        at = np.fft.rfftfreq(2 * len(scores), 1.0 / rate)
        return _weighed(scores, np.interp(at, self.frequency, self.density))


def spectrum_of(residuals: Sequence[np.ndarray], rates: Sequence[float]) -> Spectrum:
    """Of the residuals (n,) of all recordings, n > 1, at their rates in Hz."""
    frequency = np.arange(0.0, 0.5 * max(rates) + 0.5 * MEMORY, 0.25 / MEMORY)
    power, density = 0.0, np.zeros(frequency.size)
    for residual, rate in zip(residuals, rates, strict=True):
        spectrum, _ = _spectrum(residual, rate)
        density += residual.size * np.interp(frequency, np.linspace(0.0, 0.5 * rate, spectrum.size), spectrum)
        power += float(np.sum(residual**2))
    return Spectrum(frequency, density / power if power > 0.0 else np.ones(frequency.size))


def _weighed(scores: np.ndarray, spectrum: np.ndarray) -> np.ndarray:
    """(d, d) sum over frequency of scores (n, d) times their conjugates, by a power spectrum (n + 1,)."""
    transformed = np.fft.rfft(scores, 2 * len(scores), axis=0)
    # The half spectrum stands for both halves; its two ends count once.
    weight = np.full(spectrum.size, 2.0)
    weight[0] = weight[-1] = 1.0
    return ((transformed.conj() * (weight * spectrum)[:, None]).T @ transformed).real / (2 * len(scores))


def long_run_variance(residual: np.ndarray, rate: float) -> float:
    """s^2 of an evenly sampled residual (n,), n > 1, at ``rate`` Hz; white residuals have their variance."""
    return float(np.mean(residual**2)) * _spectrum(residual, rate)[1]


def block_variance(residual: np.ndarray, block: np.ndarray, fitted: int = 0) -> float:
    """s^2 from the scatter of sums over blocks, each longer than the residual's memory.

    Args:
        residual: (n,).
        block: (n,) int, from 0.
        fitted: parameters that the residual was fitted with; they take degrees of freedom from the blocks.
    """
    sums = np.bincount(block, residual)
    freedom = max(sums.size - fitted, 1) / sums.size
    return float(np.sum(sums**2) / residual.size / freedom)


def _spectrum(residual: np.ndarray, rate: float) -> tuple[np.ndarray, float]:
    """Power spectrum (n + 1,) of a residual's tapered autocovariance, and its correlation length in rows."""
    size = residual.size
    power = np.abs(np.fft.rfft(residual, 2 * size)) ** 2 / size
    covariance = np.fft.irfft(power, 2 * size)
    reach = max(1, min(round(MEMORY * rate), size // 4))
    lag = np.minimum(np.arange(2 * size), 2 * size - np.arange(2 * size)) / reach
    parzen = np.where(lag <= 0.5, 1.0 - 6.0 * lag**2 * (1.0 - lag), np.where(lag <= 1.0, 2.0 * (1.0 - lag) ** 3, 0.0))
    tapered = covariance * parzen
    correlation = tapered.sum() / covariance[0] if covariance[0] > 0.0 else 1.0
    return np.maximum(np.fft.rfft(tapered).real, 0.0), max(float(correlation), 1.0)
