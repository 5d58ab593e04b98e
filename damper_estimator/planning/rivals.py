"""The criterion of hypotheses that were fitted to the recordings and simulated on steps."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import permutations

import numpy as np

from damper_estimator.diagnosis import (
    Explanations,
    FittedExplanation,
    by_recording,
    general_margin,
    independent,
    limits,
)
from damper_estimator.effects.discovery import all_effects
from damper_estimator.planning.criterion import Criterion, Pair, Weighing, decisive, sharpness
from damper_estimator.planning.expected_error import Errors, force_of
from damper_estimator.planning.simulated import Simulated
from damper_estimator.planning.steps import Step

DRAWS = 8  # of the truth's parameters, antithetic, besides the values themselves
_REACH = 0.5  # of its size a parameter may be off or moved: derivatives do not hold beyond
_FREE = 1e-9  # the gauge's zero is held by nothing
_IMPROBABLE = 1e-6
_WORSE = 1.05  # times the squared error without any effect: an explanation never leaves more
_SILENT = 1e-9  # of it: a change by less is none
_STANDING = 0.5  # of the log odds of a decision: how far apart tied phenomena may stand before the test


def criterion(
    found: Explanations,
    on: Simulated,
    steps: Sequence[Step],
    errors: Errors,
    probable: Mapping[str, float] | None = None,
) -> Criterion:
    """The criterion of hypotheses that were simulated on steps.

    Args:
        probable: of each phenomenon, from the diagnosis of the recordings; None where nobody knows.
    """
    hypotheses = found.fitted
    slices = on.slices
    variance = max(errors.usual, 1e-300) * errors.memory
    draws = [_draws(hypothesis, variance, number) for number, hypothesis in enumerate(hypotheses)]
    form = errors.of_form(on, found.ranges)
    rows = found.rows[0].rate / on.rows.rate  # of a recording, for one of a step
    counts = rows * np.array([part.stop - part.start for part in slices])
    expected = counts * (errors.noise + form)
    weighing = weighed(found, on)
    ahead, charged = _ahead(hypotheses, probable, weighing.before), _charged(hypotheses, on, rows, expected)
    pairs = [
        replace(
            _pair(hypotheses, on, rows, draws, truth, rival),
            ahead=ahead[truth, rival],
            charged=np.stack([charged[truth], charged[rival]]),
        )
        for truth, rival in permutations(range(len(hypotheses)), 2)
        if hypotheses[truth].phenomenon != hypotheses[rival].phenomenon
    ]
    return Criterion(
        tuple(pairs),
        tuple(hypothesis.phenomenon for hypothesis in hypotheses),
        expected,
        form * np.maximum(errors.memory * errors.alike(counts, steps), 1.0),
        np.full(form.shape, errors.noise),
        np.array([step.is_random for step in steps]),
        dict(probable or {}),
        weighing,
    )


def weighed(found: Explanations, on: Simulated) -> Weighing:
    """How a diagnosis would weigh a test of these steps beside the old recordings."""
    both = (*found.rows, on.rows)
    return Weighing(independent(found.rows), independent(both), float(by_recording(both).weight[-1]))


def _ahead(
    hypotheses: Sequence[FittedExplanation], probable: Mapping[str, float] | None, independent: float
) -> np.ndarray:
    """(h, h) log odds of each hypothesis against each other one on the old recordings.

    Without a diagnosis they stand as their sums of squares, no further apart than a tie may be.
    """
    squares = np.array([max(float(np.sum(one.residual**2)), 1e-300) for one in hypotheses])
    names = [one.phenomenon for one in hypotheses]
    best = np.array([min(s for s, other in zip(squares, names, strict=True) if other == name) for name in names])
    per_error = independent * sharpness()
    if probable is None:
        most = _STANDING * decisive()
        odds = np.clip(per_error * np.log(best[None, :] / best[:, None]), -most, most)
    else:
        standing = np.log([max(probable[name], _IMPROBABLE) for name in names])
        odds = standing[:, None] - standing[None, :]
    behind = per_error * np.log(squares / best)  # a phenomenon's second form
    return odds - behind[:, None] + behind[None, :]


def _charged(hypotheses: Sequence[FittedExplanation], on: Simulated, rows: float, expected: np.ndarray) -> np.ndarray:
    """(h, s) N^2 that a diagnosis adds to what a hypothesis leaves on each step, for what it can imitate."""
    found = np.zeros(expected.shape)
    for k, one in enumerate(hypotheses):
        effect = all_effects()[one.effect]
        added = (len(one.model.slots) - on.base_slots) * limits().penalty
        change = on.force[k] - on.base
        shown = [float(np.sum((change[part] - change[part].mean()) ** 2)) if part.stop > part.start else 0.0
                 for part in on.slices]  # fmt: skip
        total = expected[k] + rows * np.array(shown)
        found[k] = added * total + general_margin(expected[k], total) * effect.general
    return found


def simulable(found: Explanations) -> Explanations:
    """Without hypotheses that leave more on the old recordings than the model alone: their fit does not carry over to a
    simulation (a channel's skew behind a compliance, which the model runs sample by sample).

    They are named among what is untestable. If fewer than two phenomena would be left, all stay, and the predicted
    probabilities mean nothing.
    """
    if len({one.phenomenon for one in found.fitted}) < 2:
        return found
    without = sum(float(np.sum((part.target - force_of(found.model, part)) ** 2)) for part in found.rows)
    kept = tuple(one for one in found.fitted if not _is_lost(one, without))
    names = {one.phenomenon for one in kept}
    lost = [one.effect for one in found.fitted if one.phenomenon not in names]
    why = "its fit does not carry over to a simulation with this model"
    if len(names) < 2:
        kept, why = found.fitted, f"{why}, so the predicted probabilities mean nothing"
    return replace(found, fitted=kept, untestable={**found.untestable, **dict.fromkeys(lost, why)})


def _is_lost(one: FittedExplanation, without: float) -> bool:
    """Whether a hypothesis leaves more than the squared error ``without`` it, or is a channel's and changes nothing."""
    left = float(np.sum(one.residual**2))
    is_silent = all_effects()[one.effect].kind == "channel" and abs(left - without) <= _SILENT * without
    return is_silent or left > _WORSE * without


def information(hypothesis: FittedExplanation, variance: float) -> np.ndarray:
    """(k + 1, k + 1) of the old rows, each parameter held to the order of its size; the gauge's zero is free."""
    columns = hypothesis.sensitivity
    found = np.zeros((columns.shape[1] + 1,) * 2)
    found[:-1, :-1] = columns.T @ columns + np.eye(columns.shape[1]) * (variance / _REACH**2)
    found[-1, -1] = _FREE
    return found


def _draws(hypothesis: FittedExplanation, variance: float, seed: int) -> np.ndarray:
    """(k + 1, d) parameters of the truth less the fitted ones, in sizes, as the old recordings leave them uncertain."""
    known = information(hypothesis, variance)[:-1, :-1]
    root = np.linalg.cholesky(np.linalg.inv(known) * variance + 1e-15 * np.eye(len(known)))
    normal = np.random.default_rng([seed, 17]).standard_normal((len(known), DRAWS // 2))
    off = np.clip(root @ normal, -_REACH, _REACH)
    return np.vstack([np.hstack([np.zeros((len(known), 1)), off, -off]), np.zeros(DRAWS + 1)])


def _pair(
    hypotheses: Sequence[FittedExplanation],
    on: Simulated,
    rows: float,
    draws: Sequence[np.ndarray],
    truth: int,
    rival: int,
) -> Pair:
    root = np.sqrt(rows)
    columns = root * on.sensitivity[rival]
    change = root * ((on.force[truth] - on.force[rival])[:, None] + on.sensitivity[truth] @ draws[truth])
    best = min(float(np.sum(hypotheses[i].residual ** 2)) for i in (truth, rival))
    return Pair(
        truth,
        rival,
        np.array([columns[part].T @ columns[part] for part in on.slices]),
        np.array([columns[part].T @ change[part] for part in on.slices]),
        np.array([np.sum(change[part] ** 2, axis=0) for part in on.slices]),
        information(hypotheses[rival], best / max(hypotheses[rival].residual.size, 1)),
        0.0,
        max(best, 1e-300),
    )
