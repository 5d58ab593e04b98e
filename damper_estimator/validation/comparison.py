"""How well a model agrees with measurements, and where it does not."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np

from damper_estimator.model import DamperModel
from damper_estimator.signals import Measurement
from damper_estimator.validation.coherence import Coherence, coherence
from damper_estimator.validation.data_quality import DataQuality, data_quality
from damper_estimator.validation.error_parts import ErrorParts, error_parts
from damper_estimator.validation.excitation_errors import (
    FrequencyError,
    GroupError,
    given_group_errors,
    group_errors,
    relative_rms,
)
from damper_estimator.validation.finding import DataFinding
from damper_estimator.validation.findings import data_findings
from damper_estimator.validation.measures import Measures, measures
from damper_estimator.validation.noise import noise_floor
from damper_estimator.validation.regions import Region, find_regions
from damper_estimator.validation.trace import Pool, Trace, pool, trace


@dataclass(frozen=True)
class Comparison:
    """One model against one or several recordings of one damper, judged together.

    Attributes:
        model: the model that was run.
        traces: forces in band, one per recording.
        measures: over the judged samples of all recordings.
        split: how much of the error is the gauge's zero, drift, a gain and scatter.
        regions: where the error is concentrated, zero and drift left out; worst first.
        coherence: of measured and modelled force.
        data_quality: of the recordings.
        noise_floor_n: N, error that a perfect model would still show; NaN where it cannot be estimated.
        warnings: notes for the user on these numbers.
        grouping: recordings (paths) by the user's groups; empty: groups are formed by velocity and frequency.
    """

    model: DamperModel
    traces: tuple[Trace, ...]
    measures: Measures
    split: ErrorParts
    regions: tuple[Region, ...]
    coherence: Coherence
    data_quality: DataQuality
    noise_floor_n: float
    warnings: tuple[str, ...]
    grouping: Mapping[str, Sequence[str]] = field(default_factory=dict)

    @property
    def damper(self) -> str:
        """Name of the damper."""
        return self.traces[0].measurement.damper

    @property
    def recordings(self) -> tuple[str, ...]:
        """Paths of the bags."""
        return tuple(t.measurement.recording for t in self.traces)

    @cached_property
    def pool(self) -> Pool:
        """The judged samples."""
        return pool(self.traces, self.split.slow)

    @cached_property
    def findings(self) -> tuple[DataFinding, ...]:
        """Mistakes of the measurement chain that the recordings show by themselves."""
        return data_findings(self.model, [t.measurement for t in self.traces])

    @cached_property
    def contributions(self) -> dict[str, float]:
        """RMS in N of each effect's share of the force in band, over the judged samples, by label, largest first."""
        squares: dict[str, float] = {}
        for t in self.traces:
            for label, part in self.model.contributions(t.measurement.kinematics.block).items():
                in_band = t.measurement.in_band(np.nan_to_num(part))[t.judged]
                squares[label] = squares.get(label, 0.0) + float(np.sum(in_band**2))
        rms = {label: float(np.sqrt(square / self.measures.samples)) for label, square in squares.items()}
        return dict(sorted(rms.items(), key=lambda item: -item[1]))

    @cached_property
    def relative_rms(self) -> tuple[FrequencyError, ...]:
        """rms error over rms force by frequency of the excitation."""
        return relative_rms(self.traces)

    @cached_property
    def groups(self) -> tuple[GroupError, ...]:
        """Errors of the user's groups, or of groups of cycles formed from the recordings' ranges."""
        if not self.grouping:
            return group_errors(self.traces)
        members = {
            name: [i for i, path in enumerate(self.recordings) if path in paths]
            for name, paths in self.grouping.items()
        }
        return given_group_errors(self.traces, {name: indices for name, indices in members.items() if indices})

    def record(self) -> dict[str, object]:
        """For JSON: the documented keys and a few more."""
        return {
            "model": self.model.name,
            **self.measures.record(),
            "noise_floor_n": self.noise_floor_n,
            **self.split.record(),
            "regions": [region.record() for region in self.regions],
            "coherence": {"frequency_hz": self.coherence.frequency, "value": self.coherence.value},
            "relative_rms": {
                "frequency_hz": [row.frequency_hz for row in self.relative_rms],
                "value": [row.relative_rms for row in self.relative_rms],
                "cycles": [row.cycles for row in self.relative_rms],
            },
            "groups": [group.record() for group in self.groups],
            "data_quality": self.data_quality.record() | {"findings": [finding.record() for finding in self.findings]},
            "contributions_rms_n": self.contributions,
            "warnings": list(self.warnings),
        }


def compare(model: DamperModel, *recordings: Measurement) -> Comparison:
    """Judges a model against one or several measurements of one damper, pooled over their judged samples.

    Raises:
        InputError: where a recording has no sample that can be judged.
    """
    return _judged(model, [trace(model, measurement) for measurement in recordings])


def per_recording(comparison: Comparison) -> tuple[Comparison, ...]:
    """The same comparison for each of its recordings alone."""
    if len(comparison.traces) == 1:
        return (comparison,)
    return tuple(_judged(comparison.model, [t]) for t in comparison.traces)


def _judged(model: DamperModel, traces: Sequence[Trace]) -> Comparison:
    floors = [noise_floor(t.measurement) for t in traces]
    shares = [t.judged.sum() for t in traces]
    coherent, quality, parts = coherence(traces), data_quality(traces), error_parts(traces)
    together = pool(traces, parts.slow)  # last: the other results need as much memory
    return Comparison(
        model=model,
        traces=tuple(traces),
        measures=measures(together.measured, together.modelled, together.velocity, together.dt),
        split=parts,
        regions=find_regions(together),
        coherence=coherent,
        data_quality=quality,
        noise_floor_n=float(np.sqrt(np.average(np.square(floors), weights=shares))),
        warnings=tuple(_warnings(model, traces)),
    )


def _warnings(model: DamperModel, traces: Sequence[Trace]) -> list[str]:
    warnings = []
    used, fitted = traces[0].measurement.cutoff, model.fit.get("cutoff")
    if fitted is not None and float(fitted or 0.0) != used:
        warnings.append(
            f"model {model.name} was fitted with the filter at {_hertz(fitted)}, here it is at {_hertz(used)}"
        )
    for t in traces:
        if t.lost:
            warnings.append(
                f"{Path(t.measurement.recording).name}: {model.name} gave no finite force on {t.lost} samples"
            )
    return warnings


def _hertz(cutoff: object) -> str:
    return f"{float(cutoff):g} Hz" if cutoff else "none"
