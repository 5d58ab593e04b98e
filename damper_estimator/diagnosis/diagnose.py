"""Names the physical effects that a model lacks, as far as the recordings show it.

Hypotheses are fitted with the model's parameters kept and evaluated on unseen data; the best one is added, and the next
round explains what is left. In addition the model is re-identified without new effects, to distinguish changed
parameters from a missing effect.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from damper_estimator.diagnosis.accepted import Accepted, together
from damper_estimator.diagnosis.apply_finding import ModelState, applied, identified_first, state_of
from damper_estimator.diagnosis.atlas_curves import atlas_curves
from damper_estimator.diagnosis.diagnosis_data import (
    DiagnosisData,
    data_of,
    dynamic_force,
    force_rows,
    targets,
    unweighted,
)
from damper_estimator.diagnosis.division import all_divided
from damper_estimator.diagnosis.explanation import (
    atlas_of,
    finding_of,
    phenomena_of,
    ranking_of,
)
from damper_estimator.diagnosis.informative import stretches_used
from damper_estimator.diagnosis.misfit import has_grown, misfit_of, probability_of_change, without_misfit
from damper_estimator.diagnosis.reidentify import Reidentified, reidentified
from damper_estimator.diagnosis.result import Diagnosis, Structure
from damper_estimator.diagnosis.search import Search, as_if_by, search, surveyed
from damper_estimator.diagnosis.sentences import identified_sentence, sentence_of, unexplained_sentence
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.diagnosis.verdict import verdict_on
from damper_estimator.identification import usable
from damper_estimator.identification.fit_record import recorded
from damper_estimator.model import DamperModel
from damper_estimator.signals import Measurement
from damper_estimator.validation import Comparison, compare, data_findings, reference_error

MODES = ("both", "kept", "refit")


def diagnose(
    model: DamperModel,
    fit: Sequence[Measurement],
    unseen: Sequence[Measurement] = (),
    *,
    mode: str = "both",
    workers: int = 1,
    progress: Callable[[str, float], None] | None = None,
    skip: Collection[str] = (),
) -> Diagnosis:
    """Which effects are missing.

    Args:
        model: the user's, with parameters that were identified before.
        fit: recordings that parameters are found on.
        unseen: recordings that explanations are judged on; 40 % of each of ``fit`` if empty (``divided``).
        mode: ``both``; ``kept``: the model's parameters are trusted; ``refit``: they are not.
        workers: processes.
        progress: called with the activity in words and the share that is done; an exception from it ends the work.
        skip: effects that are not tried.

    Raises:
        InputError: where a recording has no force, or lacks a channel that the model needs.
        ValueError: unknown mode.
    """
    if mode not in MODES:
        raise ValueError(f"mode {mode!r} is none of {', '.join(MODES)}")
    report = progress or (lambda text, share: None)
    report("reading the model's error", 0.0)
    given = begun(model, fit, unseen)
    state = identified_first(given, mode)
    found, data = first_search(state, mode, skip, workers, lambda text, share: report(text, 0.05 + 0.75 * share))
    is_usual = found.is_survey
    report("identifying the parameters of the model", 0.8)
    again = reidentified(found.rounds[0], data) if mode != "kept" and not is_usual else None
    before = compare(state.model, *state.unseen)
    force, floor = dynamic_force(data), before.noise_floor_n
    judged = partial(verdict_on, again=again, force_n=force, floor_n=floor, is_identified_here=state.is_identified_here)
    verdict, picture = ("nothing_missing", None) if is_usual else judged(found)
    report("adding what was found", 0.9)
    steps, named = [], found.accepted
    if verdict == "missing":
        steps = _steps(state, found, mode, None)
        if not steps:
            named, found = (), replace(found, left_n=found.without_n)
            verdict, picture = judged(replace(found, accepted=named))
    if verdict == "parameters_changed":
        found = replace(found, accepted=named or as_if_by(found.rounds[0]))
        steps = _steps(state, found, mode, again)
    # Without a candidate only a large growth is news: errors on good recordings of one damper differ by up to two.
    share = float(max(state.rmse_fit_n, state.rmse_unseen_n) / force / np.sqrt(limits().growth))
    is_old = share < limits().usual and not has_grown(state.model, share)
    if verdict == "unexplained" and not state.is_identified_here and is_old:
        verdict, picture, found = "nothing_missing", None, replace(found, is_survey=True)
    report("done", 1.0)
    return _diagnosis(state, found, again, verdict, picture, steps, before, given)


def begun(model: DamperModel, fit: Sequence[Measurement], unseen: Sequence[Measurement]) -> ModelState:
    """The model as given on its recordings; without ``unseen`` 40 % of each is kept back.

    Raises:
        InputError: where a recording cannot be judged with this model.
    """
    for measurement in (*fit, *unseen):
        usable(model, measurement)
    if not unseen:
        fit, unseen = all_divided(fit)
    return state_of(model, fit, unseen)


def first_search(
    state: ModelState,
    mode: str,
    skip: Collection[str] = (),
    workers: int = 1,
    progress: Callable[[str, float], None] = lambda text, share: None,
) -> tuple[Search, DiagnosisData]:
    """What was found before it is added to the model, and on which recordings: without the error that the model had
    when it was identified, if that accounts for part of the error and leaves more than it did then; otherwise as
    measured. A usual error that the model has always had is surveyed only.
    """
    data = data_of(state.model, state.fit_part, state.unseen_part)
    known = misfit_of(state.model.fit)
    parts = ([without_misfit(state.model, m) for m in group] for group in (state.fit_part, state.unseen_part))
    news = data if known is None else data_of(state.model, *parts)
    force = dynamic_force(data)
    whole, left = (
        unweighted(source.unseen, force_rows(state.model, source.unseen) - targets(source.unseen))
        for source in (data, news)
    )
    leaves_news = known is None or known.leaves_news(left / force)
    error = max(whole, state.rmse_fit_n, state.rmse_unseen_n) / force  # the last two with the gauge's zero
    asks_for_change = mode == "both" and not state.is_identified_here
    if asks_for_change:
        change = probability_of_change(state.model, error)
        data, news = replace(data, change=change), replace(news, change=change)
    grown = has_grown(state.model, error)
    # An error that has grown is usual as long as the known error accounts for it; one that has not, if it is not large.
    bound = limits().usual if not grown else 0.0 if leaves_news else limits().acceptable
    is_usual = asks_for_change and error < bound
    is_accounted_for = known is not None and left**2 < limits().accounted * whole**2
    if is_accounted_for and left > limits().least_force * force and leaves_news:
        found = search(
            state.model, news, mode, skip, workers, lambda text, share: progress(text, 0.5 * share), trusted=True
        )
        # On the recordings of the identification a zero is no news, and the old error is what the model lacks.
        zeros = {hypothesis.name for hypothesis in found.rounds[0].hidden if state.is_identified_here}
        if {one.element.effect.name for one in found.accepted} - zeros:
            return found, news
    if is_usual:
        return surveyed(state.model, data, skip, workers, progress), data
    here = state.is_identified_here
    return search(state.model, data, mode, skip, workers, progress, is_identified_here=here), data


def _steps(
    state: ModelState, found: Search, mode: str, again: Reidentified | None
) -> list[tuple[Accepted, ModelState, float, float]]:
    """The findings that lower the error, faults of the measurement chain first: each with the model after it, and the
    unseen error without and with it, N.
    """
    steps: list[tuple[Accepted, ModelState, float, float]] = []
    current = state
    order = sorted(together(found.accepted), key=lambda group: all(one.element.effect.correct is None for one in group))
    for group in order:
        promised = sum(max(one.before_n**2 - one.after_n**2, 0.0) for one in group)
        taken = _applied_together(current, group, mode, promised, names_changes=again is not None)
        before, after = current, taken[-1][1]
        if after.delivers(promised, before):
            steps += _with_errors(before, taken)
            current = after
        elif again is not None:  # it names how the parameters changed, with the errors of the evaluation
            steps += [(one, at, one.before_n, one.after_n) for one, at in taken]
    return steps


def _with_errors(
    before: ModelState, taken: Sequence[tuple[Accepted, ModelState]]
) -> list[tuple[Accepted, ModelState, float, float]]:
    """The findings of a group with the errors without and with each; both with those before and after the two, if the
    first does little without the second.
    """
    between, after = taken[0][1], taken[-1][1]
    if len(taken) == 2 and between.fall_from(before) < limits().gain * after.fall_from(before):
        return [(replace(one, needs=True), at, before.rmse_unseen_n, after.rmse_unseen_n) for one, at in taken]
    earlier = [before, *(at for _, at in taken)]
    return [
        (replace(one, needs=False), at, last.rmse_unseen_n, at.rmse_unseen_n)
        for last, (one, at) in zip(earlier, taken, strict=False)
    ]


def _applied_together(
    before: ModelState, group: Sequence[Accepted], mode: str, promised: float, names_changes: bool
) -> list[tuple[Accepted, ModelState]]:
    """The findings of a group with the model after each.

    Of a pair only one, if the other does harm, or if the one that explains more does as well as both: identified with
    all parameters, it may explain what it did not explain while they were kept. Both, if they name how parameters
    changed.
    """
    taken, after = [], before
    for one in sorted(group, key=lambda one: one.element.effect.correct is None):
        after = _applied(after, one, mode, promised)
        taken.append((one, after))
    if len(group) == 1 or names_changes:
        return taken
    alone = [taken[0], *((one, _applied(before, one, mode, promised)) for one in group[1:])]
    best = min(alone, key=lambda pair: pair[1].rmse_unseen_n)
    first = max(alone, key=lambda pair: pair[0].before_n ** 2 - pair[0].after_n ** 2)
    harms, suffices = best[1].better_than(after), not after.better_than(first[1])
    if not (harms or suffices):
        return taken
    one, state = first if suffices else best
    return [(replace(one, needs=False), state)]


def _applied(before: ModelState, one: Accepted, mode: str, promised: float) -> ModelState:
    """With a finding in its place: from its values next to all other findings, and if that keeps too little of the
    promise, from those that it had alone.
    """
    after = applied(before, one.element, mode, promised, one.hypothesis.joint)
    if after.fulfils(promised, before):
        return after
    alone = applied(before, one.hypothesis.fitted_element, mode, promised)
    return min(after, alone, key=lambda state: state.rmse_unseen_n)


def _diagnosis(
    state: ModelState,
    found: Search,
    again: Reidentified | None,
    verdict: str,
    picture: Structure | None,
    steps: Sequence[tuple[Accepted, ModelState, float, float]],
    before: Comparison,
    given: ModelState,
) -> Diagnosis:
    floor = before.noise_floor_n
    order = [one.element.effect.name for one in found.accepted]
    taken = [
        (order.index(one.element.effect.name), finding_of(one, floor, again, old, new), one.element, at)
        for one, at, old, new in steps
    ]
    ordered = sorted(taken, key=lambda group: group[0])
    findings = tuple(finding for _, finding, _, _ in ordered)
    last = steps[-1][1] if steps else state
    then = recorded(state.model, "residual_stddev") if found.is_survey else None
    errors, atlas = (state.rmse_unseen_n, last.rmse_unseen_n), atlas_of(found.rounds[0])
    reference = reference_error(state.fit_part, state.unseen)
    return Diagnosis(
        model=before.model,
        verdict=verdict,
        sentence=identified_sentence(given, state)
        + (
            unexplained_sentence(atlas, picture, errors[0], found.left_n, floor, reference)
            if verdict == "unexplained"
            else sentence_of(verdict, findings, again, errors, found.left_n, floor, then)
        ),
        mode=found.mode,
        rmse_n=before.measures.rmse_n,
        force_rms_n=before.measures.force_rms_n,
        noise_floor_n=floor,
        findings=findings,
        elements=tuple(element for _, _, element, _ in ordered),
        ranking=ranking_of(found, {finding.effect for finding in findings}),
        untestable=found.untestable,
        moved=again.moved if again is not None and verdict == "parameters_changed" else (),
        rmse_refit_alone_n=again.rmse_n if again is not None else float("nan"),
        structure=picture,
        improved=last.model,
        signals=last.fit[0].signals,
        data=tuple(data_findings(before.model, [*state.fit, *state.unseen])),
        fit=state.fit,
        unseen=state.unseen,
        steps=tuple((finding, at) for _, finding, _, at in taken),
        atlas=atlas,
        phenomena=phenomena_of(found.rounds[0]),
        identified=state if state is not given else None,
        reference_n=reference,
        stretches=stretches_used("fit", state.fit, state.fit_part)
        + stretches_used("unseen", state.unseen, state.unseen_part),
        curves=atlas_curves(found.rounds[0].baseline),
    )
