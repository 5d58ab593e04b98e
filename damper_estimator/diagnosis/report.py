"""Turns rounds of attempts into findings, reasons and sentences."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from damper_estimator.diagnosis.attempt import Attempt
from damper_estimator.diagnosis.evidence import confirming, evidence
from damper_estimator.diagnosis.judge import HIGH, LOW, Errors, Tally, rmse
from damper_estimator.diagnosis.ranking import Round
from damper_estimator.diagnosis.reidentify import Reidentified
from damper_estimator.diagnosis.result import Finding, Judged, Judgement, Structure
from damper_estimator.diagnosis.search import Accepted, Search
from damper_estimator.identification import FittedParameter
from damper_estimator.identification.rows import split
from damper_estimator.model import Element
from damper_estimator.numerics import standard_errors

_SHOWN = 0.05  # gain from which on it is kept what a candidate explains


def finding_of(one: Accepted, floor: float, again: Reidentified | None) -> Finding:
    """An accepted effect in words and numbers."""
    effect = one.element.effect
    own = one.round
    gain, low, high = one.gain
    floor_square = floor**2 if np.isfinite(floor) else 0.0
    explainable = max(one.before_n**2 - floor_square, 1e-12)
    without = own.without
    with_it = own.left(one.tally)
    return Finding(
        effect=effect.name,
        phenomenon=effect.phenomenon,
        tied_with=one.tied,
        rmse_before_n=one.before_n,
        rmse_after_n=one.after_n,
        share_of_explainable_error=float(np.clip((one.before_n**2 - one.after_n**2) / explainable, 0.0, 1.0)),
        confidence=one.confidence,
        gain=gain,
        low=low,
        high=high,
        evidence=evidence(own.null, effect, without, with_it),
        test_to_separate=confirming(effect, one.tied),
        remark=_remark(one, again),
        parameters=parameters_of(one.element, one.tally.attempt, own),
        is_channel=effect.kind == "channel",
    )


def _remark(one: Accepted, again: Reidentified | None) -> str:
    """Where kept and refitted parameters disagree."""
    if one.round.mode != "both":
        return ""
    if again is not None and again.enough:
        return (
            "Re-identifying the parameters that are there explains it as well "
            f"(unseen error {again.rmse_n:.3g} N without the effect)."
        )
    left = one.tally.refitted.square / max(one.round.refitted.square, 1e-300)
    if 1.0 - left < 0.5 * one.gain[0]:
        return (
            f"With the model's parameters kept it explains {100.0 * one.gain[0]:.0f} % of the squared error, refitted "
            f"with them only {100.0 * max(1.0 - left, 0.0):.0f} %: they can take over part of it."
        )
    return ""


def parameters_of(element: Element, attempt: Attempt, own: Round) -> tuple[FittedParameter, ...]:
    """The effect's values; their standard errors are those with all other parameters kept."""
    effect = element.effect
    flat = [
        (name if np.ndim(value) == 0 else f"{name}[{k}]", float(number), effect.parameter(name))
        for name, value in element.parameters.items()
        for k, number in enumerate(np.atleast_1d(value))
    ]
    errors = _standard_errors(attempt, own)
    bounded = {address.rpartition(".")[2] for address in attempt.at_bound}
    return tuple(
        FittedParameter(
            f"{effect.name}.{name}", value, float("nan") if name in bounded else error, declared.unit, name in bounded
        )
        for (name, value, declared), error in zip(flat, errors, strict=True)
    )


def _standard_errors(attempt: Attempt, own: Round) -> np.ndarray:
    """(k,); NaN where nothing is known of the derivatives, or the data do not determine a parameter."""
    columns = attempt.own_fit
    if not columns.shape[1] or not np.isfinite(columns).all():
        return np.full(attempt.sizes.size, np.nan)
    rows = own.null.scene.fit
    residual = own.null.residual_fit + attempt.change_fit
    rates = [part.rate for part in rows]
    return standard_errors(split(rows, columns), split(rows, residual), rates) * attempt.sizes


def judged_of(found: Search, force_rms: float) -> tuple[Judged, ...]:
    """The first round's candidates, best first."""
    own = found.rounds[0]
    accepted = {one.element.effect.name for one in found.accepted}
    best = own.best
    order = sorted(own.tallies, key=lambda tally: tally is not best)
    rows = [_judged(own, tally, force_rms, accepted) for tally in order]
    hidden = [
        _hidden(own, name, next((one for one in found.accepted if one.element.effect.name == name), None))
        for name in own.hidden
    ]
    return tuple(rows + hidden)


def _judged(own: Round, tally: Tally, force_rms: float, accepted: set[str]) -> Judged:
    name = tally.attempt.effect
    effect = own.candidates[name].effect
    reason = "" if name in accepted else own.reason_against(tally, force_rms) or "another explains more"
    explains = ()
    if own.gain(tally)[0] >= _SHOWN:
        explains = _explains(own, tally)
    return Judged(
        effect=name,
        phenomenon=effect.phenomenon,
        kept=None if own.refits else judgement(own, tally.kept, tally.kept_gains, own.kept),
        refitted=None if own.mode == "kept" else judgement(own, tally.refitted, tally.refitted_gains, own.refitted),
        parameters=parameters_of(tally.attempt.element(own.candidates[name]), tally.attempt, own),
        reason=reason,
        explains=explains,
    )


def _hidden(own: Round, name: str, one: Accepted | None) -> Judged:
    effect = own.candidates[name].effect
    reason = "" if one else "changes nothing that is compared"
    parameters = parameters_of(one.element, one.tally.attempt, one.round) if one else ()
    kept = judgement(one.round, one.tally.kept, one.tally.kept_gains, one.round.kept) if one else None
    return Judged(name, effect.phenomenon, kept, None, parameters, reason)


def judgement(own: Round, left: Errors, replicates: np.ndarray, without: Errors) -> Judgement:
    """One way of judging in numbers."""
    low, high = np.percentile(replicates, [LOW, HIGH])
    return Judgement(rmse(own.null, left), 1.0 - left.square / max(without.square, 1e-300), float(low), float(high))


def _explains(own: Round, tally: Tally) -> tuple[np.ndarray, ...]:
    """(n,) N in band per unseen recording: what the effect changes of the force."""
    candidate = own.candidates[tally.attempt.effect]
    changed, _ = replace(candidate, element=tally.attempt.element(candidate)).added_to(own.null.model)
    parts = []
    for rows in own.null.scene.unseen:
        block = rows.measurement.kinematics.block
        parts.append(rows.measurement.in_band(np.nan_to_num(changed.force(block) - own.null.model.force(block))))
    return tuple(parts)


def sentence_of(
    verdict: str,
    findings: Sequence[Finding],
    again: Reidentified | None,
    picture: Structure | None,
    rmse_n: float,
    left_n: float,
    floor_n: float,
) -> str:
    """The verdict in one sentence.

    Args:
        left_n: what is left without the gauge's zero and drift in each recording.
    """
    if verdict == "missing":
        names = " and ".join(_named(finding) for finding in findings)
        last = findings[-1]
        fall = f"from {findings[0].rmse_before_n:.3g} to {last.rmse_after_n:.3g} N"
        return f"Missing: {names}; with it the unseen error falls {fall}."
    if verdict == "parameters_changed":
        moved = ", ".join(m.name for m in again.moved[:4]) or "its parameters"
        like = f", as if by {_named(findings[0])}" if findings else ""
        return (
            f"Nothing is missing, but parameters changed ({moved}{like}): re-identifying them takes the unseen error "
            f"to {again.rmse_n:.3g} N."
        )
    if verdict == "unexplained" and picture is None:
        return (
            f"No known effect accounts for the error of {rmse_n:.3g} N, {rmse_n / floor_n:.2g} times the noise, and it "
            "follows nothing that was measured at the same instant: what happened before, or was not measured, counts."
        )
    if verdict == "unexplained":
        return f"The error of {rmse_n:.3g} N has a structure that no known effect accounts for: {picture.words}."
    own = f" ({left_n:.3g} N without each recording's zero and drift)" if left_n < 0.9 * rmse_n else ""
    return f"Nothing is missing that these data could show: {rmse_n:.3g} N are left{own}, noise makes {floor_n:.3g} N."


def _named(finding: Finding) -> str:
    name = finding.phenomenon.replace("_", " ")
    tied = [phenomenon.replace("_", " ") for phenomenon in finding.tied_with]
    return name + (f" (or {', '.join(tied)}: tied)" if tied else "")
