"""An effect that a round accepted, and the model with it."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from damper_estimator.diagnosis.attempt import Attempt
from damper_estimator.diagnosis.candidates import Candidate
from damper_estimator.diagnosis.judge import Tally, rmse
from damper_estimator.diagnosis.ranking import Round
from damper_estimator.diagnosis.scene import Scene
from damper_estimator.diagnosis.settle import settled
from damper_estimator.identification import LocalRows, Problem
from damper_estimator.identification.methods.least_squares import refine
from damper_estimator.identification.start_points import candidates as start_sizes
from damper_estimator.model import DamperModel, Element
from damper_estimator.model.element import walk


@dataclass(frozen=True)
class Accepted:
    """An effect that a round accepted.

    Attributes:
        element: the entry with its fitted values.
        gain: with its 5 and 95 % ends.
        partner: phenomenon beside it without which it explains little; "" where it does by itself.
    """

    round: Round
    tally: Tally
    element: Element
    tied: tuple[str, ...]
    confidence: float
    gain: tuple[float, float, float]
    before_n: float
    after_n: float
    partner: str = ""


def accepted_in(current: Round, best: Tally) -> Accepted:
    """The effect, with what else it could be in this round."""
    return as_found(current, best, *rivalled(current, best))


def as_found(current: Round, best: Tally, tied: tuple[str, ...], confidence: float) -> Accepted:
    """The effect, with ties that were found elsewhere."""
    return Accepted(
        round=current,
        tally=best,
        element=best.attempt.element(current.candidates[best.attempt.effect]),
        tied=tied,
        confidence=confidence,
        gain=current.gain(best),
        before_n=rmse(current.null, current.without),
        after_n=rmse(current.null, current.left(best)),
    )


def rivalled(current: Round, best: Tally) -> tuple[tuple[str, ...], float]:
    """What else it could be, and how sure the group is."""
    tied = current.tied(best)
    return tied, current.confidence((best.attempt.phenomenon, *tied))


def names_of(accepted: Sequence[Accepted]) -> list[str]:
    """Of effects."""
    return [one.element.effect.name for one in accepted]


def entry_of(model: DamperModel, effect: str) -> Element:
    """The entry that was added: an effect's last."""
    return [element for element in walk(model.effects) if element.effect.name == effect][-1]


def positions(model: DamperModel, added: Collection[str]) -> tuple[int, ...]:
    """Where the parameters of added effects are in the model's slots."""
    entries = list(walk(model.effects))
    places = {max(i for i, element in enumerate(entries) if element.effect.name == name) for name in added}
    return tuple(i for i, slot in enumerate(model.slots) if slot.entry in places)


def with_found(model: DamperModel, current: Round, best: Tally) -> DamperModel:
    """The model with an effect more."""
    candidate = current.candidates[best.attempt.effect]
    return replace(candidate, element=best.attempt.element(candidate)).added_to(model)[0]


def resumed(candidate: Candidate, done: Sequence[Attempt]) -> Candidate:
    """The candidate with where it ended in this round, where it had a part, as a further start."""
    attempted = next(a for a in done if a.effect == candidate.effect.name)
    if attempted.hidden or not np.any(attempted.change_fit):
        return candidate
    given = {name: value for name, value in candidate.element.parameters.items() if np.ndim(value) == 0}
    return replace(candidate, element=attempted.element(candidate), starts=(*candidate.starts, given))


def settled_together(model: DamperModel, added: Collection[str], scene: Scene, refits: bool) -> DamperModel:
    """The parameters of all that was found, fitted together; with all others where those are refitted."""
    if refits:
        return settled(model, [rows.measurement for rows in scene.fit], zero_free=True)
    problem = Problem(model, LocalRows(scene.fit), positions(model, added))
    if not problem.searched.size:
        point = problem.point(problem.start)
    else:
        _, size = start_sizes(problem, 0, 0)
        point, _ = refine(problem, problem.start, size, 6, 1e-3)
    return problem.model_at(problem.vector(point.searched, point.solved)) if np.isfinite(point.cost) else model
