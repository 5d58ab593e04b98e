"""Data quality of one measured damper: lost samples, clipping, and lateness of the force."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np

from damper_estimator.signals.clipping import clipped
from damper_estimator.validation.trace import Trace

_BLOCKS = 20
_LEAST_CORRELATION = 0.8  # below it the model explains too little of the force to determine its delay
_FINEST = 5e-4  # s; a skew whose standard error is larger (and above a quarter of it) is not reported


@dataclass(frozen=True)
class DataQuality:
    """Defects in the recording of one damper.

    Attributes:
        samples: displacement samples that arrived.
        gaps, inversions, duplicates, non_finite, steps_back: among them, in order of arrival, as a node would count.
        rate_hz: from the steps inside the stretches.
        saturated: force samples at the gauge's limits.
        skew_s: by how much the force seems late against the model's; NaN where the data do not determine it.
    """

    samples: int
    gaps: int
    inversions: int
    duplicates: int
    non_finite: int
    steps_back: int
    rate_hz: float
    saturated: int
    skew_s: float

    def record(self) -> dict[str, object]:
        """For JSON."""
        return asdict(self)


def data_quality(traces: Sequence[Trace]) -> DataQuality:
    """Quality over all recordings of a damper: counts added, the middle rate, one skew."""
    measurements = [t.measurement for t in traces]

    # Passages of one recording share its counts.
    arrived = {id(m.counts): m.counts for m in measurements}.values()

    def total(name: str) -> int:
        return sum(getattr(counts, name) for counts in arrived)

    names = ("samples", "gaps", "inversions", "duplicates", "non_finite", "steps_back")
    return DataQuality(
        **{name: total(name) for name in names},
        rate_hz=float(np.median([m.kinematics.rate for m in measurements])),
        saturated=sum(int(np.count_nonzero(clipped(m.gauge))) for m in measurements),
        skew_s=apparent_skew(traces),
    )


def apparent_skew(traces: Sequence[Trace]) -> float:
    """Lateness of the measured force in s, positive where it is late; NaN where the data do not determine it.

    To first order F_measured(t) = g F_model(t) - s dF_model/dt + c. The regression is repeated about the delay
    found. Its standard error comes from the scatter between blocks, since residuals are autocorrelated. A series
    compliance has a similar effect; the diagnosis distinguishes them.
    """
    skew = 0.0
    for _ in range(4):
        blocks = [block for t in traces for block in _normal_equations(t, skew)]
        if len(blocks) < 4:
            return float("nan")
        change = _solved(np.sum(blocks, axis=0))
        if not np.isfinite(change):
            return float("nan")
        skew += float(np.clip(change, -0.01, 0.01))
    # Jackknife over blocks.
    total = np.sum(blocks, axis=0)
    left_out = np.array([_solved(total - block) for block in blocks])
    error = float(np.sqrt((len(blocks) - 1) / len(blocks) * np.sum((left_out - left_out.mean()) ** 2)))
    certain = np.isfinite(error) and error <= max(_FINEST, abs(skew) / 4.0)
    return skew if certain else float("nan")


def _normal_equations(trace: Trace, skew: float) -> list[np.ndarray]:
    """Sums of products of (F_model late by ``skew``, its slope, 1, F_measured), (4, 4) per block."""
    time = trace.time
    modelled = np.interp(time - skew, time, trace.modelled)
    slope = np.gradient(modelled, time) if time.size > 2 else np.zeros_like(time)
    columns = np.stack([modelled, slope, np.ones_like(time), trace.measured])[:, trace.judged]
    return [part @ part.T for part in np.array_split(columns, _BLOCKS, axis=1) if part.shape[1] >= 20]


def _solved(sums: np.ndarray) -> float:
    """The skew from summed products; NaN where the model explains too little of the force."""
    count = sums[2, 2]
    variances = sums.diagonal() - sums[2] ** 2 / count
    covariance = sums[0, 3] - sums[0, 2] * sums[2, 3] / count
    if min(variances[0], variances[1], variances[3]) <= 0.0:
        return float("nan")
    if covariance < _LEAST_CORRELATION * np.sqrt(variances[0] * variances[3]):
        return float("nan")
    try:
        gain, slope, _ = np.linalg.solve(sums[:3, :3], sums[:3, 3])
    except np.linalg.LinAlgError:
        return float("nan")
    return -slope / gain
