"""What the pages of a diagnosis and an improvement draw: forces before and after over the unseen recordings.

The zero of the gauge and its straight drift belong to each recording. As in the judgement they are left out: the line
that the improved model still shows against the measured force is taken off the measured force.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from damper_estimator.diagnosis import Diagnosis, Finding, Improvement, corrected
from damper_estimator.report.decimation import min_max_rows
from damper_estimator.validation import Comparison, Trace, compare

_CYCLES = 3.0  # of the motion in the worst passage
_SHORTEST, _LONGEST = 0.4, 6.0  # s
_MOST_IN_PASSAGE = 1200


@dataclass(frozen=True)
class Recording:
    """One unseen recording, all arrays (n,).

    Attributes:
        path: of the bag.
        time: s since the start of the recording, also in a part of it.
        displacement, velocity: m, m/s.
        measured: N in band, with the corrections of the measurement chain.
        raw: N in band, as it was read before those corrections.
        before, after: N in band, of the model as given and of the improved one.
        judged: samples that count.
        zero: N, line that was taken off both measured forces.
    """

    path: str
    time: np.ndarray
    displacement: np.ndarray
    velocity: np.ndarray
    measured: np.ndarray
    raw: np.ndarray
    before: np.ndarray
    after: np.ndarray
    judged: np.ndarray
    zero: np.ndarray

    @property
    def error_before(self) -> np.ndarray:
        """(n,) N, modelled - measured; NaN where it is not judged."""
        return np.where(self.judged, self.before - self.raw, np.nan)

    @property
    def error_after(self) -> np.ndarray:
        """(n,) N, modelled - measured; NaN where it is not judged."""
        return np.where(self.judged, self.after - self.measured, np.nan)

    @cached_property
    def worst(self) -> tuple[float, float]:
        """From and to, s: some cycles of the motion with the largest squared error before."""
        span = min(_length(self), float(self.time[-1] - self.time[0]))
        square = np.cumsum(np.nan_to_num(self.error_before) ** 2)
        ends = np.searchsorted(self.time, self.time + span, side="right") - 1
        whole = self.time + span <= self.time[-1] + 1e-9
        carried = np.where(whole, square[ends] - square, -1.0)
        start = float(self.time[int(np.argmax(carried))])
        return start, start + span

    def carried(self) -> float:
        """Mean squared error before within the worst passage, N^2."""
        inside = (self.time >= self.worst[0]) & (self.time <= self.worst[1])
        return float(np.nanmean(np.where(inside, self.error_before, np.nan) ** 2)) if inside.any() else 0.0

    def passage_rows(self) -> np.ndarray:
        """Rows of the worst passage."""
        inside = np.flatnonzero((self.time >= self.worst[0]) & (self.time <= self.worst[1]))
        forces = [self.raw, self.before - self.raw, self.after - self.raw]
        return inside[min_max_rows([force[inside] for force in forces], _MOST_IN_PASSAGE)]


@dataclass(frozen=True)
class BeforeAfter:
    """A damper's unseen recordings under the model as given and under the improved one.

    Attributes:
        recordings: as many as there are unseen ones.
        before, after: how well each agrees; ``after`` with the corrections of the measurement chain.
        changed: whether there is anything to show after.
        corrected: whether the measurement chain was corrected.
    """

    recordings: tuple[Recording, ...]
    before: Comparison
    after: Comparison
    changed: bool
    corrected: bool

    @cached_property
    def worst_index(self) -> int:
        """Which recording has the worst passage."""
        return int(np.argmax([recording.carried() for recording in self.recordings]))

    @property
    def worst(self) -> Recording:
        """The recording with the worst passage."""
        return self.recordings[self.worst_index]


def before_after(found: Diagnosis | Improvement) -> BeforeAfter:
    """Runs the model as given and the improved one over the unseen recordings.

    Raises:
        InputError: where a recording cannot be judged with one of the models.
    """
    first = first_diagnosis(found)
    improved = found.improved if isinstance(found, Diagnosis) else found.model
    put_right = [corrected(measurement, found.signals) for measurement in first.unseen]
    before, after = compare(first.model, *first.unseen), compare(improved, *put_right)
    both = zip(first.unseen, put_right, strict=True)
    is_corrected = any(not np.array_equal(old.force, new.force, equal_nan=True) for old, new in both)
    recordings = tuple(_recording(*pair) for pair in zip(before.traces, after.traces, strict=True))
    changed = is_corrected or any(not np.array_equal(recording.before, recording.after) for recording in recordings)
    return BeforeAfter(recordings, before, after, changed, is_corrected)


def first_diagnosis(found: Diagnosis | Improvement) -> Diagnosis:
    """What was diagnosed of the model as given and of the recordings as they were read."""
    return found if isinstance(found, Diagnosis) else found.first


def _recording(before: Trace, after: Trace) -> Recording:
    kinematics = before.measurement.kinematics
    time = before.time
    judged = before.judged & after.judged
    zero = np.polyval(np.polyfit(time[judged], after.residual[judged], 1), time) if judged.sum() > 2 else 0.0 * time
    return Recording(
        path=before.measurement.recording,
        time=time,
        displacement=kinematics.displacement,
        velocity=kinematics.velocity,
        measured=after.measured + zero,
        raw=before.measured + zero,
        before=before.modelled,
        after=after.modelled,
        judged=judged,
        zero=zero,
    )


def _length(recording: Recording) -> float:
    """How long some cycles of the motion last, s."""
    moving = recording.velocity[np.abs(recording.velocity) > 0.1 * np.sqrt(np.mean(recording.velocity**2))]
    turns = np.count_nonzero(np.diff(np.sign(moving)) != 0)
    seconds = float(recording.time[-1] - recording.time[0])
    return float(np.clip(2.0 * _CYCLES * seconds / max(turns, 1), _SHORTEST, _LONGEST))


@dataclass(frozen=True)
class Explained:
    """What one found effect accounts for, in the recording with the worst passage.

    Attributes:
        missing: (n,) N in band, measured less the improved model without this effect.
        part: (n,) N in band, what the effect changes.
    """

    missing: np.ndarray
    part: np.ndarray


def explained(shown: BeforeAfter, finding: Finding) -> Explained | None:
    """What a found effect accounts for; None where the improved model does not have it, or nothing was corrected."""
    worst = shown.worst
    if finding.is_channel:
        part = worst.raw - worst.measured
        return Explained(part - worst.error_after, part) if part.any() else None
    improved, measurement = shown.after.model, shown.after.traces[shown.worst_index].measurement
    label = _label(improved.slots, finding)
    if label is None:
        return None
    rest = improved.without(label).force(measurement.kinematics.block)
    without = measurement.in_band(np.nan_to_num(rest))
    return Explained(np.where(worst.judged, worst.measured - without, np.nan), worst.after - without)


def _label(slots: Sequence, finding: Finding) -> str | None:
    """The instance of the effect whose parameters are nearest to those that were found."""
    values: dict[str, dict[str, float]] = {}
    for slot in slots:
        label, _, name = slot.address.rpartition(".")
        if label.partition("#")[0] == finding.effect:
            values.setdefault(label, {})[name] = slot.value
    wanted = {known.name.rpartition(".")[2]: known.value for known in finding.parameters}

    def distance(label: str) -> float:
        return sum(abs(values[label].get(name, 0.0) - value) / max(abs(value), 1e-12) for name, value in wanted.items())

    return min(values, key=distance, default=None)
