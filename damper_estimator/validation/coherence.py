"""Coherence of measured and modelled force: the share of the measured power that is linear in the modelled."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import signal

from damper_estimator.validation.trace import Trace

_SEGMENT = 4.0  # s
_SHORTEST = 0.5  # s
_LEAST_SEGMENTS = 4  # with fewer the estimate is near one whatever the signals are


@dataclass(frozen=True)
class Coherence:
    """|S_xy|^2 / (S_xx S_yy) by frequency; empty where the recording is too short.

    Attributes:
        frequency: (k,) Hz, up to the comparison band.
        value: (k,) 0 to 1, NaN where there is no power.
    """

    frequency: np.ndarray
    value: np.ndarray


def coherence(traces: Sequence[Trace]) -> Coherence:
    """Coherence by Welch's method, pooled over the judged stretches of all traces, each resampled evenly."""
    rate = float(np.median([t.measurement.kinematics.rate for t in traces]))
    stretches = list(_stretches(traces, rate))
    for seconds in (_SEGMENT, _SEGMENT / 2.0, _SEGMENT / 4.0, _SHORTEST):
        size = round(seconds * rate)
        spectra = [
            _spectra(measured, modelled, rate, size) for measured, modelled in stretches if measured.size >= size >= 8
        ]
        if sum(weight for weight, *_ in spectra) >= _LEAST_SEGMENTS:
            return _pooled(spectra, rate, size, traces[0].measurement.band)
    return Coherence(np.zeros(0), np.zeros(0))


def _stretches(traces: Sequence[Trace], rate: float) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    for trace in traces:
        for part in trace.measurement.kinematics.stretches():
            inside = np.flatnonzero(trace.judged[part])
            if inside.size < 8:
                continue
            # Holes in the judged part (a lost gauge) end the stretch; the longest is kept.
            cuts = np.flatnonzero(np.diff(inside) > 1) + 1
            longest = max(np.split(inside, cuts), key=len)
            run = slice(part.start + int(longest[0]), part.start + int(longest[-1]) + 1)
            time = trace.time[run]
            even = np.arange(time[0], time[-1], 1.0 / rate)
            yield np.interp(even, time, trace.measured[run]), np.interp(even, time, trace.modelled[run])


def _spectra(x: np.ndarray, y: np.ndarray, rate: float, size: int) -> tuple[float, np.ndarray, np.ndarray, np.ndarray]:
    weight = 2 * x.size // size - 1
    chosen = {"fs": rate, "nperseg": size}
    return weight, *(weight * signal.csd(a, b, **chosen)[1] for a, b in ((x, x), (y, y), (x, y)))


def _pooled(spectra: list, rate: float, size: int, band: float) -> Coherence:
    xx, yy, xy = (np.sum([s[i] for s in spectra], axis=0) for i in (1, 2, 3))
    power = xx.real * yy.real
    # Far below the largest power there is only round-off.
    alive = power > 1e-20 * power.max()
    value = np.full(power.size, np.nan)
    value[alive] = np.abs(xy[alive]) ** 2 / power[alive]
    frequency = np.fft.rfftfreq(size, 1.0 / rate)
    inside = (frequency > 0.0) & (frequency <= (band or np.inf))
    return Coherence(frequency[inside], np.minimum(value[inside], 1.0))
