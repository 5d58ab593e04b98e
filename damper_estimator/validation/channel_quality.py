"""Quality of one channel as recorded, before any filter."""

from dataclasses import asdict, dataclass

import numpy as np

from damper_estimator.signals.admission import Admission, Counts
from damper_estimator.signals.clipping import clipped
from damper_estimator.signals.rest import noise_level, quantum

_WINDOW = 64


@dataclass(frozen=True)
class ChannelQuality:
    """Properties of one channel.

    Attributes:
        samples: number that arrived.
        rate_hz: (n - 1) over the time between resets, not from the median step: logged times are often rounded.
        jitter_s: standard deviation of the steps.
        gaps, steps_back, inversions, duplicates, non_finite: in order of arrival.
        quantum: step of quantisation, 0 where none is seen.
        noise: standard deviation of the white part, from the quiet tenth of short windows.
        saturated: samples at a limit of the sensor's range.
        low, high: extremes.
        spikes: samples that are left out (``signals.spikes``).
    """

    samples: int
    rate_hz: float
    jitter_s: float
    gaps: int
    steps_back: int
    inversions: int
    duplicates: int
    non_finite: int
    quantum: float
    noise: float
    saturated: int
    low: float
    high: float
    spikes: int = 0

    def record(self) -> dict[str, object]:
        """For JSON."""
        return asdict(self)


def channel_quality(stamp: np.ndarray, value: np.ndarray, max_gap: float) -> ChannelQuality:
    """Quality of a channel: stamps (n,) ns and values (n,) in order of arrival."""
    verdict, dt = Admission(max_gap).block(stamp, value)
    counts = Counts.of(verdict)
    steps = dt[dt > 0.0]
    finite = value[np.isfinite(value)]
    return ChannelQuality(
        samples=counts.samples,
        rate_hz=float(steps.size / steps.sum()) if steps.size else float("nan"),
        jitter_s=float(steps.std()) if steps.size else float("nan"),
        gaps=counts.gaps,
        steps_back=counts.steps_back,
        inversions=counts.inversions,
        duplicates=counts.duplicates,
        non_finite=counts.non_finite,
        quantum=quantum(finite),
        noise=_noise(finite),
        saturated=int(np.count_nonzero(clipped(finite))),
        low=float(finite.min()) if finite.size else float("nan"),
        high=float(finite.max()) if finite.size else float("nan"),
    )


def _noise(value: np.ndarray) -> float:
    """Motion is left out by taking a quiet window's level, not the average one."""
    windows = [noise_level(value[i : i + _WINDOW]) for i in range(0, max(value.size - _WINDOW, 1), _WINDOW)]
    return float(np.quantile(windows, 0.1)) if windows else float("nan")
