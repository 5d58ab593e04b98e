"""Errors as shares of the force, on both parts of the data."""

from damper_estimator.diagnosis.apply_finding import ModelState
from damper_estimator.diagnosis.diagnosis_data import DiagnosisData, dynamic_force, error_of
from damper_estimator.diagnosis.misfit import motion_factor
from damper_estimator.model import DamperModel


def share_of_force(state: ModelState, data: DiagnosisData, factors: tuple[float, float] = (1.0, 1.0)) -> float:
    """The error with the gauge's zero, as a share of the force of its part: the larger of both parts, that to fit to
    and the unseen one, each over its factor.
    """
    parts = (state.rmse_fit_n, data.fit), (state.rmse_unseen_n, data.unseen)
    return max(error / dynamic_force(rows) / factor for (error, rows), factor in zip(parts, factors, strict=True))


def rest_of_force(model: DamperModel, data: DiagnosisData, factors: tuple[float, float] = (1.0, 1.0)) -> float:
    """The same of the error without the gauge's zero."""
    parts = zip((data.fit, data.unseen), factors, strict=True)
    return max(error_of(model, rows) / dynamic_force(rows) / factor for rows, factor in parts)


def motion_factors(model: DamperModel, data: DiagnosisData) -> tuple[float, float]:
    """Of both parts, by how much larger a share of the force is usual there than at the identification."""
    return motion_factor(model, data.fit), motion_factor(model, data.unseen)
