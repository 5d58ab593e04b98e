"""The verdict: something is missing, what is there changed, nothing is missing, or something that nobody knows."""

from collections.abc import Sequence

import numpy as np

from damper_estimator.diagnosis.accepted import Accepted
from damper_estimator.diagnosis.evaluation import rmse
from damper_estimator.diagnosis.reidentify import Reidentified
from damper_estimator.diagnosis.result import Structure
from damper_estimator.diagnosis.search import Search
from damper_estimator.diagnosis.structure import structure
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.identification.fit_record import recorded
from damper_estimator.model import DamperModel

_ENOUGH = 0.75  # of what re-identification explains, by one effect instead


def verdict_on(
    found: Search, again: Reidentified | None, force_n: float, floor_n: float, is_identified_here: bool = False
) -> tuple[str, Structure | None]:
    """The verdict, with a picture where it is ``unexplained`` and there is structure to be seen.

    Args:
        again: None where the model's parameters are trusted.
        force_n, floor_n: rms of the measured force, and the noise floor, N.
        is_identified_here: whether the model was identified on these recordings: then only noise excuses what is left,
            elsewhere also what the identification left.
    """
    first, left = found.first, found.left_n
    floor = floor_n if np.isfinite(floor_n) else 0.0
    if (
        again is not None
        and _enough(found, again, floor)
        and not _new_effects_explain_more(found.accepted, left, again)
    ):
        return "parameters_changed", None
    if found.accepted:
        return "missing", None
    usual = min(_residual_before(first.baseline.model), limits().notable * force_n)
    explainable = floor if is_identified_here and floor > 0.0 else max(floor, usual)
    if left > max(limits().notable * force_n, limits().above * explainable):
        picture, gain, low = structure(first.baseline, first.kept)
        if gain >= limits().structured and low > 0.0:
            return "unexplained", picture
        if left > limits().far_above * explainable:
            return "unexplained", None
    return "nothing_missing", None


def taken_over(found: Search, delivered: Sequence[str], again: Reidentified) -> bool:
    """Whether parameters of the model do what the finding that explains most did while they were kept. Identified with
    them it is idle, and what else is added seems to explain what they do.

    Args:
        delivered: names of the effects that lower the error in the model.
    """
    first = max(found.accepted, key=lambda one: one.fall)
    return first.hypothesis.name not in delivered and again.enough and again.gain >= first.explained


def _enough(found: Search, again: Reidentified, floor: float) -> bool:
    """Whether re-identification takes away most of what there is to explain, or no less than all that was found."""
    first = found.first
    before = rmse(first.baseline, first.kept)
    explainable = max(before**2 - floor**2, 1e-12)
    takes_most = before**2 - again.rmse_n**2 >= limits().refit_most * explainable
    takes_more = bool(found.accepted) and again.rmse_n <= found.left_n
    return again.enough and (takes_most or takes_more)


def _residual_before(model: DamperModel) -> float:
    """What the model's identification left, N; 0 if unknown."""
    return float(np.nan_to_num(recorded(model, "residual_stddev")))


def _new_effects_explain_more(accepted: Sequence[Accepted], left_n: float, again: Reidentified) -> bool:
    """Whether new effects, which leave ``left_n``, say more than moving what is there, or one of the damper as much
    with far fewer parameters, or one that follows a channel which is not where the model was identified: there the
    parameters may be as they were.
    """
    if not accepted:
        return False
    if accepted[0].hypothesis.because:
        return True
    if left_n**2 < limits().refit_better * again.rmse_n**2:
        return True
    first = accepted[0]
    effect = first.element.effect
    if effect.kind == "channel" or effect.phenomenon in again.phenomena:
        return False
    simpler = 2 * first.hypothesis.size <= len(again.moved)
    return simpler and first.explained >= _ENOUGH * again.gain
