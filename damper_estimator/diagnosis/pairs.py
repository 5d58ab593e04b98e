"""Two effects at once: the best pair competes with the best single effect.

The largest single effect takes what it can of both, with values, or a name, that are right for neither; and of two that
act against each other, as m a and tau dF/dt where the curve is straight, neither explains much alone. All pairs are
compared to first order (``couples``), the best of them are fitted, and then each place of the best one that the data
support goes to what explains most with the other one there.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from damper_estimator.diagnosis.accepted import Accepted, accepted_in, fitted_together, positions
from damper_estimator.diagnosis.baseline import baseline_of
from damper_estimator.diagnosis.couples import (
    INEXACT,
    Couple,
    couples_of,
    most_promising,
    penalty_of,
    resembling,
    share_left,
)
from damper_estimator.diagnosis.diagnosis_data import force_rows, targets
from damper_estimator.diagnosis.evaluation import errors, rmse
from damper_estimator.diagnosis.hypotheses import Hypothesis, Region, without_last
from damper_estimator.diagnosis.parallel_fits import all_fitted
from damper_estimator.diagnosis.ranking import Round, round_of
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.model import DamperModel

_RIVALS = 1.5  # times what the pair leaves: what leaves more in a place of it cannot be tied


@dataclass(frozen=True)
class _Pair:
    """Two effects fitted together: what they leave, the effects with their regions, and the model with them."""

    left: float
    regions: Mapping[str, Region]
    model: DamperModel


def paired(
    current: Round,
    tried: Sequence[Hypothesis],
    before: Mapping[str, Region],
    workers: int,
    progress: Callable[[int], None],
) -> tuple[list[Accepted], DamperModel] | None:
    """Two effects that the data support together, and the model with them; None where there are none.

    Args:
        before: effects that were found before, with their regions.
    """
    most = _most(current, is_first=not before)
    if most <= 0.0:
        return None
    about_fits, about_starts = couples_of(current, most)
    promising = [one for couples in (about_fits, about_starts) for one in most_promising(current, couples, most)]
    for pair in sorted((_fitted(current, one, before) for one in promising), key=lambda pair: pair.left):
        if pair.left > most:
            break
        nearest = max(_RIVALS * pair.left, INEXACT * most)
        near = [one.names for one in (*about_fits, *about_starts) if one.left < nearest]
        found = _in_their_places(current, pair, tried, near, nearest, before, workers, progress)
        if found is not None:
            return found
    return None


def _in_their_places(
    current: Round,
    pair: _Pair,
    tried: Sequence[Hypothesis],
    near: Sequence[tuple[str, str]],
    nearest: float,
    before: Mapping[str, Region],
    workers: int,
    progress: Callable[[int], None],
) -> tuple[list[Accepted], DamperModel] | None:
    """What explains most in each place of a pair with the other one there, and the model with both; None where the data
    do not support it.

    Args:
        near: pairs whose effects compete where they have one effect in common with this one.
        nearest: what else leaves less than this, to first order, beside the other one competes as well.
        before: effects that were found before, with their regions.
    """
    data, model, found = current.baseline.data, pair.model, []
    regions = dict(pair.regions)
    other, alone = regions
    for _ in range(2):
        free = [h for h in tried if h.name not in {*before, other}]
        rivals = {alone, *(name for both in near if other in both for name in both)}
        place = _in_place_of(current, model, alone, [*before, other], free, rivals, nearest, workers, progress)
        if place is None:
            return None
        best, changed = place
        found.append(best)
        regions = {other: regions[other], best.hypothesis.name: best.hypothesis.region}
        alone, other = other, best.hypothesis.name
        model = fitted_together(changed, {**before, **regions}, data, current.refits)
    both = _share(current, model)
    least = limits().second * (1.0 - both)
    if any(_share(current, without_last(model, name)[0]) - both < least for name in (alone, other)):
        return None  # fitted together, one has taken the part of the other
    return _in_order(current, found), model


def _in_place_of(
    current: Round,
    model: DamperModel,
    alone: str,
    others: Sequence[str],
    free: Sequence[Hypothesis],
    rivals: set[str],
    nearest: float,
    workers: int,
    progress: Callable[[int], None],
) -> tuple[Accepted, DamperModel] | None:
    """What explains most in the place of one effect of a model, and the model with it; None where the data support
    nothing there.

    Args:
        alone: the effect.
        others: effects that were added to the model and stay.
        free: what may take the place; of these the ``rivals`` compete, and those that resemble them.
    """
    less, element = without_last(model, alone)
    baseline = baseline_of(less, current.baseline.data, positions(less, others), None if current.refits else ())
    competing = rivals | set(resembling(current, baseline, [h for h in free if h.name not in rivals], nearest))
    among = [replace(h, element=element) if h.name == alone else h for h in free if h.name in competing]
    again = round_of(baseline, all_fitted(baseline, among, 0.0, workers, progress), current.mode)
    best = again.best
    if best is None or again.reason_against(best, baseline.data.force_rms):
        return None
    return accepted_in(again, best), best.fitted_into(less)


def _in_order(current: Round, found: Sequence[Accepted]) -> list[Accepted]:
    """First the one without which more is left, with what it takes away by itself, if that is much."""
    whole = rmse(current.baseline, current.without)
    first, second = sorted(found, key=lambda one: -one.before_n)
    names = [one.element.effect.phenomenon for one in (first, second)]
    needs = second.before_n**2 > (1.0 - limits().gain) * whole**2
    first, second = replace(first, partner=names[1], needs=needs), replace(second, partner=names[0], needs=needs)
    return [first, second] if needs else [replace(first, before_n=whole, after_n=second.before_n), second]


def _most(current: Round, is_first: bool) -> float:
    """What a pair may leave: clearly less than the best single effect, both beside what a wrong form leaves.

    If the data support no single effect with the model's parameters kept, and none was found before, a pair need not be
    better than one that is refused: it must explain what two effects do that each explain just enough. What the model
    left when it was identified is asked of neither, where more than that is left with the single effect.
    """
    if is_first and not current.refits and not current.supported(current.baseline.data.force_rms):
        return (1.0 - limits().gain) ** 2
    single = min((one.score for one in current.hypotheses if not one.exclusion_alone), default=1.0)
    usual, form = current.baseline.data.usual, limits().second
    whole, beyond = (limits().pair * (left + form) - form for left in (single, single - usual))
    return max(whole, usual + beyond) if beyond > 0.0 else whole


def _fitted(current: Round, couple: Couple, before: Mapping[str, Region]) -> _Pair:
    data, regions = current.baseline.data, {one.name: one.region for one in couple.effects}
    model = couple.added_to(current.baseline.model)
    model = fitted_together(model, {**before, **regions}, data, current.refits)
    left = _share(current, model) + penalty_of(couple.effects)
    return _Pair(left if np.isfinite(left) else np.inf, regions, model)


def _share(current: Round, model: DamperModel) -> float:
    """What a model leaves, with its parameters as they are; a share of what is left without any effect."""
    data = current.baseline.data
    rows = [force_rows(model, part) - targets(part) for part in (data.fit, data.unseen)]
    return share_left(current, errors(data.blocks, *rows))
