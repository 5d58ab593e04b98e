"""Explanations of the same error, each as the model with its effect in it: what a test has to distinguish."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from damper_estimator.diagnosis.apply_finding import identified_first, state_of
from damper_estimator.diagnosis.baseline import Baseline, baseline_of, near_derivatives, slot_size
from damper_estimator.diagnosis.diagnosis_data import data_of, force_rows, targets
from damper_estimator.diagnosis.hypotheses import Hypothesis, hypotheses_for
from damper_estimator.diagnosis.informative import informative
from damper_estimator.diagnosis.known_error import without_misfit
from damper_estimator.diagnosis.trial_fit import TrialFit, trial_fit
from damper_estimator.effects.discovery import all_effects
from damper_estimator.effects.trial import Ranges
from damper_estimator.errors import InputError
from damper_estimator.identification import check_motion, usable
from damper_estimator.identification.rows import Rows, rows_of
from damper_estimator.model import DamperModel
from damper_estimator.signals import Measurement

_FORMS = 2  # effects of a phenomenon, at most
_NEAR = 1.3  # times the squared error of the best


@dataclass(frozen=True)
class FittedExplanation:
    """One explanation, fitted.

    Attributes:
        phenomenon, effect: what is missing, "" where the model is taken as it is.
        model: with the effect.
        residual: (r,) N, modelled less measured in the rows of the recordings.
        free: positions in ``model.slots`` of the parameters that a refit moves.
        sensitivity: (r, k) derivatives of the rows by these, each times the parameter's size.
        sizes: (k,) of these parameters.
    """

    phenomenon: str
    effect: str
    model: DamperModel
    residual: np.ndarray
    free: tuple[int, ...]
    sensitivity: np.ndarray
    sizes: np.ndarray


@dataclass(frozen=True)
class Explanations:
    """Explanations of the same rows.

    Attributes:
        model: without any of them, identified where it had no record of a fit.
        rows: of the recordings, the gauge's zero and drift left out where there are explanations.
        ranges: what the recordings drive.
        untestable: by effect, why these recordings cannot show it.
    """

    model: DamperModel
    fitted: tuple[FittedExplanation, ...]
    rows: tuple[Rows, ...]
    ranges: Ranges
    untestable: Mapping[str, str]


def explanations(model: DamperModel, measurements: Sequence[Measurement], phenomena: Sequence[str]) -> Explanations:
    """The model with each phenomenon's effects, fitted to all recordings with the model's parameters kept.

    Each phenomenon is represented by its best effect and by others that leave about as little, because the rival may
    take any form. As in a diagnosis, a refit moves the effect's parameters, and the model's only if it was identified
    on these recordings. Without phenomena, the model alone.

    Raises:
        InputError: where a recording cannot be used, or cannot show a phenomenon.
    """
    check_motion(measurements)
    whole = [m.part(p.start, p.stop) for m in measurements for p in usable(model, m)]
    whole = list(informative(whole)) if phenomena else whole
    state = identified_first(state_of(model, whole, whole[:1]), "both")
    model = state.model
    beyond_known = [without_misfit(model, m) for m in whole] if phenomena else whole
    both = data_of(model, beyond_known, beyond_known)
    data = replace(both, unseen=both.unseen[:1])
    tried, untestable = hypotheses_for(model, data.ranges)
    if not phenomena:
        rows = tuple(rows_of(m) for m in whole)  # a fit does not free the gauge's zero
        return Explanations(model, (_explanation("", "", model, rows),), rows, data.ranges, untestable)
    bare = baseline_of(model, data, base=())
    found = []
    for phenomenon in phenomena:
        hypotheses = [hypothesis for hypothesis in tried if hypothesis.phenomenon == phenomenon]
        if not hypotheses:
            effects = (name for name, effect in all_effects().items() if effect.phenomenon == phenomenon)
            why = next((untestable[name] for name in effects if name in untestable), "no effect stands for it")
            raise InputError(f"{measurements[0].recording}: cannot show {phenomenon} ({why}); plan without it")
        ends = [(_trial_fit(bare, hypothesis), hypothesis) for hypothesis in hypotheses]
        left = np.array([float(np.sum(_left(bare, one) ** 2)) for one, _ in ends])
        for i in np.argsort(left, kind="stable")[:_FORMS]:
            one, hypothesis = ends[i]
            if left[i] <= _NEAR * left.min():
                with_it = replace(hypothesis, fit=one).fitted_into(model)
                free = None if state.is_identified_here else hypothesis.added_to(model)[1]
                found.append(_explanation(phenomenon, hypothesis.name, with_it, data.fit, free))
    return Explanations(model, tuple(found), data.fit, data.ranges, untestable)


def _trial_fit(bare: Baseline, hypothesis: Hypothesis) -> TrialFit:
    """Of one hypothesis; with the gauge's zero in the comparison where that hides it, so that it has a value at all."""
    fit = trial_fit(bare, hypothesis, in_any_case=True)
    if not fit.hidden:
        return fit
    data = bare.data.with_zero
    seen = trial_fit(baseline_of(bare.model, data, base=()), hypothesis, in_any_case=True)
    return replace(seen, hidden=True)


def _left(bare: Baseline, fit: TrialFit) -> np.ndarray:
    """(r,) N that a fit leaves with the zero free: of one that the zero hides, all of it."""
    return bare.residual_fit if fit.hidden else bare.residual_fit + fit.change_fit


def sensitivities(explanation: FittedExplanation, rows: Sequence[Rows]) -> tuple[np.ndarray, np.ndarray]:
    """Force rows (r,) in N and their derivatives (r, k) by the free parameters times their sizes, on other motions."""
    force = force_rows(explanation.model, rows)
    return force, near_derivatives(explanation.model, rows, explanation.free, force)


def _explanation(
    phenomenon: str, effect: str, model: DamperModel, rows: Sequence[Rows], free: tuple[int, ...] | None = None
) -> FittedExplanation:
    """With ``free`` the positions of parameters that a refit moves; all but fixed ones without."""
    free = tuple(i for i, slot in enumerate(model.slots) if not slot.fixed) if free is None else free
    force = force_rows(model, rows)
    sizes = np.array([slot_size(model.slots[i]) for i in free])
    return FittedExplanation(
        phenomenon, effect, model, force - targets(rows), free, near_derivatives(model, rows, free, force), sizes
    )
