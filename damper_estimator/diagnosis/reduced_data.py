"""The recordings of a state as rows: as measured, and without what is known of the model."""

from collections.abc import Callable

from damper_estimator.diagnosis.apply_finding import ModelState
from damper_estimator.diagnosis.diagnosis_data import DiagnosisData, data_of
from damper_estimator.diagnosis.known_error import accounted_for, as_it_is, without_misfit, without_old_zero
from damper_estimator.diagnosis.misfit import misfit_of
from damper_estimator.model import DamperModel
from damper_estimator.signals import Measurement

Reduction = Callable[[DamperModel, Measurement], Measurement]


def recorded_data(state: ModelState, reduced: Reduction = as_it_is) -> DiagnosisData:
    """The recordings as measured, or reduced by something that is known of the model."""
    return data_of(
        state.model, *([reduced(state.model, m) for m in group] for group in (state.fit_part, state.unseen_part))
    )


def with_and_without_known(state: ModelState, asks_for_change: bool) -> tuple[DiagnosisData, DiagnosisData, bool]:
    """The recordings as measured, and without the error that the model has always had; and whether that accounts for
    part of the error. Of several unseen recordings it is left in those in which it does not: on a motion unlike that of
    the identification it may predict nothing.
    """
    reduced = without_old_zero if asks_for_change else as_it_is
    data = recorded_data(state, reduced)
    if misfit_of(state.model.fit) is None:
        return data, data, False
    beyond_known = recorded_data(state, without_misfit)
    accounted, others = accounted_for(state.model, data.unseen, beyond_known.unseen)
    if not accounted or not others:
        return data, beyond_known, bool(accounted)

    def reduced_where_accounted(model: DamperModel, measurement: Measurement) -> Measurement:
        return (reduced if measurement.recording in others else without_misfit)(model, measurement)

    return data, recorded_data(state, reduced_where_accounted), True
