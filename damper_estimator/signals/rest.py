"""Finds rest: stretches in which displacement and force are quiet compared with the data's noise.

Noise is measured by third differences (rms / sqrt 20 for white noise), which motion hardly affects. A window is quiet
if its scatter is explained by noise and quantisation, or negligible compared with the channel's whole range.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

LEAST_SECONDS = 0.5
_HOP = 0.1  # s
_LEAST_SAMPLES = 12
_NOISE_FACTOR = 1.6
_RANGE_SHARES = (0.0005, 0.01)  # of displacement and force: hum and creep that third differences do not show


@dataclass(frozen=True)
class Rest:
    """One stretch of rest.

    Attributes:
        start, end: s since the first displacement sample.
        displacement, force: medians over it, m and N; force is NaN without one.
    """

    start: float
    end: float
    displacement: float
    force: float

    @property
    def seconds(self) -> float:
        """Its duration."""
        return self.end - self.start


def noise_level(value: np.ndarray) -> float:
    """Standard deviation of the white part of (n,) values, from third differences; 0 for fewer than four."""
    return float(np.sqrt(np.mean(np.diff(value, 3) ** 2) / 20.0)) if value.size > 3 else 0.0


def quantum(value: np.ndarray) -> float:
    """Step of quantisation: the smallest difference between levels; 0 if values hardly repeat."""
    levels = np.unique(value[np.isfinite(value)])
    if levels.size < 2 or levels.size > 0.5 * value.size:
        return 0.0
    steps = np.diff(levels)
    # Rounding in the logger's scaling causes tiny steps between equal readings.
    return float(steps[steps > 1e-9 * np.ptp(levels)].min(initial=np.ptp(levels)))


def find_rests(
    stamp: np.ndarray, displacement: np.ndarray, force_stamp: np.ndarray | None = None, force: np.ndarray | None = None
) -> tuple[Rest, ...]:
    """Rests of at least half a second, in order of time.

    Args:
        stamp, displacement: (n,) ns, rising, and m.
        force_stamp, force: (m,) ns and N, or None if only the displacement is known.
    """
    if stamp.size < _LEAST_SAMPLES:
        return ()
    time = (stamp - stamp[0]) * 1e-9
    channels = [(time, displacement)]
    if force_stamp is not None and force is not None:
        channels.append(((force_stamp - stamp[0]) * 1e-9, force))
    starts = np.arange(0.0, time[-1] - LEAST_SECONDS + 1e-9, _HOP)
    still = np.ones(starts.size, bool)
    for (channel_time, value), share in zip(channels, _RANGE_SHARES, strict=False):
        still &= _quiet(channel_time, value, starts, share * float(np.ptp(value)) if value.size else 0.0)
    edges = np.flatnonzero(np.diff(still.astype(np.int8), prepend=0, append=0))
    spans = [(starts[a], starts[b - 1] + LEAST_SECONDS) for a, b in zip(edges[::2], edges[1::2], strict=True)]
    return tuple(Rest(float(a), float(b), *_levels(channels, a, b)) for a, b in spans)


def _quiet(time: np.ndarray, value: np.ndarray, starts: np.ndarray, least: float) -> np.ndarray:
    coarse = quantum(value)
    quiet = np.zeros(starts.size, bool)
    first, last = np.searchsorted(time, starts), np.searchsorted(time, starts + LEAST_SECONDS)
    for i, (a, b) in enumerate(zip(first.tolist(), last.tolist(), strict=True)):
        window = value[a:b]
        # A gap in the recording is no rest.
        if b - a >= _LEAST_SAMPLES and time[b - 1] - time[a] > 0.8 * LEAST_SECONDS and np.isfinite(window).all():
            quiet[i] = window.std() <= max(_NOISE_FACTOR * noise_level(window) + coarse, least)
    return quiet


def _levels(channels: Sequence[tuple[np.ndarray, np.ndarray]], start: float, end: float) -> tuple[float, float]:
    levels = [float(np.median(value[(time >= start) & (time <= end)])) for time, value in channels]
    return levels[0], levels[1] if len(levels) > 1 else float("nan")
