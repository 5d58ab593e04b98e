"""Findings as steps: each put into the model, with the errors that it delivers."""

from collections.abc import Sequence
from dataclasses import replace

from damper_estimator.diagnosis.accepted import Accepted, together
from damper_estimator.diagnosis.apply_finding import ModelState, applied
from damper_estimator.diagnosis.hypotheses import without_last
from damper_estimator.diagnosis.thresholds import limits

Step = tuple[Accepted, ModelState, float, float]
"""A finding, the model after it, and the unseen error without and with it, N."""


def steps_of(state: ModelState, accepted: Sequence[Accepted], mode: str, names_changes: bool = False) -> list[Step]:
    """The findings that lower the error, faults of the measurement chain first.

    Where one follows a channel that is not where the model was identified, the model's parameters hold there, and are
    kept.

    Args:
        names_changes: whether they name how parameters changed, with the errors of the evaluation: then all are steps
            that lower those, but corrections of the measurement chain, which deliver what they explain or nothing.
    """
    steps: list[Step] = []
    current = state
    mode = "kept" if any(one.hypothesis.because for one in accepted) else mode
    order = sorted(together(accepted), key=lambda group: all(one.element.effect.correct is None for one in group))
    for group in order:
        promised = _promised(group)
        taken = _applied_together(current, group, mode, promised, names_changes)
        if not taken:
            continue
        before, after = current, taken[-1][1]
        if after.delivers(promised, before):
            steps += _with_errors(before, taken)
            current = after
        elif names_changes and promised > 0.0 and any(one.element.effect.correct is None for one in group):
            steps += [(one, at, one.before_n, one.after_n) for one, at in taken]
    return steps


def _promised(group: Sequence[Accepted]) -> float:
    """N^2 by which the findings of a group lower the squared error. Of two that each do little without the other one,
    each has the error of both as its own.
    """
    if any(one.needs for one in group):
        return max(max(one.before_n for one in group) ** 2 - min(one.after_n for one in group) ** 2, 0.0)
    return sum(max(one.fall, 0.0) for one in group)


def _with_errors(before: ModelState, taken: Sequence[tuple[Accepted, ModelState]]) -> list[Step]:
    """The findings of a group with the errors without and with each; both with those before and after the two, if the
    first does little without the second.
    """
    between, after = taken[0][1], taken[-1][1]
    if len(taken) == 2 and between.fall_from(before) < limits().gain * after.fall_from(before):
        return [(replace(one, needs=True), at, before.rmse_unseen_n, after.rmse_unseen_n) for one, at in taken]
    earlier = [before, *(at for _, at in taken)]
    return [
        (replace(one, needs=False), at, last.rmse_unseen_n, at.rmse_unseen_n)
        for last, (one, at) in zip(earlier, taken, strict=False)
    ]


def _applied_together(
    before: ModelState, group: Sequence[Accepted], mode: str, promised: float, names_changes: bool
) -> list[tuple[Accepted, ModelState]]:
    """The findings of a group with the model after each.

    Of a pair only one, if the other does harm, or if the one that explains more does as well as both: identified with
    all parameters, it may explain what it did not explain while they were kept. Both, if they name how parameters
    changed; otherwise none that does nothing in the end.
    """
    taken, after = [], before
    for one in sorted(group, key=lambda one: one.element.effect.correct is None):
        after = _applied(after, one, mode, promised)
        taken.append((one, after))
    if names_changes:
        return taken
    at_work = [one for one in group if not _is_idle(one, before, after)]
    if len(at_work) < len(group):
        return _applied_together(before, at_work, mode, promised, names_changes)
    if len(group) < 2:
        return taken
    alone = [taken[0], *((one, _applied(before, one, mode, promised)) for one in group[1:])]
    best = min(alone, key=lambda pair: pair[1].rmse_unseen_n)
    first = max(alone, key=lambda pair: pair[0].fall)
    harms, suffices = best[1].better_than(after), not after.better_than(first[1])
    if not (harms or suffices):
        return taken
    one, state = first if suffices else best
    return [(replace(one, needs=False), state)]


def _is_idle(one: Accepted, before: ModelState, after: ModelState) -> bool:
    """Whether an effect has less part in the fall of the error than a second finding must: taken out of the model, with
    all else kept, it is not missed. The others, or the parameters of the model, have taken its part over.
    """
    if one.element.effect.correct is not None:
        return False
    without = after.with_model(without_last(after.model, one.element.effect.name)[0])
    return after.fall_from(without) < limits().second * after.fall_from(before)


def _applied(before: ModelState, one: Accepted, mode: str, promised: float) -> ModelState:
    """With a finding in its place: from its values next to all other findings, and if that keeps too little of the
    promise, from those that it had alone.
    """
    region = one.hypothesis.region
    after = applied(before, one.element, region, mode, promised, one.hypothesis.joint)
    if after.fulfils(promised, before):
        return after
    alone = applied(before, one.hypothesis.fitted_element, region, mode, promised)
    return min(after, alone, key=lambda state: state.rmse_unseen_n)
