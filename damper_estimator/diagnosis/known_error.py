"""Recordings without what a model is known to get wrong, so that what is left is new."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from damper_estimator.diagnosis.by_recording import by_recording
from damper_estimator.diagnosis.diagnosis_data import force_rows, targets
from damper_estimator.diagnosis.misfit import ZERO, mean_error, misfit_of
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.identification.fit_record import recorded
from damper_estimator.identification.rows import SAMPLES_PER_BAND, Rows
from damper_estimator.model import DamperModel
from damper_estimator.signals import Measurement
from damper_estimator.signals.butterworth import low_pass_zero_phase

_PASSES = 3.0  # times the band: high enough to leave the band as it is, low enough that nothing folds into it


def as_it_is(model: DamperModel, measurement: Measurement) -> Measurement:
    """The measurement as it was recorded."""
    return measurement


def accounted_for(
    model: DamperModel, measured: Sequence[Rows], reduced: Sequence[Rows]
) -> tuple[frozenset[str], frozenset[str]]:
    """Names of the recordings in which what the model is known to get wrong accounts for part of the error, and of the
    others.

    Args:
        measured, reduced: rows of the recordings as measured, and without that error.
    """
    apart, names = by_recording(measured), list(dict.fromkeys(part.measurement.recording for part in measured))
    whole, left = (apart.squares(force_rows(model, rows) - targets(rows)) for rows in (measured, reduced))
    is_part = left < limits().accounted * whole
    accounted = frozenset(name for name, yes in zip(names, is_part, strict=True) if yes)
    return accounted, frozenset(names) - accounted


def without_misfit(model: DamperModel, measurement: Measurement) -> Measurement:
    """The measurement less what the model is known to get wrong, if that is finite: what is left to explain is new.

    Far above the comparison's band, in which it was found, the prediction is mostly noise, of rates of the force and of
    accelerations. It would fold into the band where the recording is thinned.
    """
    known = misfit_of(model.fit)
    if known is None or measurement.force is None:
        return measurement
    k, band, predicted = measurement.kinematics, measurement.band, known.force(model, measurement)
    if 0.0 < SAMPLES_PER_BAND * band < k.rate:
        predicted = low_pass_zero_phase(_PASSES * band, k.dt, predicted)
    left = measurement.force - predicted
    is_known = np.isfinite(left) | ~np.isfinite(measurement.force)
    if not is_known.all():
        return measurement
    return without_old_zero(model, replace(measurement, force=left), is_reduced=True)


def without_old_zero(model: DamperModel, measurement: Measurement, is_reduced: bool = False) -> Measurement:
    """The measurement less the mean error that the model had when it was identified, as far as it has one here.

    ``improve`` corrects a zero of the gauge in the signal map. Read through a map without the correction, the next
    recording has that zero again: it is not new.

    Args:
        is_reduced: whether the error that the model is known to make was subtracted before.
    """
    zero = recorded(model, ZERO)
    if not np.isfinite(zero) or measurement.force is None or not measurement.judged.any():
        return measurement
    then, now = zero + measurement.signals.force.offset, mean_error(model, measurement)
    if not is_reduced and (known := misfit_of(model.fit)) is not None:
        then += float(np.mean(known.force(model, measurement)[measurement.judged]))
    shift = float(np.clip(now, min(then, 0.0), max(then, 0.0)))
    return replace(measurement, force=measurement.force - shift) if np.isfinite(shift) else measurement
