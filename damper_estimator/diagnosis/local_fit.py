"""Identifies a model from its present values, at the rate that the band asks for.

Without a compliance this is an ordinary fit. Behind a compliance, the derivative by every parameter of the path would
cost a run of the implicit solver; the derivatives of the path alone are accurate enough, since each step is checked on
the model itself.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from damper_estimator.diagnosis.baseline import near_derivatives, slot_size
from damper_estimator.diagnosis.diagnosis_data import force_rows, targets, weights
from damper_estimator.identification import fit as identify
from damper_estimator.identification import free_slots, pooled_error, rows_of
from damper_estimator.identification.fit_record import fit_record
from damper_estimator.identification.methods.contract import MethodOptions
from damper_estimator.identification.rows import COMPARED, Rows, split
from damper_estimator.identification.selection import narrowed
from damper_estimator.identification.ties import find_ties, tables
from damper_estimator.model import DamperModel, Slot
from damper_estimator.model.element import labels
from damper_estimator.numerics import damped_step, standard_errors
from damper_estimator.signals import Measurement

_ENOUGH = 1e-5  # of the squared error: a step that promises less moves parameters by a third of a standard error
_STEPS = 5
_SHORTEST = 0.1  # of a step
_LEAST = 1e-3  # of the squared error: a smaller gain ends it
_DAMPED_FROM = 1.0  # of a parameter's size: a longer step is damped


def locally_fitted(
    model: DamperModel,
    measurements: Sequence[Measurement],
    free: Sequence[str] = (),
    fix: Sequence[str] = (),
    zero: int = COMPARED,
    limits: Mapping[str, tuple[float, float]] | None = None,
) -> DamperModel:
    """The model with its free parameters identified from their values, and its record of the fit.

    Args:
        free, fix, limits: as in ``identification.fit``.
        zero: of the gauge, see ``identification.rows``.

    Raises:
        InputError: as ``identification.fit``.
    """
    weight = [weights(model, m) for m in measurements]
    if not any(element.effect.kind == "series" for _, element in labels(model.effects)):
        options = MethodOptions(gain=_ENOUGH)
        return identify(
            model, measurements, free, fix, weights=weight, starts=0, zero=zero, thinned=True,
            method_options=options, limits=limits,
        ).model  # fmt: skip
    # The record states the error over all samples.
    rows = [rows_of(m, w, zero=zero).thinned() for m, w in zip(measurements, weight, strict=True)]
    places = list(free_slots(model, free, fix))
    return _recorded(*_descended(model, rows, places, narrowed(model, limits or {})), places, rows)


def _descended(
    model: DamperModel, rows: Sequence[Rows], places: Sequence[int], limited: Sequence[Slot]
) -> tuple[DamperModel, np.ndarray, np.ndarray]:
    """The model after some steps, its rows' residual (r,), and the derivatives (r, k) there.

    Args:
        places: of the free parameters in its slots.
        limited: all slots, with the bounds that the steps respect.
    """
    target = targets(rows)
    force = force_rows(model, rows)
    columns = near_derivatives(model, rows, places, force)
    for _ in range(_STEPS):
        residual = force - target
        step = damped_step(columns, residual, _DAMPED_FROM)
        share, best = 1.0, (float(residual @ residual), model, force)
        while share >= _SHORTEST and best[1] is model:
            trial = _moved(model, places, share * step, limited)
            modelled = force_rows(trial, rows)
            cost = float((modelled - target) @ (modelled - target))
            if np.isfinite(cost) and cost < best[0]:
                best = (cost, trial, modelled)
            share *= 0.4
        gained = float(residual @ residual) - best[0]
        model, force = best[1], best[2]
        if gained < _LEAST * float(residual @ residual):
            break
        columns = near_derivatives(model, rows, places, force)
    return model, force - target, columns


def _moved(model: DamperModel, places: Sequence[int], step: np.ndarray, limited: Sequence[Slot]) -> DamperModel:
    vector = np.array([slot.value for slot in model.slots])
    for i, change in zip(places, step, strict=True):
        bounds = limited[i].parameter
        vector[i] = np.clip(vector[i] + change * slot_size(model.slots[i]), bounds.lower, bounds.upper)
    return model.with_vector(vector)


def _recorded(
    model: DamperModel, residual: np.ndarray, columns: np.ndarray, slots: Sequence[int], rows: Sequence[Rows]
) -> DamperModel:
    """The model with its record, and with the points of tables that the rows leave open tied to the others."""
    sizes = np.array([slot_size(model.slots[i]) for i in slots])
    jacobian = columns / sizes
    values = np.array([slot.value for slot in model.slots])
    power, cost = float(np.sum(targets(rows) ** 2)), 0.5 * float(residual @ residual)
    ties = find_ties(tables(model), values, slots, jacobian.T @ jacobian, power, cost)
    model = model.with_vector(ties.weights @ values) if ties.tied else model
    kept = [i for i in slots if i not in ties.tied]
    moving = jacobian @ ties.weights[np.ix_(slots, kept)]  # what is tied goes along
    errors = standard_errors(split(rows, moving), split(rows, residual), [part.rate for part in rows])
    named = {model.slots[i].address: float(error) for i, error in zip(kept, errors, strict=True)}
    measurements = [part.measurement for part in rows]
    rmse, _, _ = pooled_error(model, measurements)
    return replace(model, fit=fit_record(model, measurements, rmse, named))
