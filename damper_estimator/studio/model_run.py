"""A model over what is open: its forces in band, and how well they agree."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from damper_estimator.model import DamperModel
from damper_estimator.studio.stage import Stage
from damper_estimator.validation import Comparison, Measures, Trace, compare, measures
from damper_estimator.validation.trace import trace


@dataclass(frozen=True, eq=False)
class Curves:
    """What of a trace is drawn, made once so that a zoom costs nothing that grows with the recording.

    Attributes:
        modelled, residual: (n,) N, NaN where it is not judged.
        gaps: (k,) rising indices of the first samples after gaps.
    """

    modelled: np.ndarray
    residual: np.ndarray
    gaps: np.ndarray


@dataclass(frozen=True)
class ModelRun:
    """A model over what is open.

    Attributes:
        model, stage: what was run over what.
        traces: forces in band, one per recording.
        measures: over all samples.
    """

    model: DamperModel
    stage: Stage
    traces: tuple[Trace, ...]
    measures: Measures

    @cached_property
    def curves(self) -> tuple[Curves, ...]:
        """One per recording."""
        return tuple(_curves(trace) for trace in self.traces)

    def comparison(self) -> Comparison:
        """Where it fails, on the judged passages."""
        return compare(self.model, *(p.measurement for p in self.stage.judged))


def run_model(model: DamperModel, stage: Stage) -> ModelRun:
    """Runs a model.

    Raises:
        InputError: where it gives no finite force on a recording.
    """
    traces = tuple(trace(model, m) for m in stage.whole)

    def gathered(column) -> np.ndarray:
        return np.concatenate([column(t)[t.judged] for t in traces])

    agreement = measures(
        gathered(lambda t: t.measured),
        gathered(lambda t: t.modelled),
        gathered(lambda t: t.measurement.kinematics.velocity),
        gathered(lambda t: t.measurement.kinematics.dt),
    )
    return ModelRun(model, stage, traces, agreement)


def _curves(trace: Trace) -> Curves:
    modelled = np.where(trace.judged, trace.modelled, np.nan)
    return Curves(modelled, modelled - trace.measured, np.flatnonzero(trace.measurement.kinematics.dt <= 0.0))
