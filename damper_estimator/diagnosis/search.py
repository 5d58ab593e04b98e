"""Rounds of hypotheses: the best explanation goes into the model, and the next round looks for what is left."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from damper_estimator.diagnosis.accepted import (
    Accepted,
    accepted_in,
    fitted_together,
    positions,
    regions_of,
)
from damper_estimator.diagnosis.baseline import Baseline, baseline_of
from damper_estimator.diagnosis.diagnosis_data import DiagnosisData
from damper_estimator.diagnosis.evaluation import Errors, rmse, without_effects
from damper_estimator.diagnosis.hypotheses import Hypothesis, entry_of, hypotheses_for, settled
from damper_estimator.diagnosis.means import found_in_means
from damper_estimator.diagnosis.pairs import paired
from damper_estimator.diagnosis.parallel_fits import WORTH, all_fitted
from damper_estimator.diagnosis.ranking import Round, round_of
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.model import DamperModel

MOST = 4  # findings
NOT_NEW = "has always been missing: the error is not new"
TOO_SMALL = "the whole error is too small to name an effect"
NOT_IDENTIFIED_THERE = "most of the error lies at velocities that the model was not identified at"
_MOST_OF_IT = 0.5  # of it: the mean of a usual error differs from drive to drive, and is a smaller part

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Search:
    """What the rounds found; ``model`` has the accepted effects in it.

    Attributes:
        first: the first round.
        left_n: unseen error with them, N.
        mode: how the rounds evaluate: both, kept or refit.
        set_aside: why effects are evaluated, but not added; "" where they are.
        beyond_known: whether the error that the model has always had was subtracted before.
    """

    first: Round
    accepted: tuple[Accepted, ...]
    model: DamperModel
    left_n: float
    untestable: dict[str, str]
    mode: str
    set_aside: str = ""
    beyond_known: bool = False

    @property
    def without_n(self) -> float:
        """Unseen error without any finding, N."""
        return rmse(self.first.baseline, self.first.without)


@dataclass(frozen=True)
class _Pass:
    """The first round in one mode, what all accepted, and the model after the last one."""

    mode: str
    first: Round
    accepted: list[Accepted]
    last: Baseline


def search(
    model: DamperModel,
    data: DiagnosisData,
    mode: str,
    skip: Collection[str],
    workers: int,
    progress: Progress,
    *,
    trusted: bool = False,
    is_identified_here: bool = False,
) -> Search:
    """Adds effects one after the other, until nothing more is justified.

    With ``both`` a model's parameters are kept: refitted with an effect, they take over part of what it should explain.
    A model that was identified on these recordings has done so already, and is refitted with every effect; others are
    if nothing is found with their parameters kept. If the model is ``trusted``, because the error that it always had is
    subtracted, they are kept throughout.
    """
    tried, untestable = _tried(model, data, skip)
    start = baseline_of(model, data)
    error = rmse(start, without_effects(start)[0])
    may_refit = mode == "both" and not trusted and error > limits().poor * data.force_rms
    if may_refit and is_identified_here:
        found = _rounds("refit", start, tried, workers, progress, jointly=True)
    else:
        found = _rounds(mode, start, tried, workers, progress)
        if may_refit and not found.accepted:
            found = _rounds("refit", start, tried, workers, progress)
    last = found.last
    accepted = [replace(one, element=entry_of(last.model, one.element.effect.name)) for one in found.accepted]
    # A refit with the zero freed leaves a mean of the model undetermined.
    settled_model, added = (model, ()) if found.mode == "refit" else (last.model, accepted)
    means = found_in_means(found.first, data, settled_model, added, skip, workers)
    accepted = [one for one in accepted if one.hypothesis.name not in {mean.hypothesis.name for mean in means}]
    left = rmse(last, without_effects(last)[int(found.mode == "refit")])
    most = max((one.fall for one in accepted), default=0.0)
    ahead, behind = ([one for one in means if (one.fall > most) == first] for first in (True, False))
    ordered = (*ahead, *accepted, *behind)
    return Search(found.first, ordered, last.model, left, untestable, found.mode)


def evaluated_only(
    model: DamperModel,
    data: DiagnosisData,
    skip: Collection[str],
    workers: int,
    progress: Progress,
    because: str,
    *,
    beyond_known: DiagnosisData,
    least: float = _MOST_OF_IT,
) -> Search:
    """All hypotheses evaluated once, fitted to excerpts, with the model's parameters kept. None is accepted but a zero
    that explains enough of what is new: the gauge's belongs to the recordings, whatever the model has always lacked.

    Args:
        beyond_known: the recordings without the error that the model has always had, as far as that is known.
        because: why nothing else is accepted.
        least: share of the squared error that a zero must explain.
    """
    tried, untestable = _tried(model, data, skip)
    baseline = baseline_of(model, data)
    fitted = all_fitted(baseline, tried, WORTH, workers, _report(progress, 0, len(tried)), most=0.0)
    first = round_of(baseline, fitted, "both")
    zeros = tuple(found_in_means(first, beyond_known, model, (), skip, workers, least))
    left = rmse(baseline, first.without)
    return Search(first, zeros, model, left, untestable, "both", "" if zeros else because)


def _tried(model: DamperModel, data: DiagnosisData, skip: Collection[str]) -> tuple[list[Hypothesis], dict[str, str]]:
    found, untestable = hypotheses_for(model, data.ranges)
    return [hypothesis for hypothesis in found if hypothesis.name not in skip], untestable


def _rounds(
    mode: str,
    start: Baseline,
    tried: Sequence[Hypothesis],
    workers: int,
    progress: Progress,
    jointly: bool = False,
) -> _Pass:
    """One pass: rounds in one mode from the same start; ``jointly`` as in ``round_of``."""
    data, current = start.data, start
    first: Round | None = None  # later ones are not kept: those of an hour take much memory
    accepted: list[Accepted] = []
    while True:
        # Next to effects that were found, one that explains nothing while they stay as they are may matter.
        worth = 0.0 if mode == "refit" or accepted else WORTH
        fitted = all_fitted(current, tried, worth, workers, _report(progress, len(accepted), len(tried)))
        found = round_of(current, fitted, mode, jointly)
        first = first or found
        best = _supported(found, first)
        report = _report(progress, len(accepted), 2 * len(tried))
        pair = paired(found, tried, regions_of(accepted), workers, report)
        if pair is not None:
            accepted, model = accepted + pair[0], pair[1]
        elif best is not None:
            accepted.append(accepted_in(found, best))
            model = fitted_together(best.fitted_into(current.model), regions_of(accepted), data, found.refits)
        else:
            break
        current = _next(current, model, regions_of(accepted), found.refits)
        left = without_effects(current)[int(found.refits)]
        accepted[-1] = replace(accepted[-1], after_n=rmse(current, left))
        if len(accepted) >= MOST or not _explains_enough(first.without, left):
            break
        names = {one.name for one in hypotheses_for(model, data.ranges)[0]} - settled(regions_of(accepted))
        tried = [one.resumed(one) for one in fitted if one.name in names]
        first = first.concluded
        del fitted, found, best  # they take much memory for long recordings
    return _Pass(mode, first, accepted, current)


def _supported(found: Round, first: Round) -> Hypothesis | None:
    """The best hypothesis that a round supports; ``first`` is the first round of the pass."""
    supported = found.supported(found.baseline.data.force_rms)
    return next((one for one in supported if _counts(found, one, first)), None)


def as_if_by(first: Round) -> tuple[Accepted, ...]:
    """What changed parameters act like: the effect that explains most while they are kept, if it explains enough."""
    best = first.best
    if best is None or first.gain(best)[0] < limits().gain:
        return ()
    return (accepted_in(first, best),)


def _report(progress: Progress, round_number: int, count: int) -> Callable[[int], None]:
    what = "trying effects" if not round_number else f"{round_number} found, looking for more"
    begun = 1.0 - 0.5**round_number
    return lambda done: progress(what, begun + 0.5 ** (round_number + 1) * done / count)


def _counts(current: Round, best: Hypothesis, first: Round) -> bool:
    """Whether a later finding is more than a flaw in the form of the first one, on either part of the data: a second
    effect may show little on the recordings that happen to be unseen.
    """
    if current is first:
        return True
    return _explains_enough(first.without, current.without, current.left(best))


def _explains_enough(before: Errors, between: Errors, after: Errors | None = None) -> bool:
    """Whether a later finding, which leaves ``after``, explains enough of what the earlier ones leave; without
    ``after``, whether any could, that left nothing.
    """
    squares = [
        (one.square, float(np.sum(one.fit**2))) if one is not None else (0.0, 0.0) for one in (before, between, after)
    ]
    return any(now - then >= limits().second * (first - now) for first, now, then in zip(*squares, strict=True))


def _next(before: Baseline, model: DamperModel, added: Collection[str], refits: bool) -> Baseline:
    """The next round's model; where the first one's parameters are kept, its derivatives by them are near enough."""
    found = positions(model, added)
    if refits:
        return baseline_of(model, before.data, found)
    after = baseline_of(model, before.data, found, base=())
    return replace(after, base_fit=before.base_fit, base_unseen=before.base_unseen)
