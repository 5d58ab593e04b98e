"""Explains a search in words and numbers: findings, reasons, ranking."""

from collections.abc import Sequence

import numpy as np

from damper_estimator.diagnosis.accepted import Accepted, positions
from damper_estimator.diagnosis.evaluation import HIGH, LOW, Errors, rmse
from damper_estimator.diagnosis.evidence import confirming, evidence
from damper_estimator.diagnosis.hypotheses import Hypothesis, within
from damper_estimator.diagnosis.ranking import Round
from damper_estimator.diagnosis.reidentify import Reidentified
from damper_estimator.diagnosis.result import (
    AtlasRow,
    EvaluationSummary,
    Finding,
    PhenomenonShare,
    RankedEffect,
)
from damper_estimator.diagnosis.search import Search
from damper_estimator.diagnosis.trial_fit import TrialFit, is_at_end
from damper_estimator.effects.contract import Effect
from damper_estimator.identification import FittedParameter
from damper_estimator.identification.rows import FREE, split
from damper_estimator.model import DamperModel, Element
from damper_estimator.numerics import standard_errors

_SHOWN = 0.05  # gain from which on it is kept what a hypothesis explains


def finding_of(
    one: Accepted, model: DamperModel, floor: float, again: Reidentified | None, before_n: float, after_n: float
) -> Finding:
    """An accepted effect in words and numbers.

    Args:
        model: after the effect was added, or its correction made.
        floor, before_n, after_n: noise floor, and the unseen errors without and with it, N.
    """
    values = delivered(one, model)
    effect = one.element.effect
    current = one.round
    gain, low, high = one.gain
    floor_square = floor**2 if np.isfinite(floor) else 0.0
    explainable = max(before_n**2 - floor_square, 1e-12)
    without = current.without
    with_it = current.left(one.hypothesis)
    return Finding(
        effect=effect.name,
        phenomenon=effect.phenomenon,
        tied_with=one.tied,
        rmse_before_n=before_n,
        rmse_after_n=after_n,
        share_of_explainable_error=float(np.clip((before_n**2 - after_n**2) / explainable, 0.0, 1.0)),
        confidence=one.confidence,
        gain=gain,
        low=low,
        high=high,
        evidence=evidence(current.baseline, effect, without, with_it, current.tests, one.hypothesis.because),
        test_to_separate=confirming(effect, one.tied),
        remark=_remark(one, values, again),
        parameters=values,
        is_channel=effect.kind == "channel",
        partner=one.partner if one.needs else "",
    )


def _remark(one: Accepted, values: Sequence[FittedParameter], again: Reidentified | None) -> str:
    """What makes the finding suspect: parameters at a limit, where kept and refitted parameters disagree, a drift that
    the gauge may have as well, and a mean that gas may make whose temperature is unknown.
    """
    disagrees = _acting_against(one) or _disagreement(one, again)
    reasons = at_a_limit(one.element.effect, values), disagrees, _drifting(one), _of_unknown_temperature(one)
    return " ".join(filter(None, reasons))


def _drifting(one: Accepted) -> str:
    if one.round.baseline.data.zero != FREE or one.element.effect.kind == "channel":
        return ""
    return (
        "Most of the error is a drift of the force over the recording; a gauge whose zero drifts looks the same: "
        "compare its readings without load before and after."
    )


def _of_unknown_temperature(one: Accepted) -> str:
    data = one.round.baseline.data
    if not one.is_mean or data.ranges.temperature is not None or data.usual == 0.0:
        return ""
    warmth = "warmer" if np.mean(one.hypothesis.fit.change_fit) < 0.0 else "colder"
    return (
        f"No temperature was recorded: gas that is {warmth} than when the model was identified makes such a mean as "
        "well; read the gauge with the damper unhooked."
    )


def _acting_against(one: Accepted) -> str:
    if not one.needs:
        return ""
    return f"It acts against {one.partner.replace('_', ' ')}: each explains little alone, the errors are those of both."


def at_a_limit(effect: Effect, values: Sequence[FittedParameter]) -> str:
    """What a reader has to know of parameters that stopped at a limit; "" if none did."""
    rigid = [value for value in values if value.at_bound and _is_rigid(effect, value)]
    bounded = [value for value in values if value.at_bound and not _is_rigid(effect, value)]
    sentences = []
    if bounded:
        verb = "lie at limits" if len(bounded) > 1 else "lies at a limit"
        sentences.append(
            f"{_names(bounded)} {verb} of what is physical: the effect's form is not quite that of this damper."
        )
    if rigid:
        sentences.append(f"{_names(rigid)}: so stiff that nothing is seen to deflect.")
    return " ".join(sentences)


def _is_rigid(effect: Effect, value: FittedParameter) -> bool:
    """Whether a stiffness of what lies in series is as large as it can be: no sign of a wrong form."""
    upper = effect.parameter(value.name.rpartition(".")[2].partition("[")[0]).upper
    return effect.kind == "series" and value.unit == "N/m" and value.value > 0.5 * upper


def _names(values: Sequence[FittedParameter]) -> str:
    return ", ".join(value.name.rpartition(".")[2].replace("_", " ") for value in values)


def _disagreement(one: Accepted, again: Reidentified | None) -> str:
    if one.round.mode != "both":
        return ""
    if again is not None and again.enough:
        return (
            "Re-identifying the parameters that are there explains most of the error as well "
            f"(unseen error {again.rmse_n:.3g} N without the effect)."
        )
    left = one.hypothesis.evaluation.refitted.square / max(one.round.refitted.square, 1e-300)
    if 1.0 - left < 0.5 * one.gain[0]:
        return (
            f"With the model's parameters kept it explains {100.0 * one.gain[0]:.0f} % of the squared error, refitted "
            f"with them only {100.0 * max(1.0 - left, 0.0):.0f} %: they can take over part of it."
        )
    return ""


def delivered(one: Accepted, model: DamperModel) -> tuple[FittedParameter, ...]:
    """The effect's values as they are in the model that it was added to, with the standard errors of that
    identification; a correction of the signal map has those of the search.
    """
    effect, region = one.element.effect, one.hypothesis.region
    if effect.correct is not None:
        return parameters_of(one.element, one.hypothesis.fit, one.round)
    errors, limited = model.standard_errors, within(model, {effect.name: region})
    rows = []
    for i in positions(model, [effect.name]):
        slot, bounds = model.slots[i], limited[i].parameter
        name = f"{effect.name}.{slot.address.rpartition('.')[2]}"
        stopped = is_at_end(slot.value, bounds.lower, bounds.upper)
        error = float("nan") if stopped else errors.get(slot.address, float("nan"))
        rows.append(FittedParameter(name, slot.value, error, slot.parameter.unit, stopped))
    return tuple(rows)


def parameters_of(element: Element, fit: TrialFit, current: Round) -> tuple[FittedParameter, ...]:
    """The effect's values; their standard errors are those with all other parameters kept."""
    effect = element.effect
    flat = [
        (name if np.ndim(value) == 0 else f"{name}[{k}]", float(number), effect.parameter(name))
        for name, value in element.parameters.items()
        for k, number in enumerate(np.atleast_1d(value))
    ]
    errors = _standard_errors(fit, current)
    bounded = {address.rpartition(".")[2] for address in fit.at_bound}
    return tuple(
        FittedParameter(
            f"{effect.name}.{name}", value, float("nan") if name in bounded else error, declared.unit, name in bounded
        )
        for (name, value, declared), error in zip(flat, errors, strict=True)
    )


def _standard_errors(fit: TrialFit, current: Round) -> np.ndarray:
    """(k,); NaN where nothing is known of the derivatives, or the data do not determine a parameter."""
    columns = fit.derivatives_fit
    if not columns.shape[1] or not np.isfinite(columns).all():
        return np.full(fit.sizes.size, np.nan)
    rows = current.baseline.data.fit
    residual = current.baseline.residual_fit + fit.change_fit
    rates = [part.rate for part in rows]
    return standard_errors(split(rows, columns), split(rows, residual), rates) * fit.sizes


def atlas_of(current: Round) -> tuple[AtlasRow, ...]:
    """What the form-free tests of one round say, the one that explains most first."""
    rows = []
    for test in current.tests:
        low, high = np.percentile(test.gains, [LOW, HIGH])
        tried = (*current.hypotheses, *current.hidden)
        known = {hypothesis.phenomenon for hypothesis in tried if test.test.name in hypothesis.effect.tests}
        name, shows, phenomena = test.test.name, test.test.shows, tuple(sorted(known))
        rows.append(AtlasRow(name, phenomena, shows, 1.0 - test.remaining.unseen, float(low), float(high)))
    return tuple(sorted(rows, key=lambda row: -row.explains))


def phenomena_of(current: Round) -> tuple[PhenomenonShare, ...]:
    """All phenomena that one round tried, the most probable first."""
    shares = [
        PhenomenonShare(score.phenomenon, score.left, current.probabilities[score.phenomenon])
        for score in current.scores
    ]
    return tuple(sorted(shares, key=lambda share: -share.probability))


_UNDELIVERED = "identified in the model, it does not lower the unseen error by what it explains alone"


def ranking_of(found: Search, accepted: set[str]) -> tuple[RankedEffect, ...]:
    """The first round's hypotheses: those that the search found, the best, the others; ``accepted`` names those that
    lower the error.
    """
    first = found.first
    best = first.best
    otherwise = found.set_aside or "another explains more"
    by_name = {one.element.effect.name: one for one in reversed(found.accepted)}
    order = sorted(first.hypotheses, key=lambda one: (one.name not in by_name, one is not best))
    rows = [
        _ranked(first, hypothesis, accepted, _UNDELIVERED if hypothesis.name in by_name else otherwise)
        for hypothesis in order
    ]
    hidden = [_hidden(hypothesis, by_name.get(hypothesis.name), accepted) for hypothesis in first.hidden]
    return tuple(rows + hidden)


def _ranked(current: Round, hypothesis: Hypothesis, accepted: set[str], otherwise: str) -> RankedEffect:
    name, evaluation, force_rms = hypothesis.name, hypothesis.evaluation, current.baseline.data.force_rms
    reason = "" if name in accepted else current.reason_against(hypothesis, force_rms) or otherwise
    kept = summary_of(current, evaluation.kept, evaluation.kept_gains, current.kept)
    refitted = summary_of(current, evaluation.refitted, evaluation.refitted_gains, current.refitted)
    return RankedEffect(
        effect=name,
        phenomenon=hypothesis.phenomenon,
        kept=None if current.refits else kept,
        refitted=None if current.mode == "kept" else refitted,
        parameters=parameters_of(hypothesis.fitted_element, hypothesis.fit, current),
        reason=reason,
        explains=_explains(current, hypothesis) if current.gain(hypothesis)[0] >= _SHOWN else (),
    )


def _hidden(hypothesis: Hypothesis, one: Accepted | None, accepted: set[str]) -> RankedEffect:
    if one is None or hypothesis.name not in accepted:
        reason = "changes nothing that is compared" if one is None else _UNDELIVERED
        return RankedEffect(hypothesis.name, hypothesis.phenomenon, None, None, (), reason)
    evaluation = one.hypothesis.evaluation
    return RankedEffect(
        effect=hypothesis.name,
        phenomenon=hypothesis.phenomenon,
        kept=summary_of(one.round, evaluation.kept, evaluation.kept_gains, one.round.kept),
        refitted=None,
        parameters=parameters_of(one.element, one.hypothesis.fit, one.round),
        reason="",
    )


def summary_of(current: Round, left: Errors, replicates: np.ndarray, without: Errors) -> EvaluationSummary:
    """One evaluation in numbers."""
    low, high = (float(end) for end in np.percentile(replicates, [LOW, HIGH]))
    return EvaluationSummary(rmse(current.baseline, left), 1.0 - left.square / max(without.square, 1e-300), low, high)


def _explains(current: Round, hypothesis: Hypothesis) -> tuple[np.ndarray, ...]:
    """(n,) N in band per unseen recording: what the effect changes of the force."""
    model = current.baseline.model
    changed = hypothesis.fitted_into(model)
    parts = []
    for rows in current.baseline.data.unseen:
        block = rows.measurement.kinematics.block
        parts.append(rows.measurement.in_band(np.nan_to_num(changed.force(block) - model.force(block))))
    return tuple(parts)
