"""How much chance there is in a residual that repeats itself: what the standard errors are made of."""

from collections.abc import Sequence

import numpy as np

from damper_estimator.identification.rows import Rows

MEMORY = 1.0  # s, longest correlation of the residual that is looked at


def residual_noise(rows: Sequence[Rows], residual: np.ndarray, scores: np.ndarray) -> tuple[np.ndarray, float]:
    """Covariance (d, d) of scores' * residual for a residual that is stationary within each recording, and the
    effective number of samples; both are sums over the recordings.

    Args:
        residual: (m,) over all rows.
        scores: (m, d).
    """
    total = np.zeros((scores.shape[1], scores.shape[1]))
    effective, first = 0.0, 0
    for own in rows:
        part = slice(first, first + own.picks.size)
        first += own.picks.size
        if own.picks.size < 2:
            continue
        spectrum, correlation = _spectrum(residual[part], own.rate)
        transformed = np.fft.rfft(scores[part], 2 * own.picks.size, axis=0)
        # The half spectrum stands for both halves; its two ends are there once.
        weight = np.full(spectrum.size, 2.0)
        weight[0] = weight[-1] = 1.0
        total += ((transformed.conj() * (weight * spectrum)[:, None]).T @ transformed).real / (2 * own.picks.size)
        effective += own.picks.size / correlation
    return total, effective


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
