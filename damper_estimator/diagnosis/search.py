"""Rounds of attempts: the best explanation goes into the model, and the next round looks for what is left."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from damper_estimator.diagnosis.attempt import Attempt, Null, attempt, null
from damper_estimator.diagnosis.candidates import Candidate, candidates
from damper_estimator.diagnosis.judge import Tally, nothing, rmse
from damper_estimator.diagnosis.pool import attempts
from damper_estimator.diagnosis.ranking import GAIN, Round, round_of
from damper_estimator.diagnosis.scene import Scene
from damper_estimator.diagnosis.settle import settled
from damper_estimator.identification import Problem
from damper_estimator.identification.methods.least_squares import refine
from damper_estimator.identification.start import candidates as start_sizes
from damper_estimator.model import DamperModel, Element
from damper_estimator.model.element import walk

MOST = 4  # findings
_WORTH = 0.03  # of the squared error: what explains less by itself is not looked at further
_POOR = 0.05  # of the force's rms: where a model errs by less, its parameters are kept
_USUAL = 0.5  # of the error now
_AGAINST_FIRST = 0.15  # of what the first one explained: less is a flaw of its form, not another effect

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Accepted:
    """An effect that a round accepted.

    Attributes:
        element: the entry with its fitted values.
        gain: with its 5 and 95 % ends.
    """

    round: Round
    tally: Tally
    element: Element
    tied: tuple[str, ...]
    confidence: float
    gain: tuple[float, float, float]
    before_n: float
    after_n: float


@dataclass(frozen=True)
class Search:
    """All rounds; ``model`` has the accepted effects in it, ``found`` are their positions in its slots.

    Attributes:
        mode: how they judge.
    """

    rounds: tuple[Round, ...]
    accepted: tuple[Accepted, ...]
    model: DamperModel
    found: tuple[int, ...]
    untestable: dict[str, str]
    mode: str


def search(
    model: DamperModel, scene: Scene, mode: str, skip: Collection[str], workers: int, progress: Progress
) -> Search:
    """Adds effects one after the other, until nothing more is justified.

    With ``both`` a model's parameters are kept, for it may take over part of an effect that came since; where it was
    never right, or where nothing is found so, they are refitted with every effect.
    """
    tried, untestable = candidates(model, scene.ranges)
    tried = [c for c in tried if c.effect.name not in skip]
    force_rms = float(np.sqrt(np.mean(np.concatenate([own.target for own in scene.unseen]) ** 2)))
    rounds: list[Round] = []
    accepted: list[Accepted] = []
    current = null(model, scene)
    found: tuple[int, ...] = ()
    poor = rmse(current, nothing(current)[0]) > _POOR * force_rms
    if mode == "both" and poor and _never_better(current):
        mode = "refit"
    while len(accepted) < MOST:
        worth = 0.0 if mode == "refit" else _WORTH
        done = attempts(current, tried, worth, workers, _told(progress, len(accepted), len(tried)))
        own = round_of(current, tried, done, mode)
        best = own.best
        if best is None or own.reason_against(best, force_rms) or not _counts(own, best, (*rounds, own)[0]):
            if mode == "both" and poor and not accepted:
                mode = "refit"
                continue
            rounds.append(own)
            break
        rounds.append(own)
        accepted.append(_accepted(own, best))
        model, found = _with(current.model, found, own.candidates[best.attempt.effect], best.attempt)
        if own.refits:
            model = settled(model, [rows.measurement for rows in scene.fit], zero_free=True)
            accepted[-1] = replace(accepted[-1], element=_entry(model, best.attempt.effect))
            current = null(model, scene, found)
        else:
            model = _settled(model, found, scene)
            current = _next(current, model, scene, found)
        still, _ = candidates(model, scene.ranges)
        names = {c.effect.name for c in still} - {best.attempt.effect}
        tried = [_resumed(c, done) for c in tried if c.effect.name in names]
    zero = _zero(rounds, accepted, scene, mode)
    return Search(tuple(rounds), tuple(accepted + zero), model, found, untestable, mode)


def _entry(model: DamperModel, effect: str) -> Element:
    """The last entry of an effect."""
    return [element for element in walk(model.effects) if element.effect.name == effect][-1]


def _never_better(current: Null) -> bool:
    """Whether the model was about as wrong when it was identified: then its parameters have no standing."""
    usual = float(current.model.fit.get("residual_stddev", 0.0) or 0.0)
    return usual > _USUAL * rmse(current, nothing(current)[0])


def _resumed(candidate: Candidate, done: Sequence[Attempt]) -> Candidate:
    """The candidate from where it ended in this round, where it had a part; what had none begins anew."""
    own = next(a for a in done if a.effect == candidate.effect.name)
    if own.hidden or not np.any(own.change_fit):
        return candidate
    return replace(candidate, element=own.element(candidate), starts=())


def _told(progress: Progress, round_number: int, count: int) -> Callable[[int], None]:
    what = "trying effects" if not round_number else f"{round_number} found, looking for more"
    begun = 1.0 - 0.5**round_number
    return lambda done: progress(what, begun + 0.5 ** (round_number + 1) * done / count)


def _counts(own: Round, best: Tally, first: Round) -> bool:
    """Whether a later finding is more than a flaw in the form of the first one, on either part of the data: a second
    effect may show little on the recordings that happen to be unseen.
    """
    if own is first:
        return True
    before, between, after = first.without, own.without, own.left(best)
    unseen = between.square - after.square >= _AGAINST_FIRST * (before.square - between.square)
    sums = [float(np.sum(errors.fit**2)) for errors in (before, between, after)]
    return unseen or sums[1] - sums[2] >= _AGAINST_FIRST * (sums[0] - sums[1])


def _accepted(own: Round, best: Tally) -> Accepted:
    tied = own.tied(best)
    return Accepted(
        round=own,
        tally=best,
        element=best.attempt.element(own.candidates[best.attempt.effect]),
        tied=tied,
        confidence=own.confidence((best.attempt.phenomenon, *tied)),
        gain=own.gain(best),
        before_n=rmse(own.null, own.without),
        after_n=rmse(own.null, own.left(best)),
    )


def _with(
    model: DamperModel, found: tuple[int, ...], candidate: Candidate, chosen: Attempt
) -> tuple[DamperModel, tuple[int, ...]]:
    """The model with an effect more, and where the parameters of all that was found are now."""
    fitted = replace(candidate, element=chosen.element(candidate))
    changed, own = fitted.added_to(model)
    kept = [i for i in range(len(changed.slots)) if i not in own]
    return changed, tuple(sorted([kept[i] for i in found] + list(own)))


def _settled(model: DamperModel, found: tuple[int, ...], scene: Scene) -> DamperModel:
    """The parameters of all that was found, fitted together."""
    problem = Problem(model, scene.fit, found)
    if not problem.searched.size:
        point = problem.point(problem.start)
    else:
        _, size = start_sizes(problem, [own.measurement for own in scene.fit], 0, 0)
        point, _ = refine(problem, problem.start, size, 6, 1e-3)
    return problem.model_at(problem.vector(point.searched, point.solved)) if np.isfinite(point.cost) else model


def _next(before: Null, model: DamperModel, scene: Scene, found: tuple[int, ...]) -> Null:
    """The next round's model; derivatives by the first one's parameters are near enough."""
    after = null(model, scene, found, base=())
    return replace(after, base_fit=before.base_fit, base_unseen=before.base_unseen)


def _zero(rounds: Sequence[Round], accepted: Sequence[Accepted], scene: Scene, mode: str) -> list[Accepted]:
    """Findings that the freed zero of the gauge hides: judged with it in the comparison, for the model as given and
    for what was found; an effect with a mean of its own shows in one of the two only.
    """
    first, last = rounds[0], rounds[-1]
    found = []
    for name in first.hidden:
        candidate = first.candidates[name]
        judged = []
        for own in (first, last) if last is not first else (first,):
            raw = null(own.null.model, scene.with_zero, base=())
            one = attempt(raw, candidate)
            if not one.hidden:
                judged.append(round_of(raw, [candidate], [one], "kept"))
        force = float(np.sqrt(np.mean(np.concatenate([own.target for own in scene.with_zero.unseen]) ** 2)))
        if judged and all(own.best and not own.reason_against(own.best, force) for own in judged):
            if all(own.gain(own.best)[0] >= GAIN for own in judged):
                found.append(_accepted(judged[-1], judged[-1].best))
    return found
