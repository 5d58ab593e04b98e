"""Effects that a model has already, fitted from the start values that they have as hypotheses.

A parameter may lie so far out that its derivative is useless: a stiffness that was nearly rigid, a limit that was never
reached. Re-identification from there would not converge.
"""

from collections.abc import Sequence

import numpy as np

from damper_estimator.diagnosis.diagnosis_data import DiagnosisData
from damper_estimator.diagnosis.hypotheses import Hypothesis
from damper_estimator.diagnosis.trial_fit import sketch, sketched
from damper_estimator.effects.trial import Trial, Untestable
from damper_estimator.identification import LocalRows, Problem
from damper_estimator.model import DamperModel, Element
from damper_estimator.model.element import labels


def from_other_starts(model: DamperModel, data: DiagnosisData) -> tuple[DamperModel, float]:
    """The model with the parameters of one effect fitted again: the effect that explains most, on excerpts of the rows.

    Returns:
        The model, unchanged if no effect explains anything, and the share of the squared error that it explains.
    """
    rows = LocalRows(sketch(data.fit))
    before = Problem(model, rows, ()).point(np.empty(0)).cost
    best, least = model, before
    for label, element in labels(model.effects):
        slots = [i for i, slot in enumerate(model.slots) if slot.address.rpartition(".")[0] == label and not slot.fixed]
        if element.effect.trial is None or not slots:
            continue
        try:
            trial = element.effect.trial(data.ranges)
        except Untestable:
            continue
        problem = Problem(model, rows, slots)
        point = sketched(problem, Hypothesis(element, {}, _starts(element, trial)))
        if point is not None and point.cost < least:
            best, least = problem.model_at(problem.vector(point.searched, point.solved)), point.cost
    return best, 1.0 - least / max(before, 1e-300)


def _starts(element: Element, trial: Trial) -> Sequence[dict[str, float]]:
    scalar = {p.name for p in element.effect.parameters if p.size is None}
    return [{k: float(v) for k, v in start.items() if k in scalar} for start in (trial.values, *trial.starts)]
