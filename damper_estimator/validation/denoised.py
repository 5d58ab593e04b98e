"""A signal without its white noise: the Wiener filter, whose gain is the share of the signal in the spectrum."""

import numpy as np
from scipy import fft

from damper_estimator.signals.admission import DEFAULT_MAX_GAP

_BINS = 60  # of the smoothed spectrum, of equal relative width
_DOUBT = 2.0  # times the noise: less than that above it is chance
_LEAST_SAMPLES = 16


def denoised(stamp: np.ndarray, value: np.ndarray, density: float) -> np.ndarray:
    """(n,) the part of a signal that stands out of white noise. Motion below the noise at its frequency is lost.

    Uneven sampling is ignored: it moves a smooth signal less than noise does. Each stretch without gaps is separate.

    Args:
        stamp: (n,) int64 ns, rising.
        value: (n,).
        density: one-sided, of the noise, unit^2/Hz.

    Source: Wiener (1949), non-causal; gain 1 - noise / spectrum.
    """
    out = np.array(value, float)
    period = period_of(stamp)
    gaps = np.flatnonzero(np.diff(stamp) > max(DEFAULT_MAX_GAP, 10.0 * period) * 1e9) + 1
    for part in np.split(np.arange(value.size), gaps):
        if part.size >= _LEAST_SAMPLES:
            out[part] = _wiener(value[part], density / (2.0 * period))
    return out


def period_of(stamp: np.ndarray) -> float:
    """s between different stamps (n,) in ns, as a rule; a sample may come twice."""
    steps = np.diff(stamp)
    return float(np.median(steps[steps > 0])) / 1e9


def _wiener(value: np.ndarray, variance: float) -> np.ndarray:
    """A cosine transform, which continues both ends by reflection; ``variance`` of the noise."""
    spectrum = fft.dct(value, norm="ortho")
    edges = np.unique(np.round(np.geomspace(1, value.size, _BINS)).astype(int))
    power = np.add.reduceat(spectrum**2, edges[:-1]) / np.diff(np.append(edges[:-1], value.size))
    middle = 0.5 * (edges[:-1] + np.append(edges[1:-1], value.size) - 1)
    smooth = np.exp(np.interp(np.arange(value.size), middle, np.log(power + 1e-300)))
    gain = np.clip(1.0 - _DOUBT * variance / smooth, 0.0, 1.0)
    gain[0] = 1.0
    return fft.idct(gain * spectrum, norm="ortho")
