"""Names the physical effects that a model lacks, as far as the recordings show it.

Hypotheses are fitted with the model's parameters kept and evaluated on unseen data; the best one is added, and the next
round explains what is left. In addition the model is re-identified without new effects, to distinguish changed
parameters from a missing effect.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

import numpy as np

from damper_estimator.diagnosis.apply_finding import ModelState, identified_first, state_of
from damper_estimator.diagnosis.atlas_curves import atlas_curves
from damper_estimator.diagnosis.beyond_region import extrapolation
from damper_estimator.diagnosis.division import all_divided
from damper_estimator.diagnosis.error_shares import share_of_force
from damper_estimator.diagnosis.evaluation import rmse
from damper_estimator.diagnosis.explanation import (
    atlas_of,
    finding_of,
    phenomena_of,
    ranking_of,
)
from damper_estimator.diagnosis.free_curve import FreeCurve, with_free_curve
from damper_estimator.diagnosis.informative import stretches_used
from damper_estimator.diagnosis.misfit import usual_error
from damper_estimator.diagnosis.moving_zero import by_itself, steadied
from damper_estimator.diagnosis.outcome import Outcome, outcome_of
from damper_estimator.diagnosis.result import Diagnosis, Finding
from damper_estimator.diagnosis.search import NOT_IDENTIFIED_THERE
from damper_estimator.diagnosis.sentences import identified_sentence, sentence_of, unexplained_sentence
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.identification import check_motion, usable
from damper_estimator.model import DamperModel, Element
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
    identified = identified_first(given, mode)
    state, moved = steadied(identified)
    before = compare(state.model, *state.unseen)
    beyond = extrapolation(state)
    outcome = outcome_of(state, beyond, before.noise_floor_n, mode, skip, workers, report)
    report("done", 1.0)
    said = identified_sentence(given, identified) + (moved[0].sentence if moved else "")
    found = _diagnosis(
        state,
        outcome,
        before,
        said + (beyond.sentence if beyond is not None else ""),
        by_itself(identified, state, moved, outcome.found.first.hidden),
    )
    curve = _free_curve(state, found)
    return replace(
        found,
        sentence=found.sentence + (curve.sentence if curve is not None else ""),
        identified=identified if identified is not given else None,
        free_curve=curve,
    )


def _free_curve(state: ModelState, found: Diagnosis) -> FreeCurve | None:
    """A free curve that leaves less than all findings, where these leave much. Only on recordings that the model was
    identified on: on others, an error over velocity says what has changed.
    """
    explains = next((row.explains for row in found.atlas if row.test == "curve"), 0.0)
    if found.mode == "kept" or not state.is_identified_here or explains < limits().gain:
        return None
    left_n = found.steps[-1][1].rmse_unseen_n if found.steps else state.rmse_unseen_n
    # A curve can follow the step of a friction as well, but where a name explains nearly all, it is the better answer.
    if left_n < limits().notable * found.force_rms_n:
        return None
    curve = with_free_curve(state)
    return curve if curve is not None and curve.state.rmse_unseen_n < left_n else None


def begun(model: DamperModel, fit: Sequence[Measurement], unseen: Sequence[Measurement]) -> ModelState:
    """The model as given on its recordings; without ``unseen`` 40 % of each is kept back.

    Raises:
        InputError: where a recording cannot be judged with this model.
    """
    check_motion(fit)
    for measurement in (*fit, *unseen):
        usable(model, measurement)
    if not unseen:
        fit, unseen = all_divided(fit)
    return state_of(model, fit, unseen)


def _diagnosis(
    state: ModelState, outcome: Outcome, before: Comparison, said: str, movement: tuple[Finding, Element] | None
) -> Diagnosis:
    found, again, verdict, steps = outcome.found, outcome.again, outcome.verdict, outcome.steps
    picture, floor = outcome.picture, before.noise_floor_n
    order = [one.element.effect.name for one in found.accepted]
    taken = [
        (order.index(one.element.effect.name), finding_of(one, at.model, floor, again, old, new), one.element, at)
        for one, at, old, new in steps
    ]
    ordered = sorted(taken, key=lambda group: group[0])
    named = [(finding, element) for _, finding, element, _ in ordered]
    last = steps[-1][1] if steps else state
    baseline = found.first.baseline
    kept_n = rmse(baseline, found.first.kept)
    is_beyond = found.set_aside == NOT_IDENTIFIED_THERE
    is_usual = bool(found.set_aside) and not is_beyond
    share = share_of_force(state, baseline.data)
    usual = usual_error(state.model, share, baseline.data.unseen) if is_usual else None
    errors, atlas = (state.rmse_unseen_n, last.rmse_unseen_n), atlas_of(found.first)
    if movement is not None and all(finding.effect != movement[0].effect for finding, _ in named):
        is_largest = all(finding.fall < movement[0].fall for finding, _ in named)
        named = [movement, *named] if is_largest else [*named, movement]
        errors = errors[0], float(np.sqrt(max(errors[1] ** 2 - movement[0].fall, floor**2)))
        verdict = verdict if verdict == "parameters_changed" else "missing"
    findings = tuple(finding for finding, _ in named)
    reference = reference_error(state.fit_part, state.unseen)
    return Diagnosis(
        model=before.model,
        verdict=verdict,
        sentence=said
        + (
            unexplained_sentence(atlas, picture, errors[0], kept_n, floor, reference)
            if verdict == "unexplained"
            else sentence_of(verdict, findings, again, errors, kept_n, floor, usual, is_beyond=is_beyond)
        ),
        mode=found.mode,
        rmse_n=before.measures.rmse_n,
        force_rms_n=before.measures.force_rms_n,
        noise_floor_n=floor,
        findings=findings,
        elements=tuple(element for _, element in named),
        ranking=ranking_of(found, {finding.effect for finding in findings}) + outcome.undelivered,
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
        phenomena=phenomena_of(found.first),
        reference_n=reference,
        stretches=stretches_used("fit", state.fit, state.fit_part)
        + stretches_used("unseen", state.unseen, state.unseen_part),
        curves=atlas_curves(baseline),
    )
