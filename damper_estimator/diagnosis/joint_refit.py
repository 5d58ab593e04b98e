"""Refits a model together with a missing effect, where derivatives at the old parameters do not show where that leads.

A yield force that turns round smoothly, in place of a compliance that is missing, has to become steep again once the
compliance is there: to first order about the smooth turn the compliance explains nothing. The gauge's zero is in the
comparison, because the model was identified with it: what needs another zero explains nothing.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from damper_estimator.diagnosis.baseline import Baseline
from damper_estimator.diagnosis.diagnosis_data import force_rows, targets
from damper_estimator.diagnosis.evaluation import Errors, errors
from damper_estimator.diagnosis.hypotheses import Hypothesis
from damper_estimator.diagnosis.thresholds import limits
from damper_estimator.diagnosis.trial_fit import at_bound, sizes_of, sketch
from damper_estimator.identification import LocalRows, Point, Problem
from damper_estimator.identification.methods.least_squares import refine
from damper_estimator.model.element import walk

_FIRST, _NEXT = 2, 4  # iterations on excerpts, from both starts, and from the end of the better one
_MORE, _FINISHING = 12, 3  # iterations on excerpts where it is worth it, and on all rows
_WORTH = 2.0  # times the squared error of the best after the first iterations
_GAIN = 1e-3
_MOST = 14  # parameters that are searched: more take too long, and a first-order refit has to do
_MOST_BEHIND = 40  # of those behind a compliance: a curve, which is solved for elsewhere, is searched there


@dataclass(frozen=True)
class _Descent:
    """A joint fit on excerpts.

    Attributes:
        few: the problem on excerpts.
        end: where it stands.
    """

    hypothesis: Hypothesis
    few: Problem
    end: Point


def needs_joint_refit(baseline: Baseline) -> bool:
    """Whether a refit moves parameters in which the model's force is not linear."""
    model = baseline.model
    free = [i for i, slot in enumerate(model.slots) if not slot.fixed]
    return bool(free) and bool(Problem(model, LocalRows(sketch(baseline.data.fit)), free).searched.size)


def jointly_refitted(baseline: Baseline, hypotheses: Sequence[Hypothesis]) -> list[tuple[Hypothesis, Errors]]:
    """The best effect of each phenomenon, fitted with all free parameters of the model, and what is left then.

    Args:
        hypotheses: evaluated, best first. Those that explain far less than others, or hardly anything beside what other
            values of the model's parameters explain, are not among the results.
    """
    best: dict[str, Hypothesis] = {}
    for hypothesis in hypotheses:
        best.setdefault(hypothesis.phenomenon, hypothesis)
    rows = LocalRows(sketch(baseline.data.with_zero.fit, baseline.residual_fit))
    begun = [descent for one in best.values() if (descent := _begun(baseline, one, rows)) is not None]
    alone = Problem(baseline.model, rows, [i for i, slot in enumerate(baseline.model.slots) if not slot.fixed])
    without = _descended(alone, alone.start, _FIRST + _NEXT).cost
    most = min(_WORTH * min((descent.end.cost for descent in begun), default=np.inf), (1.0 - limits().hint) * without)
    promising = [descent for descent in begun if descent.end.cost <= most and np.isfinite(descent.end.cost)]
    found = (_finished(baseline, descent) for descent in promising)
    return [one for one in found if one is not None]


def _begun(baseline: Baseline, hypothesis: Hypothesis, rows: LocalRows) -> _Descent | None:
    """From the values of the trial fit, or those that it started from, whichever leads further at first; None if that
    takes too long."""
    starts = replace(hypothesis, element=hypothesis.fitted_element), hypothesis
    problems = [one.joint_problem(baseline.model, rows) for one in starts]
    most = _MOST_BEHIND if hypothesis.effect.kind == "series" else _MOST
    if problems[0].searched.size > most:
        return None
    ends = [_descended(problem, problem.start, _FIRST) for problem in problems]
    problem, end = min(zip(problems, ends, strict=True), key=lambda pair: pair[1].cost)
    return _Descent(hypothesis, problem, _descended(problem, end.searched, _NEXT))


def _finished(baseline: Baseline, descent: _Descent) -> tuple[Hypothesis, Errors] | None:
    """On excerpts to the end, and from there on all rows; None where the model's force does not stay finite."""
    data, hypothesis = baseline.data, descent.hypothesis
    near = _descended(descent.few, descent.end.searched, _MORE)
    problem = descent.few.on(LocalRows(data.with_zero.fit))
    end = _descended(problem, near.searched, _FINISHING)
    if not np.isfinite(end.cost):
        return None
    vector = problem.vector(end.searched, end.solved)
    joint = problem.model_at(vector)
    left = [force_rows(joint, rows) - targets(rows) for rows in (data.fit, data.unseen)]
    if not np.isfinite(np.concatenate(left)).all():
        return None
    _, own = hypothesis.added_to(baseline.model)
    values = dict(list(walk(joint.effects))[joint.slots[own[0]].entry].parameters)
    fit = replace(hypothesis.fit, values=values, at_bound=at_bound(problem, vector, own))
    return replace(hypothesis, fit=fit, joint=joint), errors(data.blocks, *left)


def _descended(problem: Problem, start: np.ndarray, iterations: int) -> Point:
    if not problem.searched.size:
        return problem.point(start)
    return refine(problem, start, sizes_of(problem), iterations, _GAIN)[0]
