"""Means of the error: the gauge's zero, or a force that the damper has at rest.

The freed zero of the gauge hides both. Here it is in the comparison, in addition to all that was found. A mean is the
gauge's only if nothing in the damper makes it: all effects are tried on the same data, and those that explain about as
much are ties. The mean belongs to the damper if an effect whose force at rest makes it explains more than the zero by
what a finding of its own must, or if an effect that was found without its mean explains as much with it as the zero
beside it. A mean that is small for the force is left alone on other recordings than those of the identification: on
real rigs it differs as much from one recording to the next.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace

import numpy as np

from damper_estimator.diagnosis.accepted import Accepted, accepted_in, positions, regions_of
from damper_estimator.diagnosis.baseline import Baseline, baseline_of
from damper_estimator.diagnosis.diagnosis_data import DiagnosisData, force_at_rest
from damper_estimator.diagnosis.evaluation import Errors, rmse
from damper_estimator.diagnosis.hypotheses import Hypothesis, hypotheses_for, settled, without_last
from damper_estimator.diagnosis.parallel_fits import WORTH, all_fitted
from damper_estimator.diagnosis.ranking import Round, round_of
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.diagnosis.trial_fit import trial_fit
from damper_estimator.model import DamperModel

_MOST_OF_IT = 0.5  # of the mean


def found_in_means(
    first: Round,
    data: DiagnosisData,
    model: DamperModel,
    added: Sequence[Accepted],
    skip: Collection[str],
    workers: int,
    least: float = 0.0,
) -> list[Accepted]:
    """What the data support in the mean; an effect of ``added`` among them replaces what was found without its mean.

    Args:
        first: with what the freed zero hides.
        model: with ``added``, what was found before.
        skip: effects that are not tried.
        least: share of the squared error that a zero must explain.
    """
    least_n = limits().notable * data.force_rms if data.usual > 0.0 else 0.0
    data, found, names = data.with_zero, [], regions_of(added)
    earlier = {one.name: one for one in first.hypotheses if one.effect.kind == "series"}  # no mean changes these
    for hypothesis in first.hidden:
        baseline = baseline_of(model, data, positions(model, names), base=())
        fit = trial_fit(baseline, hypothesis)
        if fit.hidden or np.sqrt(np.mean(fit.change_fit**2)) < least_n:
            continue
        zero = replace(hypothesis, fit=fit)
        alone = _round(baseline, [zero], zero)
        if alone.gain(alone.best)[0] < least or alone.reason_against(alone.best, data.force_rms):
            continue
        known = {*skip, zero.name} | settled(names)
        others = [
            one.continued(earlier.get(one.name))
            for one in hypotheses_for(model, data.ranges)[0]
            if one.name not in known
        ]
        fitted = [zero, *all_fitted(baseline, others, WORTH, workers, lambda count: None)]
        among = _round(baseline, fitted, zero)
        best = _owner(among, among.hypothesis(zero.name))
        left = among.left(best)
        with_mean = (one for one in _with_their_means(added, data, model, zero) if not _is_worth(*one, left))
        found.append(next((accepted_in(*one) for one in with_mean), accepted_in(among, best)))
    return found


def _round(baseline: Baseline, fitted: Sequence[Hypothesis], zero: Hypothesis) -> Round:
    return replace(round_of(baseline, fitted, "kept"), constants=frozenset({zero.name}))


def _owner(among: Round, zero: Hypothesis) -> Hypothesis:
    """The zero of the gauge, unless an effect whose force at rest makes the mean explains more."""
    best = next(iter(among.supported(among.baseline.data.force_rms)), zero)
    if best is zero or not _is_worth(among, zero, among.left(best)):
        return zero
    model, first = among.baseline.model, among.baseline.data.fit[0].measurement
    rests = [force_at_rest(one, first) for one in (best.fitted_into(model), model)]
    makes = (rests[0] - rests[1]) / float(np.mean(zero.fit.change_fit))
    return best if makes > _MOST_OF_IT else zero


def _with_their_means(
    added: Sequence[Accepted], data: DiagnosisData, model: DamperModel, zero: Hypothesis
) -> Iterator[tuple[Round, Hypothesis]]:
    """Effects of the model that can make a mean, each fitted again with it in place of the entry without."""
    names = set(regions_of(added))
    known = {one.name: one for one in hypotheses_for(model, data.ranges)[0] if one.name in names}
    for one in added:
        name = one.hypothesis.name
        again = known.get(name)
        if again is None or one.partner or again.element.settings == one.element.settings:
            continue
        less = without_last(model, name)[0]
        baseline = baseline_of(less, data, positions(less, names - {name}), base=())
        current = _round(baseline, [replace(again, fit=trial_fit(baseline, again))], zero)
        yield current, current.hypotheses[0]


def _is_worth(current: Round, hypothesis: Hypothesis, less: Errors) -> bool:
    """Whether errors are less than those that a hypothesis leaves, by as much as a finding must explain."""
    data, more = current.baseline.data, current.left(hypothesis)
    before, after = (rmse(current.baseline, errors) for errors in (more, less))
    is_enough = less.square < (1.0 - limits().gain) * more.square
    return is_enough and before**2 - after**2 > (limits().least_force * data.force_rms) ** 2
