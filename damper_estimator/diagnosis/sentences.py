"""The verdict of a diagnosis in one sentence."""

from collections.abc import Sequence

import numpy as np

from damper_estimator.diagnosis.apply_finding import ModelState
from damper_estimator.diagnosis.misfit import UsualError
from damper_estimator.diagnosis.reidentify import Reidentified
from damper_estimator.diagnosis.result import AtlasRow, Finding, Structure
from damper_estimator.diagnosis.thresholds import limits

_MOST_OF_IT = 0.9  # times an error: what is left without the zeros is said as well if it is smaller


def identified_sentence(given: ModelState, state: ModelState) -> str:
    """That the model was identified first, where it was."""
    if state is given:
        return ""
    return (
        "The model had no record of a fit and was identified first "
        f"(unseen error {given.rmse_unseen_n:.3g} to {state.rmse_unseen_n:.3g} N). "
    )


def sentence_of(
    verdict: str,
    findings: Sequence[Finding],
    again: Reidentified | None,
    errors_n: tuple[float, float],
    left_n: float,
    floor_n: float,
    then: UsualError | None = None,
    *,
    is_beyond: bool = False,
) -> str:
    """The verdict in one sentence; see ``unexplained_sentence`` for one of them.

    Args:
        errors_n: unseen error as given, and with all findings, N.
        left_n: what is left without the gauge's zero and drift in each recording.
        then: error when the model was identified, if the error is not new.
        is_beyond: whether most of it lies at velocities that the model was not identified at, which another sentence
            says before.
    """
    rmse_n = errors_n[0]
    if verdict == "missing":
        names = " and ".join(_named(finding) for finding in findings)
        fall = f"from {rmse_n:.3g} to {errors_n[1]:.3g} N"
        return f"Missing: {names}; with it the unseen error falls {fall}."
    if verdict == "parameters_changed":
        moved = ", ".join(m.name for m in again.moved[:4]) or "its parameters"
        like = f", as if by {_named(findings[0])}" if findings else ""
        return (
            f"Nothing is missing, but parameters changed ({moved}{like}): re-identifying them takes the unseen error "
            f"to {again.rmse_n:.3g} N."
        )
    if then is not None:
        above = f" ({rmse_n / floor_n:.2g} times the noise)" if rmse_n > limits().far_above * floor_n else ""
        return (
            f"Nothing is missing that is new: the error of {rmse_n:.3g} N{above}, {100.0 * then.share_now:.2g} % of "
            f"the force, {then.words}. For what the model has always lacked, diagnose the recordings of its "
            "identification."
        )
    if is_beyond:
        return "At the velocities that it was identified at, nothing is missing that these data could show."
    rest = f" ({left_n:.3g} N without each recording's zero and drift)" if left_n < _MOST_OF_IT * rmse_n else ""
    noise = f"; the noise floor is {floor_n:.3g} N" if np.isfinite(floor_n) else ""
    return f"Nothing is missing that these data could show: {rmse_n:.3g} N remain{rest}{noise}."


def unexplained_sentence(
    atlas: Sequence[AtlasRow],
    picture: Structure | None,
    error_n: float,
    left_n: float,
    floor_n: float,
    reference_n: float,
) -> str:
    """What is known of an error that no effect accounts for: how large it is without each recording's zero and drift,
    on what it depends, where it is largest, and how much of it a regression without any form explains.
    """
    zeros = ""
    if left_n < _MOST_OF_IT * error_n:
        zeros = f" that is left of {error_n:.3g} N without each recording's zero and drift"
        error_n = left_n
    first = atlas[0] if atlas else None
    depends = ""
    if first is not None and first.low >= limits().gain:
        names = " or ".join(name.replace("_", " ") for name in first.phenomena)
        like = f", as with {names} of a form that no effect has" if names else ""
        depends = f" {100.0 * first.explains:.0f} % of its square depends on {first.shows}{like}."
    if reference_n < (1.0 - limits().least_fall) * error_n:
        depends += f" A regression without any form reaches {reference_n:.3g} N."
    if picture is not None:
        shape = f"has a structure that no known effect accounts for: {picture.words}"
        return f"The error of {error_n:.3g} N{zeros} {shape}.{depends}"
    times = f", {error_n / floor_n:.2g} times the noise" if floor_n > 0.0 else ""
    known = f"No known effect accounts for the error of {error_n:.3g} N{zeros}{times}"
    if depends:
        return f"{known}.{depends}"
    return (
        f"{known}, and no dependence on what was measured at the same instant accounts for a quarter of it for "
        "certain: what happened before, or was not measured, may count."
    )


def _named(finding: Finding) -> str:
    name = finding.phenomenon.replace("_", " ")
    tied = [phenomenon.replace("_", " ") for phenomenon in finding.tied_with]
    return name + (f" (or {', '.join(tied)}: tied)" if tied else "")
