"""What a search comes to: the verdict, and the findings that keep their promise once they are in the model.

An explanation is fitted beside the model, with the gauge's zero and drift left out of the comparison, and often the
error that the model has always had. Identified in the model it may not deliver what it promised. Then the search is
done once more with the error as measured, or, if that was done, without what did not deliver.
"""

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from damper_estimator.diagnosis.accepted import Accepted, breaks_tie, regions_of, together
from damper_estimator.diagnosis.apply_finding import ModelState
from damper_estimator.diagnosis.beyond_region import Beyond, inside_region
from damper_estimator.diagnosis.diagnosis_data import DiagnosisData, dynamic_force, force_rows, targets
from damper_estimator.diagnosis.error_shares import error_shares, motion_factors, share_of_force, with_changes
from damper_estimator.diagnosis.explanation import ranking_of
from damper_estimator.diagnosis.misfit import has_grown, misfit_of, usual_bound
from damper_estimator.diagnosis.moving_zero import drift_hides_error
from damper_estimator.diagnosis.reduced_data import recorded_data, with_and_without_known
from damper_estimator.diagnosis.reidentify import Reidentified, reidentified
from damper_estimator.diagnosis.result import RankedEffect, Structure
from damper_estimator.diagnosis.search import (
    NOT_IDENTIFIED_THERE,
    NOT_NEW,
    TOO_SMALL,
    Search,
    as_if_by,
    evaluated_only,
    search,
)
from damper_estimator.diagnosis.steps import Step, steps_of
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.diagnosis.verdict import taken_over, verdict_on

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Outcome:
    """A search and what follows from it.

    Attributes:
        again: the model identified again; None where its parameters are trusted.
        picture: of what is unexplained, where there is structure.
        steps: findings that lower the error.
        undelivered: effects that were set aside because they did not.
    """

    found: Search
    again: Reidentified | None
    verdict: str
    picture: Structure | None = None
    steps: tuple[Step, ...] = ()
    undelivered: tuple[RankedEffect, ...] = ()


def outcome_of(
    state: ModelState,
    beyond: Beyond | None,
    floor_n: float,
    mode: str,
    skip: Collection[str],
    workers: int,
    progress: Progress,
) -> Outcome:
    """The outcome of a search; of a second one where nothing that the first one found delivers, if that does: with the
    error as measured, or without what was found.

    Args:
        beyond: where most of the error lies, if it is one of extrapolation.
        floor_n: noise floor, N.
        skip: effects that are not tried.
    """
    searched = partial(_searched, state, beyond, floor_n, mode)
    first = searched(skip, workers, lambda text, share: progress(text, 0.05 + 0.85 * share))
    if first.steps or not first.found.accepted:
        return first
    if first.found.beyond_known:
        again = searched(skip, workers, lambda text, share: progress(text, 0.9 + 0.1 * share), as_measured=True)
        if again.steps:
            return again
    if first.verdict != "unexplained":
        return first
    promising = set(regions_of(together(first.found.accepted)[0]))
    again = searched({*skip, *promising}, workers, lambda text, share: progress(text, 0.9 + 0.1 * share))
    if not again.steps:
        return first
    aside = tuple(row for row in ranking_of(first.found, set()) if row.effect in promising)
    return replace(again, undelivered=aside)


def _searched(
    state: ModelState,
    beyond: Beyond | None,
    floor_n: float,
    mode: str,
    skip: Collection[str],
    workers: int,
    progress: Progress,
    *,
    as_measured: bool = False,
) -> Outcome:
    look = partial(first_search, mode=mode, skip=skip, workers=workers, as_measured=as_measured)
    found, data = _inside_first(state, beyond, mode, look, lambda text, share: progress(text, 0.85 * share))
    if found.set_aside:
        return Outcome(found, None, "nothing_missing")
    progress("identifying the parameters of the model", 0.85)
    again = reidentified(found.first, data) if mode != "kept" else None
    force, here = dynamic_force(data.unseen), state.is_identified_here
    judged = partial(verdict_on, again=again, force_n=force, floor_n=floor_n, is_identified_here=here)
    verdict, picture = judged(found)
    progress("adding what was found", 0.95)
    steps, named = [], found.accepted
    if verdict == "missing":
        steps = steps_of(state, found.accepted, mode)
        if again is not None and taken_over(found, [one.hypothesis.name for one, *_ in steps], again):
            verdict = "parameters_changed"
        elif not steps:
            named, found = (), replace(found, left_n=found.without_n)
            verdict, picture = judged(replace(found, accepted=named))
    if verdict == "parameters_changed":
        found = replace(found, accepted=named or as_if_by(found.first))
        steps = steps_of(state, found.accepted, mode, names_changes=again is not None)
    # Without a candidate only a large growth counts: errors on good recordings of one damper differ by up to two.
    allowed = float(np.sqrt(limits().growth))
    is_small = share_of_force(state, data) < allowed * usual_bound(state.model)
    is_old = is_small and not has_grown(
        state.model, share_of_force(state, data, motion_factors(state.model, data)) / allowed
    )
    if verdict == "unexplained" and not here and is_old:
        verdict, picture, found = "nothing_missing", None, replace(found, set_aside=NOT_NEW)
    return Outcome(found, again, verdict, picture, tuple(steps))


def _half(progress: Progress, text: str, share: float) -> None:
    progress(text, 0.5 * share)


def _inside_first(
    state: ModelState,
    beyond: Beyond | None,
    mode: str,
    look: Callable[..., tuple[Search, DiagnosisData]],
    progress: Progress,
) -> tuple[Search, DiagnosisData]:
    """What ``look``, which is ``first_search``, finds. Where most of the error is one of extrapolation, it looks inside
    the region of the identification first: outside, a wrong curve hides what is missing everywhere. If the velocities
    are new, it looks nowhere else. Otherwise what it finds outside may break a tie of what it finds inside: a test that
    separates a gas from a straight spring goes farther than the recordings in which they were tied.
    """
    looks_inside = beyond is not None and mode != "refit" and not state.is_identified_here
    inside = inside_region(state, beyond) if looks_inside else None
    if inside is None:
        return look(state, progress=progress)
    found = look(inside, progress=partial(_half, progress))
    if found[0].accepted and not found[0].set_aside:
        if not found[0].accepted[0].tied or beyond.is_of_velocity:
            return found
        whole = look(state, progress=progress)
        return whole if breaks_tie(whole[0].accepted, found[0].accepted) else found
    because = NOT_IDENTIFIED_THERE if mode == "both" and beyond.is_of_velocity else ""
    return look(state, progress=progress, because=because)


def _with_measured(found: Search, state: ModelState) -> Search:
    """What was found beyond the known error, as far as it lowers the error as measured; nothing if it is but a mean on
    the recordings of the identification, where it is not new, and the old error is what the model lacks.
    """
    measured = tuple(one for one in found.accepted if _is_measured(one, state))
    is_old = state.is_identified_here and all(one.is_mean for one in measured)
    return replace(found, accepted=() if is_old else measured, beyond_known=True)


def _is_measured(one: Accepted, state: ModelState) -> bool:
    """Whether a finding beyond the known error is no mean, or one that lowers the error as measured: a mean that the
    known error had on another motion may be missing here, without a zero that changed.
    """
    if not one.is_mean:
        return True
    rows = recorded_data(state).with_zero.unseen
    without, with_it = (
        np.sum((force_rows(each, rows) - targets(rows)) ** 2)
        for each in (state.model, one.hypothesis.fitted_into(state.model))
    )
    return bool(with_it < without)


def first_search(
    state: ModelState,
    mode: str,
    skip: Collection[str] = (),
    workers: int = 1,
    progress: Callable[[str, float], None] = lambda text, share: None,
    *,
    because: str = "",
    as_measured: bool = False,
) -> tuple[Search, DiagnosisData]:
    """What was found before it is added to the model, and on which recordings: without the error that the model had
    when it was identified, if that accounts for part of the error and leaves more than it did then; otherwise as
    measured. A small error, and a usual one that the model has always had, is evaluated only.

    Args:
        because: why nothing is added in any case; "" where effects are looked for.
        as_measured: whether the known error is not subtracted in any case.
    """
    known, asks_for_change = misfit_of(state.model.fit), mode == "both" and not state.is_identified_here
    data, beyond_known, is_accounted_for = with_and_without_known(state, asks_for_change)
    if drift_hides_error(state.model, data):
        data, beyond_known = data.with_drift, beyond_known.with_drift
    shares = error_shares(state, data, beyond_known)
    leaves_more = known is None or known.leaves_more(shares.beyond_known / shares.factor)
    if asks_for_change:
        data, beyond_known = with_changes(state.model, shares, data, beyond_known)
    # A zero that has changed makes nothing else new.
    grown, grown_with_zero = (has_grown(state.model, each) for each in (shares.rest_then, shares.with_zero_then))
    if not because and asks_for_change and shares.with_zero < limits().notable:
        because = TOO_SMALL if grown_with_zero else NOT_NEW
    # An error that has grown is usual as long as the known error accounts for it; one that has not, if it
    # is not large or nothing could be named in it then.
    bound = usual_bound(state.model) if not grown else 0.0 if leaves_more else limits().acceptable
    evaluated = partial(evaluated_only, state.model, data, skip, workers, progress, beyond_known=beyond_known)
    # Where little but a mean has changed, nothing else is named: beside it another effect may seem to matter.
    if not because and asks_for_change and shares.unseen < limits().notable:
        found = evaluated(TOO_SMALL, least=0.0)
        if found.accepted:
            return found, data
    is_worth = leaves_more and shares.beyond_known > limits().least_force
    if not because and is_accounted_for and not as_measured and is_worth:
        found = search(state.model, beyond_known, mode, skip, workers, partial(_half, progress), trusted=True)
        found = _with_measured(found, state)
        if found.accepted:
            return found, beyond_known
    if not because and asks_for_change and shares.rest < bound:
        if grown_with_zero and not grown:
            return evaluated(NOT_NEW, beyond_known=data, least=0.0), data
        because = NOT_NEW
    if because:
        return evaluated(because), data
    return search(state.model, data, mode, skip, workers, progress, is_identified_here=state.is_identified_here), data
