"""Rounds of attempts: the best explanation goes into the model, and the next round looks for what is left."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from damper_estimator.diagnosis.accepted import (
    Accepted,
    accepted_in,
    as_found,
    entry_of,
    names_of,
    positions,
    resumed,
    rivalled,
    settled_together,
    with_found,
)
from damper_estimator.diagnosis.attempt import attempt
from damper_estimator.diagnosis.candidates import candidates
from damper_estimator.diagnosis.judge import Tally, nothing, rmse
from damper_estimator.diagnosis.null import Null, null
from damper_estimator.diagnosis.pairs import paired
from damper_estimator.diagnosis.pool import attempts
from damper_estimator.diagnosis.ranking import Round, round_of
from damper_estimator.diagnosis.scene import Scene
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.model import DamperModel
from damper_estimator.model.element import labels

MOST = 4  # findings
_WORTH = 0.03  # of the squared error: what explains less by itself is not looked at further
_RIVALS = 6  # of a finding, that it is held against once more

Progress = Callable[[str, float], None]


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
    model: DamperModel,
    scene: Scene,
    mode: str,
    skip: Collection[str],
    workers: int,
    progress: Progress,
    trusted: bool = False,
) -> Search:
    """Adds effects one after the other, until nothing more is justified.

    With ``both`` a model's parameters are kept, for it may take over part of an effect that came since; where it was
    never right, or where nothing is found so, they are refitted with every effect. If the model is ``trusted``,
    because what it always got wrong is out of the way, they are kept throughout.
    """
    tried, untestable = candidates(model, scene.ranges)
    tried = [c for c in tried if c.effect.name not in skip]
    force_rms = scene.force_rms
    rounds: list[Round] = []
    accepted: list[Accepted] = []
    current = null(model, scene)
    poor = not trusted and rmse(current, nothing(current)[0]) > limits().poor * force_rms
    if mode == "both" and poor and _never_better(current):
        mode = "refit"
    while len(accepted) < MOST:
        # Beside effects that were found, even one that explains nothing while they stay as they are may matter.
        worth = 0.0 if mode == "refit" or accepted else _WORTH
        done = attempts(current, tried, worth, workers, _told(progress, len(accepted), len(tried)))
        found = round_of(current, tried, done, mode)
        best = found.best
        if best is None or found.reason_against(best, force_rms) or not _counts(found, best, (*rounds, found)[0]):
            best = None
        report = _told(progress, len(accepted), 2 * len(tried))
        two = paired(found, best, tried, names_of(accepted), workers, report)
        if two is None and best is None and mode == "both" and poor and not accepted:
            mode = "refit"
            continue
        rounds.append(found)
        if two is not None:
            accepted, model = accepted + two[0], two[1]
        elif best is not None:
            accepted.append(accepted_in(found, best))
            model = settled_together(with_found(current.model, found, best), names_of(accepted), scene, found.refits)
            if len(accepted) > 1:
                accepted, model = _looked_again(accepted, model, scene, mode, workers, report)
        else:
            break
        current = _next(current, model, scene, names_of(accepted), found.refits)
        accepted[-1] = replace(accepted[-1], after_n=rmse(current, nothing(current)[int(found.refits)]))
        still, _ = candidates(model, scene.ranges)
        names = {c.effect.name for c in still} - set(names_of(accepted))
        tried = [resumed(c, done) for c in tried if c.effect.name in names]
    zero = _zero(rounds[0], current.model, scene, names_of(accepted))
    accepted = [replace(one, element=entry_of(current.model, one.element.effect.name)) for one in accepted]
    left = rmse(current, nothing(current)[int(mode == "refit")])
    return Search(tuple(rounds), tuple(accepted + zero), current.model, left, untestable, mode)


def as_if_by(first: Round) -> tuple[Accepted, ...]:
    """What changed parameters act like: the effect that explains most while they are kept, if it explains enough."""
    best = first.best
    if best is None or first.gain(best)[0] < limits().gain:
        return ()
    return (accepted_in(first, best),)


def _never_better(current: Null) -> bool:
    """Whether the model was about as wrong when it was identified: then its parameters have no standing."""
    usual = float(current.model.fit.get("residual_stddev", 0.0) or 0.0)
    return usual > limits().usual * rmse(current, nothing(current)[0])


def _told(progress: Progress, round_number: int, count: int) -> Callable[[int], None]:
    what = "trying effects" if not round_number else f"{round_number} found, looking for more"
    begun = 1.0 - 0.5**round_number
    return lambda done: progress(what, begun + 0.5 ** (round_number + 1) * done / count)


def _counts(current: Round, best: Tally, first: Round) -> bool:
    """Whether a later finding is more than a flaw in the form of the first one, on either part of the data: a second
    effect may show little on the recordings that happen to be unseen.
    """
    if current is first:
        return True
    before, between, after = first.without, current.without, current.left(best)
    unseen = between.square - after.square >= limits().second * (before.square - between.square)
    sums = [float(np.sum(errors.fit**2)) for errors in (before, between, after)]
    return unseen or sums[1] - sums[2] >= limits().second * (sums[0] - sums[1])


def _next(before: Null, model: DamperModel, scene: Scene, added: Collection[str], refits: bool) -> Null:
    """The next round's model; where the first one's parameters are kept, its derivatives by them are near enough."""
    found = positions(model, added)
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
        others = [other for other in names_of(looked) if other != name]
        entry = entry_of(model, name)
        less = model.without(next(label for label, element in labels(model.effects) if element is entry))
        rivals = [t.attempt for t in one.round.tallies if one.round.gain(t)[0] >= limits().gain][:_RIVALS]
        tried = [c for c in candidates(less, scene.ranges)[0] if c.effect.name in {a.effect for a in rivals}]
        tried = [resumed(c, rivals) for c in tried if c.effect.name not in others]
        base = None if one.round.refits else ()
        stage = null(less, scene, positions(less, others), base)
        found = round_of(stage, tried, attempts(stage, tried, 0.0, workers, lambda done: progress(0)), mode)
        best = found.best
        tied, confidence = rivalled(found, best)
        if best.attempt.effect == name:
            looked[i] = replace(one, tied=tied, confidence=confidence)
            continue
        first = next(t for t in one.round.tallies if t.attempt.effect == best.attempt.effect)
        looked[i] = as_found(one.round, first, tied, confidence)
        looked[i + 1] = replace(looked[i + 1], before_n=looked[i].after_n)
        model = settled_together(with_found(less, found, best), [*others, best.attempt.effect], scene, found.refits)
    return looked, model


def _zero(first: Round, model: DamperModel, scene: Scene, added: Collection[str]) -> list[Accepted]:
    """Findings that the freed zero of the gauge hides, judged with it in the comparison, beside all that was found:
    effects with a mean of their own are fitted with the zero as well, and may explain it.
    """
    found = []
    for name in first.hidden:
        candidate = first.candidates[name]
        raw = null(model, scene.with_zero, positions(model, added), base=())
        one = attempt(raw, candidate)
        if one.hidden:
            continue
        judged = round_of(raw, [candidate], [one], "kept")
        if (
            not judged.reason_against(judged.best, scene.with_zero.force_rms)
            and judged.gain(judged.best)[0] >= limits().gain
        ):
            found.append(accepted_in(judged, judged.best))
    return found
