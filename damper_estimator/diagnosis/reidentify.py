"""Re-identifies what is in a model already: is that enough, and which parameters moved?"""

from dataclasses import dataclass

import numpy as np

from damper_estimator.diagnosis.alternative_starts import from_other_starts
from damper_estimator.diagnosis.diagnosis_data import DiagnosisData, force_rows, targets
from damper_estimator.diagnosis.evaluation import LOW, Errors, errors, gains, rmse
from damper_estimator.diagnosis.local_fit import locally_fitted
from damper_estimator.diagnosis.ranking import Round
from damper_estimator.diagnosis.result import Moved
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.identification.knots import with_knots_of
from damper_estimator.model import DamperModel
from damper_estimator.model.element import walk
from damper_estimator.numerics import block_draws

_NOTABLE = 0.05  # of the error before
_SURE = 0.8  # of the error: what derivatives promise beyond needs no other start
_STILL_THERE = 0.25  # of the error: what effects take away after re-identification, where that was not enough


@dataclass(frozen=True)
class Reidentified:
    """The model with its parameters identified again.

    Attributes:
        model: with the new values; the gauge's zero is in the comparison if they are enough.
        moved: parameters that moved by more than their uncertainty.
        rmse_n: unseen, N, without each recording's zero and drift.
        gain: against the parameters as given, unseen.
        enough: whether it explains the error and an effect on top adds little.
        phenomena: for which the model has effects.
    """

    model: DamperModel
    moved: tuple[Moved, ...]
    rmse_n: float
    gain: float
    enough: bool
    phenomena: frozenset[str]


def reidentified(first: Round, data: DiagnosisData) -> Reidentified:
    """Identifies the model's parameters on the fit rows, from their values."""
    model = first.baseline.model
    phenomena = frozenset(element.effect.phenomenon for element in walk(model.effects) if element.effect.phenomenon)
    promised = 1.0 - first.refitted.square / max(first.kept.square, 1e-300)
    start = model
    if promised < _SURE:
        changed, gain = from_other_starts(model, data)
        start = changed if gain > promised else model
        promised = max(promised, gain)
    if promised < 0.5 * limits().gain:
        return Reidentified(model, (), rmse(first.baseline, first.refitted), promised, False, phenomena)
    refitted = locally_fitted(start, [rows.measurement for rows in data.fit], zero=data.zero)
    left = _left(first, refitted)
    gain = 1.0 - left.square / max(first.kept.square, 1e-300)
    low = float(np.percentile(gains(block_draws(left.blocks.size), left, first.kept), LOW))
    worth = np.sqrt(max(rmse(first.baseline, first.kept) ** 2 - rmse(first.baseline, left) ** 2, 0.0))
    explains = gain >= limits().gain and low > 0.0 and worth >= limits().least_force * data.force_rms
    enough = explains and not _more(first, left)
    if enough:
        # With the zero freed, the constant of a curve is undetermined, and so are all of its forces.
        refitted = locally_fitted(refitted, [rows.measurement for rows in data.fit])
        left = _left(first, refitted)
    return Reidentified(refitted, _moved(model, refitted), rmse(first.baseline, left), gain, enough, phenomena)


def _left(first: Round, model: DamperModel) -> Errors:
    """What a model leaves of the unseen rows; the fitted ones play no part."""
    data = first.baseline.data
    residual = force_rows(model, data.unseen) - targets(data.unseen)
    return errors(data.blocks, first.baseline.residual_fit, residual)


def _more(first: Round, left: Errors) -> bool:
    """Whether an effect on top of re-identified parameters takes away a good part of what they leave, and of all."""
    after = min(left.square, first.refitted.square)
    best = min((one.evaluation.refitted.square for one in first.hypotheses), default=np.inf)
    return after - best > max(_STILL_THERE * after, _NOTABLE * first.kept.square)


def _moved(before: DamperModel, after: DamperModel) -> tuple[Moved, ...]:
    """Where the knots of a curve were laid out again, the curve before is read off at the new ones."""
    errors = after.standard_errors
    moved = []
    for old, new in zip(with_knots_of(before, after).slots, after.slots, strict=True):
        change, error = abs(new.value - old.value), errors.get(new.address, float("nan"))
        certain = error <= change / limits().moved  # never where the error is unknown
        if certain and change > limits().moved_share * max(abs(old.value), 1e-12):
            moved.append(Moved(old.address, old.parameter.unit, old.value, new.value, error))
    return tuple(moved)
