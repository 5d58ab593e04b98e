"""The density of a sensor's noise inside the band, measured where the damper rests.

Noise behind an amplifier's filter is stronger inside the band than at the high frequencies at which it is measured in
motion. At rest nothing hides it.
"""

from collections.abc import Sequence

import numpy as np
from scipy import signal

from damper_estimator.signals.rest import Rest

_PIECE = 0.25  # s; the median of pieces leaves out those in which something moves
_LOWEST = 4.0  # Hz, below it a signal creeps
_LEAST_SAMPLES = 12
_SURE = 3.0  # standard errors
_DITHERED = 0.3  # share of samples that must change: else quantisation hides the noise


def rest_density(rests: Sequence[Rest], time: np.ndarray, value: np.ndarray, band: float, least: float) -> float:
    """One-sided density in unit^2/Hz below ``band`` in Hz; ``least`` if no rest shows with certainty that it is more.

    Args:
        rests: with times as in ``time``.
        time: (n,) s, rising.
        value: (n,).
    """
    found, count = [], 0
    for rest in rests:
        for start in np.arange(rest.start, rest.end - _PIECE + 1e-9, _PIECE):
            inside = slice(*np.searchsorted(time, [start, start + _PIECE]).tolist())
            part = value[inside]
            if part.size < _LEAST_SAMPLES or np.mean(np.diff(part) != 0.0) < _DITHERED:
                continue
            rate = (part.size - 1) / (time[inside][-1] - time[inside][0])
            frequency, density = signal.periodogram(part, rate, detrend="linear")
            chosen = density[(frequency >= _LOWEST) & (frequency <= band)]
            if chosen.size:
                found.append(float(chosen.mean()))
                count += chosen.size
    if not found:
        return least
    middle = sorted(found)[(len(found) - 1) // 2]
    return middle if middle > least * (1.0 + _SURE / np.sqrt(count)) else least
