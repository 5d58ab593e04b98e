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
from damper_estimator.identification import LocalRows, Problem
from damper_estimator.identification.methods.least_squares import refine
from damper_estimator.identification.start import candidates as start_sizes
from damper_estimator.model import DamperModel, Element
from damper_estimator.model.element import labels, walk

MOST = 4  # findings
_WORTH = 0.03  # of the squared error: what explains less by itself is not looked at further
_POOR = 0.05  # of the force's rms: where a model errs by less, its parameters are kept
_USUAL = 0.5  # of the error now
_RIVALS = 6  # of a finding, that it is held against once more
_AGAINST_FIRST = 0.05  # of what the first one explained: less is a flaw of its form, not another effect

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
    """All rounds; ``model`` has the accepted effects in it.

    Attributes:
        left_n: unseen error with them, N.
        mode: how they judge.
    """

    rounds: tuple[Round, ...]
    accepted: tuple[Accepted, ...]
    model: DamperModel
    left_n: float
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
        model = _settled(_with(current.model, own, best), _names(accepted), scene, own.refits)
        if len(accepted) > 1:
            told = _told(progress, len(accepted), len(tried))
            accepted, model = _looked_again(accepted, model, scene, mode, workers, told)
        current = _next(current, model, scene, _names(accepted), own.refits)
        accepted[-1] = replace(accepted[-1], after_n=rmse(current, nothing(current)[int(own.refits)]))
        still, _ = candidates(model, scene.ranges)
        names = {c.effect.name for c in still} - set(_names(accepted))
        tried = [_resumed(c, done) for c in tried if c.effect.name in names]
    zero = _zero(rounds[0], current.model, scene, _names(accepted))
    accepted = [replace(one, element=_entry(current.model, one.element.effect.name)) for one in accepted]
    left = rmse(current, nothing(current)[int(mode == "refit")])
    return Search(tuple(rounds), tuple(accepted + zero), current.model, left, untestable, mode)


def _names(accepted: Sequence[Accepted]) -> list[str]:
    return [one.element.effect.name for one in accepted]


def _entry(model: DamperModel, effect: str) -> Element:
    """The entry that was added: an effect's last."""
    return [element for element in walk(model.effects) if element.effect.name == effect][-1]


def _positions(model: DamperModel, added: Collection[str]) -> tuple[int, ...]:
    """Where the parameters of added effects are in the model's slots."""
    entries = list(walk(model.effects))
    own = {max(i for i, element in enumerate(entries) if element.effect.name == name) for name in added}
    return tuple(i for i, slot in enumerate(model.slots) if slot.entry in own)


def _never_better(current: Null) -> bool:
    """Whether the model was about as wrong when it was identified: then its parameters have no standing."""
    usual = float(current.model.fit.get("residual_stddev", 0.0) or 0.0)
    return usual > _USUAL * rmse(current, nothing(current)[0])


def _resumed(candidate: Candidate, done: Sequence[Attempt]) -> Candidate:
    """The candidate with where it ended in this round, where it had a part, as a further start."""
    own = next(a for a in done if a.effect == candidate.effect.name)
    if own.hidden or not np.any(own.change_fit):
        return candidate
    given = {name: value for name, value in candidate.element.parameters.items() if np.ndim(value) == 0}
    return replace(candidate, element=own.element(candidate), starts=(*candidate.starts, given))


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
    return _as_found(own, best, *_rivalled(own, best))


def _as_found(own: Round, best: Tally, tied: tuple[str, ...], confidence: float) -> Accepted:
    return Accepted(
        round=own,
        tally=best,
        element=best.attempt.element(own.candidates[best.attempt.effect]),
        tied=tied,
        confidence=confidence,
        gain=own.gain(best),
        before_n=rmse(own.null, own.without),
        after_n=rmse(own.null, own.left(best)),
    )


def _rivalled(own: Round, best: Tally) -> tuple[tuple[str, ...], float]:
    """What else it could be, and how sure the group is."""
    tied = own.tied(best)
    return tied, own.confidence((best.attempt.phenomenon, *tied))


def _with(model: DamperModel, own: Round, best: Tally) -> DamperModel:
    """The model with an effect more."""
    candidate = own.candidates[best.attempt.effect]
    return replace(candidate, element=best.attempt.element(candidate)).added_to(model)[0]


def _settled(model: DamperModel, added: Collection[str], scene: Scene, refits: bool) -> DamperModel:
    """The parameters of all that was found, fitted together; with all others where those are refitted."""
    if refits:
        return settled(model, [rows.measurement for rows in scene.fit], zero_free=True)
    problem = Problem(model, LocalRows(scene.fit), _positions(model, added))
    if not problem.searched.size:
        point = problem.point(problem.start)
    else:
        _, size = start_sizes(problem, 0, 0)
        point, _ = refine(problem, problem.start, size, 6, 1e-3)
    return problem.model_at(problem.vector(point.searched, point.solved)) if np.isfinite(point.cost) else model


def _next(before: Null, model: DamperModel, scene: Scene, added: Collection[str], refits: bool) -> Null:
    """The next round's model; where the first one's parameters are kept, its derivatives by them are near enough."""
    found = _positions(model, added)
    if refits:
        return null(model, scene, found)
    after = null(model, scene, found, base=())
    return replace(after, base_fit=before.base_fit, base_unseen=before.base_unseen)


def _looked_again(
    accepted: Sequence[Accepted],
    model: DamperModel,
    scene: Scene,
    mode: str,
    workers: int,
    progress: Callable[[int], None],
) -> tuple[list[Accepted], DamperModel]:
    """Every earlier finding against its rivals with all others in place, and the model with what is better now: when
    it was chosen, what came later was in the residual, and it may have stood in for that.
    """
    looked = list(accepted)
    for i, one in enumerate(accepted[:-1]):
        name = one.element.effect.name
        others = [other for other in _names(looked) if other != name]
        entry = _entry(model, name)
        less = model.without(next(label for label, element in labels(model.effects) if element is entry))
        rivals = [t.attempt for t in one.round.tallies if one.round.gain(t)[0] >= GAIN][:_RIVALS]
        tried = [c for c in candidates(less, scene.ranges)[0] if c.effect.name in {a.effect for a in rivals}]
        tried = [_resumed(c, rivals) for c in tried if c.effect.name not in others]
        base = None if one.round.refits else ()
        stage = null(less, scene, _positions(less, others), base)
        own = round_of(stage, tried, attempts(stage, tried, 0.0, workers, lambda done: progress(0)), mode)
        best = own.best
        tied, confidence = _rivalled(own, best)
        if best.attempt.effect == name:
            looked[i] = replace(one, tied=tied, confidence=confidence)
            continue
        first = next(t for t in one.round.tallies if t.attempt.effect == best.attempt.effect)
        looked[i] = _as_found(one.round, first, tied, confidence)
        looked[i + 1] = replace(looked[i + 1], before_n=looked[i].after_n)
        model = _settled(_with(less, own, best), [*others, best.attempt.effect], scene, own.refits)
    return looked, model


def _zero(first: Round, model: DamperModel, scene: Scene, added: Collection[str]) -> list[Accepted]:
    """Findings that the freed zero of the gauge hides, judged with it in the comparison, beside all that was found:
    effects with a mean of their own are fitted with the zero as well, and may explain it.
    """
    found = []
    for name in first.hidden:
        candidate = first.candidates[name]
        raw = null(model, scene.with_zero, _positions(model, added), base=())
        one = attempt(raw, candidate)
        if one.hidden:
            continue
        own = round_of(raw, [candidate], [one], "kept")
        force = float(np.sqrt(np.mean(np.concatenate([rows.target for rows in scene.with_zero.unseen]) ** 2)))
        if not own.reason_against(own.best, force) and own.gain(own.best)[0] >= GAIN:
            found.append(_accepted(own, own.best))
    return found
