"""A model over what is open: its forces in band, and how well they agree."""

from dataclasses import dataclass

import numpy as np

from damper_estimator.model import DamperModel
from damper_estimator.studio.stage import Stage
from damper_estimator.validation import Comparison, Measures, Trace, compare, measures
from damper_estimator.validation.trace import trace


@dataclass(frozen=True)
class Shown:
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

    def comparison(self) -> Comparison:
        """Where it fails, on the judged passages."""
        return compare(self.model, *(p.measurement for p in self.stage.judged))


def shown(model: DamperModel, stage: Stage) -> Shown:
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
    return Shown(model, stage, traces, agreement)
