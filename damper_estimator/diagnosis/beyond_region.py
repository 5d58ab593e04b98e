"""Says where an error lies outside the region that the model was identified in.

A gas spring that was identified over 19 mm may be anything at 50 mm. What a model gets wrong there is no evidence of
a missing effect, however well one would explain it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from damper_estimator.diagnosis.apply_finding import ModelState
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.identification.fit_record import in_region, recorded_region
from damper_estimator.signals import Measurement

_MARGIN = 0.1  # of the region's width on either side: nobody drives twice to the same millimetre
_LEAST_INSIDE = 0.2  # of the time must be inside, to look for effects there
_LARGER = 2.0  # times: the rms error outside over that inside
_UNITS = {  # in which values are shown: factor from SI
    "displacement": ("mm", 1e3), "velocity": ("m/s", 1.0), "command": ("A", 1.0), "temperature": ("deg C", 1.0),
}  # fmt: skip


@dataclass(frozen=True)
class Beyond:
    """One channel outside the region of the model's fit.

    Attributes:
        low, high: the region, SI.
        share_of_error, share_of_time: 0 to 1, outside of it.
    """

    channel: str
    low: float
    high: float
    share_of_error: float
    share_of_time: float

    @property
    def is_extrapolation(self) -> bool:
        """Whether most of the error is outside, and is clearly larger there than inside."""
        outside = self.share_of_error * (1.0 - self.share_of_time)
        inside = (1.0 - self.share_of_error) * self.share_of_time
        return self.share_of_error > limits().extrapolated and outside > _LARGER**2 * inside

    @property
    def is_of_velocity(self) -> bool:
        """Whether the velocities are new. Every model is a function of velocity: a blow-off valve there, or a curve of
        either direction, says no more than that the curve continues differently.
        """
        return self.channel == "velocity"

    @property
    def sentence(self) -> str:
        """With what to do."""
        unit, factor = _UNITS[self.channel]
        return (
            f"{100.0 * self.share_of_error:.0f} % of the squared error lies outside the {self.channel} that the model "
            f"was identified at ({factor * self.low:.3g} to {factor * self.high:.3g} {unit}; "
            f"{100.0 * self.share_of_time:.0f} % of the time): identify it over this range before it is diagnosed. "
        )


def extrapolation(state: ModelState) -> Beyond | None:
    """The channel beyond whose region most of the error lies, if it is one of extrapolation."""
    most = max(_each(state), key=lambda one: one.share_of_error, default=None)
    return most if most is not None and most.is_extrapolation else None


def inside_region(state: ModelState, beyond: Beyond) -> ModelState | None:
    """The recordings judged only where the model was identified, if they are there often enough."""
    if 1.0 - beyond.share_of_time < _LEAST_INSIDE:
        return None

    def judged_inside(group: Sequence[Measurement]) -> tuple[Measurement, ...]:
        inside = (in_region(m.kinematics.block, beyond.channel, beyond.low, beyond.high) for m in group)
        return tuple(replace(m, judged=m.judged & within) for m, within in zip(group, inside, strict=True))

    groups = {name: judged_inside(getattr(state, name)) for name in ("fit", "unseen", "fit_part", "unseen_part")}
    if not all(m.judged.any() for group in groups.values() for m in group):
        return None
    return replace(state, **groups).with_model(state.model)


def _each(state: ModelState) -> Iterator[Beyond]:
    """Every channel that has a region and leaves it."""
    parts = [_squared_error(state, m) for m in (*state.fit_part, *state.unseen_part)]
    whole = sum(float(square.sum()) for square, _ in parts)
    count = sum(square.size for square, _ in parts)
    for channel in _UNITS:
        region = recorded_region(state.model, channel)
        if region is None:
            continue
        low, high = region
        margin = _MARGIN * (high - low)
        inside = [in_region(block, channel, low - margin, high + margin) for _, block in parts]
        error = sum(float(square[~within].sum()) for (square, _), within in zip(parts, inside, strict=True))
        if error > 0.0:
            outside = sum(int(np.count_nonzero(~within)) for within in inside)
            yield Beyond(channel, low, high, error / whole, outside / count)


def _squared_error(state: ModelState, measurement: Measurement) -> tuple[np.ndarray, np.ndarray]:
    """N^2 (n,) of the judged samples without the recording's zero, and their block."""
    error = measurement.in_band(state.model.force(measurement.kinematics.block) - measurement.force)
    judged = measurement.judged & np.isfinite(error)
    left = error[judged] - (error[judged].mean() if judged.any() else 0.0)
    return left**2, measurement.kinematics.block[:, judged]
