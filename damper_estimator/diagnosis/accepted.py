"""An effect that a round accepted, and the model with it."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.diagnosis.diagnosis_data import DiagnosisData
from damper_estimator.diagnosis.evaluation import rmse
from damper_estimator.diagnosis.hypotheses import Hypothesis, Region, are_themselves, limits_in, within
from damper_estimator.diagnosis.local_fit import locally_fitted
from damper_estimator.diagnosis.ranking import Round
from damper_estimator.identification import LocalRows, Problem
from damper_estimator.identification.methods.least_squares import refine
from damper_estimator.identification.start_points import candidates as start_sizes
from damper_estimator.model import DamperModel, Element
from damper_estimator.model.element import walk


@dataclass(frozen=True)
class Accepted:
    """An effect that a round accepted.

    Attributes:
        round: without its other hypotheses.
        hypothesis: as the round evaluated it.
        element: the entry with its fitted values.
        gain: with its 5 and 95 % ends.
        partner: phenomenon that it was found together with; "" where it was found by itself.
        needs: whether it explains little without it.
    """

    round: Round
    hypothesis: Hypothesis
    element: Element
    tied: tuple[str, ...]
    confidence: float
    gain: tuple[float, float, float]
    before_n: float
    after_n: float
    partner: str = ""
    needs: bool = False

    @property
    def is_mean(self) -> bool:
        """Whether it was found in the mean, which the freed zero of the gauge hides otherwise."""
        return bool(self.round.constants)

    @property
    def fall(self) -> float:
        """By how much it lowers the mean squared error on unseen data, N^2."""
        return self.before_n**2 - self.after_n**2

    @property
    def explained(self) -> float:
        """The same, as a share of that error."""
        return self.fall / self.before_n**2


def accepted_in(current: Round, best: Hypothesis) -> Accepted:
    """The effect, with what else it could be in this round."""
    tied = current.tied(best)
    return Accepted(
        round=current.decided_for(best),
        hypothesis=best,
        element=best.fitted_element,
        tied=tied,
        confidence=current.confidence(best),
        gain=current.gain(best),
        before_n=rmse(current.baseline, current.without),
        after_n=rmse(current.baseline, current.left(best)),
    )


def breaks_tie(one: Sequence[Accepted], tied: Sequence[Accepted]) -> bool:
    """Whether the first of some findings is one of those that are tied first in others, and not tied with them all."""
    groups = [{found[0].hypothesis.phenomenon, *found[0].tied} for found in (one, tied) if found]
    return len(groups) == 2 and groups[0] < groups[1]


def regions_of(accepted: Sequence[Accepted]) -> dict[str, Region]:
    """Where each effect is what it represents, by its name."""
    return {one.element.effect.name: one.hypothesis.region for one in accepted}


def together(accepted: Sequence[Accepted]) -> list[list[Accepted]]:
    """Findings, those that were found together in one group."""
    groups: list[list[Accepted]] = []
    for one in accepted:
        last = groups[-1] if groups else []
        if one.partner and len(last) == 1 and last[0].partner == one.element.effect.phenomenon:
            last.append(one)
        else:
            groups.append([one])
    return groups


def positions(model: DamperModel, added: Collection[str]) -> tuple[int, ...]:
    """Where the parameters of added effects are in the model's slots."""
    entries = list(walk(model.effects))
    places = {max(i for i, element in enumerate(entries) if element.effect.name == name) for name in added}
    return tuple(i for i, slot in enumerate(model.slots) if slot.entry in places)


def fitted_together(model: DamperModel, added: Mapping[str, Region], data: DiagnosisData, refits: bool) -> DamperModel:
    """The parameters of all that was found, fitted together; with all others where those are refitted.

    As given where an effect would not be what it represents any more.
    """
    if refits:
        measurements = [rows.measurement for rows in data.fit]
        fitted = locally_fitted(model, measurements, zero=data.zero, limits=limits_in(model, added))
    else:
        fitted = _fitted(Problem(model, LocalRows(data.fit), positions(model, added), slots=within(model, added)))
    return fitted if are_themselves(fitted, added) else model


def _fitted(problem: Problem) -> DamperModel:
    if not problem.searched.size:
        point = problem.point(problem.start)
    else:
        _, size = start_sizes(problem, 0, 0)
        point, _ = refine(problem, problem.start, size, 6, 1e-3)
    if not np.isfinite(point.cost):
        return problem.model
    return problem.model_at(problem.vector(point.searched, point.solved))
