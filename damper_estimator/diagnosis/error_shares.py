"""Errors as shares of the force, and how probable it is that they are new."""

from dataclasses import dataclass, replace

from damper_estimator.diagnosis.apply_finding import ModelState
from damper_estimator.diagnosis.diagnosis_data import DiagnosisData, dynamic_force, error_of
from damper_estimator.diagnosis.misfit import error_then, misfit_of, motion_factor, probability_of_change, usual_share
from damper_estimator.model import DamperModel


def share_of_force(state: ModelState, data: DiagnosisData, factors: tuple[float, float] = (1.0, 1.0)) -> float:
    """The error with the gauge's zero, as a share of the force of its part: the larger of both parts, that to fit to
    and the unseen one, each over its factor.
    """
    parts = (state.rmse_fit_n, data.fit), (state.rmse_unseen_n, data.unseen)
    return max(error / dynamic_force(rows) / factor for (error, rows), factor in zip(parts, factors, strict=True))


def motion_factors(model: DamperModel, data: DiagnosisData) -> tuple[float, float]:
    """Of both parts, by how much larger a share of the force is usual there than at the identification."""
    return motion_factor(model, data.fit), motion_factor(model, data.unseen)


@dataclass(frozen=True)
class ErrorShares:
    """Errors of a model as shares of the force. Those that are named ``then`` are as they would be on the motion of the
    identification.

    Attributes:
        unseen, beyond_known: on unseen data without the gauge's zero, as measured and without the known error.
        rest, rest_then: without the zero, the larger of both parts.
        with_zero, with_zero_then: the same with it.
        factor: by how much larger a share is usual on unseen data than at the identification.
    """

    unseen: float
    beyond_known: float
    rest: float
    rest_then: float
    with_zero: float
    with_zero_then: float
    factor: float


def error_shares(state: ModelState, data: DiagnosisData, beyond_known: DiagnosisData) -> ErrorShares:
    """Of a state's model, on the recordings as measured and without the known error."""
    model, factors = state.model, motion_factors(state.model, data)
    rests = [error_of(model, rows) / dynamic_force(rows) for rows in (data.fit, data.unseen)]
    return ErrorShares(
        unseen=rests[1],
        beyond_known=error_of(model, beyond_known.unseen) / dynamic_force(data.unseen),
        rest=max(rests),
        rest_then=max(rest / factor for rest, factor in zip(rests, factors, strict=True)),
        with_zero=max(rests[1], share_of_force(state, data)),
        with_zero_then=max(rests[1] / factors[1], share_of_force(state, data, factors)),
        factor=factors[1],
    )


def with_changes(
    model: DamperModel, shares: ErrorShares, data: DiagnosisData, beyond_known: DiagnosisData
) -> tuple[DiagnosisData, DiagnosisData]:
    """The recordings as measured and without the known error, with how probable it is that the error is new and what
    share of it is usual.
    """
    known, then = misfit_of(model.fit), error_then(model)[1]
    left_then = known.left if known is not None else then
    change, with_zero = (probability_of_change(model, each) for each in (shares.rest_then, shares.with_zero_then))
    measured, reduced = (
        replace(rows, change=change, zero_change=with_zero, usual=usual_share(shares.factor * old, now))
        for rows, old, now in ((data, then, shares.unseen), (beyond_known, left_then, shares.beyond_known))
    )
    return measured, reduced
