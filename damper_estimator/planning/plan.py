"""Designs the test that separates tied explanations, or that sharpens a model's parameters."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from damper_estimator.diagnosis import Explanations, explanations
from damper_estimator.effects.discovery import all_effects
from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel
from damper_estimator.planning.criterion import Criterion
from damper_estimator.planning.expected_error import Errors, errors_of
from damper_estimator.planning.limits import Limits, limits_of
from damper_estimator.planning.result import REST, SURE, Curve, Plan, Sharpened, sentence_of
from damper_estimator.planning.rig import Rig
from damper_estimator.planning.rivals import criterion, simulable
from damper_estimator.planning.search import Choice, Report, chosen, repeated_one
from damper_estimator.planning.sharpening import sharpening
from damper_estimator.planning.simulated import Simulated, simulated
from damper_estimator.planning.steps import Step, steps_of
from damper_estimator.planning.widened import Widened, widenings
from damper_estimator.signals import Measurement
from damper_estimator.signals.layout import COMMAND, TEMPERATURE
from damper_estimator.validation import compare

LONGEST = 10.0  # minutes, where none are asked for
_SHARPENING = 2.0  # the same, of a test for parameters
_PATIENCE = 10  # steps that may add next to nothing
_PROGRESS = 0.005  # least gain over them, of the probability and of the search's score
_DIFFERENT = 4  # steps: what the form gets wrong on one motion must not decide
_NEARLY = 0.97  # of the probability and the score that are reached: a test that gets so far is long enough
_ALSO, _MOST_ALSO = 0.03, 2  # probability from which others count as rivals, and how many at most


@dataclass(frozen=True)
class _Stage:
    """What a search works on."""

    found: Explanations
    rig: Rig
    limits: Limits
    steps: list[Step]
    on: Simulated
    like: Measurement
    probable: Mapping[str, float] | None = None


def plan(
    model: DamperModel,
    measurements: Sequence[Measurement],
    phenomena: Sequence[str],
    rig: Rig,
    *,
    probable: Mapping[str, float] | None = None,
    minutes: float | None = None,
    longest: float = LONGEST,
    alternatives: bool = True,
    progress: Report | None = None,
) -> Plan:
    """The test that tells apart which of these phenomena is missing; without phenomena, the one that sharpens the
    model's parameters.

    Args:
        model: that was diagnosed.
        measurements: the recordings of the diagnosis.
        phenomena: two or more tied ones, or none.
        rig: with its limits.
        probable: probability of each phenomenon, as the diagnosis of these recordings has it; None where it is unknown.
            Others that are nearly as probable as a tie count as rivals: a new motion may bring them back.
        minutes: length of the test; None for the shortest that is sure.
        longest: minutes that this one may take.
        alternatives: whether to look for limits to widen where the test is not sure, which takes as long as the plan.
        progress: called with the activity in words and the share that is done.

    Raises:
        InputError: where the recordings cannot show a phenomenon, or the limits leave nothing to drive.
    """
    report = progress or (lambda text, share: None)
    if len(phenomena) == 1:
        raise InputError(f"{phenomena[0]}: is tied with nothing; a plan needs two phenomena to tell apart, or none")
    if minutes is not None and not 0.2 <= minutes <= 120.0:
        raise InputError(f"{minutes:g} minutes: a test lasts from 0.2 to 120 minutes")
    report("fitting the hypotheses", 0.0)
    is_known = probable is not None and all(probable.get(name, 0.0) > 0.0 for name in phenomena)
    phenomena = (*phenomena, *_near(phenomena, probable)) if probable and is_known else tuple(phenomena)
    found = simulable(explanations(model, measurements, phenomena))
    report("simulating steps", 0.3)
    stage = _stage(found, rig, limits_of(rig, found.ranges, measurements[0].band), measurements[0])
    if probable and is_known:
        stage = replace(stage, probable={name: probable[name] for name in phenomena})
    if not phenomena:
        return _sharpening(stage, measurements, minutes, report)
    found_plan, errors = _separating(stage, measurements, minutes, longest, report)
    if alternatives and found_plan.chances is not None and found_plan.chances.right < SURE:
        report("looking for what would separate", 0.86)
        most = 60.0 * (minutes or longest) - sum(REST)
        found_plan = replace(found_plan, would=_would(stage, errors, most, found_plan.chances.right))
    report("done", 1.0)
    return found_plan


def _near(phenomena: Sequence[str], probable: Mapping[str, float]) -> list[str]:
    """Phenomena that are not quite tied with these, the most probable first; none without any that are."""
    others = [name for name, share in probable.items() if name not in phenomena and share >= _ALSO]
    return sorted(others, key=lambda name: -probable[name])[:_MOST_ALSO] if phenomena else []


def _stage(found: Explanations, rig: Rig, limits: Limits, like: Measurement) -> _Stage:
    steps = steps_of(rig, limits, *(_matters(found, row, like) for row in (COMMAND, TEMPERATURE)))
    on = simulated(found, steps, like) if steps else None
    if on is None or (on.largest > limits.force).all():
        raise InputError(
            f"rig {rig.name}: no step obeys its limits (speed {limits.speed:g} m/s, acceleration "
            f"{limits.acceleration:g} m/s^2, force {limits.force:g} N, {limits.frequency[0]:g} to "
            f"{limits.frequency[1]:g} Hz); widen them"
        )
    inside = on.largest <= limits.force
    if not inside.all():
        steps = [step for step, good in zip(steps, inside, strict=True) if good]
        on = simulated(found, steps, like)
    return _Stage(found, rig, limits, steps, on, like)


def _matters(found: Explanations, row: int, like: Measurement) -> bool:
    """Whether any hypothesis depends on a slow channel that was recorded."""
    block = np.ascontiguousarray(like.kinematics.block[:, :2000])
    if np.isnan(block[row]).all():
        return False
    other = block.copy()
    other[row] = block[row] + 1.0
    return any(
        not np.array_equal(one.model.force(block), one.model.force(other), equal_nan=True) for one in found.fitted
    )


def _separating(
    stage: _Stage, measurements: Sequence[Measurement], minutes: float | None, longest: float, report: Report
) -> tuple[Plan, Errors]:
    hypotheses = stage.found.fitted
    best = min(hypotheses, key=lambda one: float(np.sum(one.residual**2)))
    errors = errors_of(stage.found, compare(best.model, *measurements).noise_floor_n)
    judge = criterion(stage.found, stage.on, stage.steps, errors, stage.probable)
    seconds = np.array([step.seconds for step in stage.steps])
    most = 60.0 * (minutes or longest) - sum(REST)

    def choose(begin: float, end: float, first: Sequence[int] = ()) -> Choice:
        said = _scaled(report, begin, end)
        return chosen(judge.score, seconds, most, _enough(judge, minutes), said, first=first, different=_DIFFERENT)

    choice = choose(0.5, 0.7)
    if judge.chances(choice.counts(seconds.size)).right < SURE:
        other = choose(0.7, 0.85, repeated_one(judge.score, seconds, most))
        choice = max(choice, other, key=lambda one: judge.score(one.counts(seconds.size)) if one.order else 0.0)
    if not choice.order:
        choice = Choice((int(np.argmin(seconds)),) if choice.parts * seconds.min() <= most else (), choice.parts)
    if not choice.order:
        raise _too_short(minutes or longest, f"the shortest, in both halves, takes {2.0 * seconds.min():.0f} s")
    curve = _curve(judge, choice, seconds)
    if minutes is None:
        scores = [judge.score(choice.counts(seconds.size, first + 1)) for first in range(len(choice.order))]
        reached = (curve.right >= _NEARLY * curve.right[-1]) & (np.array(scores) >= _NEARLY * scores[-1])
        different = [len(set(choice.order[: first + 1])) for first in range(len(choice.order))]
        reached &= np.array(different) >= min(_DIFFERENT, different[-1])
        last = int(np.flatnonzero(reached)[0]) + 1
        choice, curve = Choice(choice.order[:last], choice.parts), curve.until(last)
    chances = judge.chances(choice.counts(seconds.size))
    sure = np.flatnonzero(curve.right >= SURE)
    shortest = float(curve.minutes[sure[0]]) if sure.size else None
    draft = _drafted(stage, choice, judge, errors)
    sentence = sentence_of(draft.phenomena, chances, draft.minutes, shortest)
    return replace(draft, sentence=sentence, chances=chances, curve=curve, shortest=shortest), errors


def _enough(judge: Criterion, minutes: float | None) -> Callable[[np.ndarray], bool]:
    """Whether the shortest test is sure, or further steps have long added nothing; never, if its length is given."""
    past: list[tuple[float, float]] = []

    def enough(counts: np.ndarray) -> bool:
        if minutes is not None:
            return False
        past.append((judge.chances(counts).right, judge.score(counts)))
        stalled = len(past) > _PATIENCE and all(
            now - then < _PROGRESS for now, then in zip(past[-1], past[-1 - _PATIENCE], strict=True)
        )
        return past[-1][0] >= SURE or stalled

    return enough


def _would(stage: _Stage, errors: Errors, most: float, now: float) -> tuple[str, ...]:
    """Limits that, widened one at a time, would let a test separate; then what the effects themselves ask for."""

    def chance(wide: Widened) -> float:
        try:
            other = _stage(stage.found, wide.rig, wide.limits, stage.like)
        except InputError:
            return 0.0
        judge = criterion(other.found, other.on, other.steps, errors, stage.probable)
        seconds = np.array([step.seconds for step in other.steps])
        short = min(most, 180.0)
        choice = chosen(judge.score, seconds, short, lambda counts: judge.chances(counts).right >= SURE, _silent)
        return judge.chances(choice.counts(seconds.size)).right

    return widenings(stage.rig, stage.limits, stage.found, chance, now)


def _sharpening(stage: _Stage, measurements: Sequence[Measurement], minutes: float | None, report: Report) -> Plan:
    (hypothesis,) = stage.found.fitted
    errors = errors_of(stage.found, compare(hypothesis.model, *measurements).noise_floor_n)
    judge = sharpening(stage.found, stage.on, stage.steps, errors)
    seconds = np.array([step.seconds for step in stage.steps])
    minutes = minutes or _SHARPENING
    most = 60.0 * minutes - sum(REST)
    choice = chosen(judge.score, seconds, most, lambda counts: False, _scaled(report, 0.5, 0.95), parts=1)
    if not choice.order:
        raise _too_short(minutes, f"the shortest takes {seconds.min():.0f} s")
    before, after = (judge.standard_errors(c) for c in (np.zeros(seconds.size), choice.counts(seconds.size)))
    parameters = tuple(
        Sharpened(*values) for values in zip(judge.addresses, judge.values.tolist(), before.tolist(), after.tolist(),
                                             strict=True)
    )  # fmt: skip
    fall = float(np.exp(np.mean(np.log(after / before))))
    draft = _drafted(stage, choice, None, errors)
    sentence = (
        f"{draft.minutes:.1f} minutes bring the standard errors of {len(parameters)} parameters to "
        f"{100.0 * fall:.0f} % of what they are, on average."
    )
    report("done", 1.0)
    return replace(draft, sentence=sentence, parameters=parameters)


def _drafted(stage: _Stage, choice: Choice, judge: Criterion | None, errors: Errors) -> Plan:
    """The plan with its drive and its clearest step, without predictions."""
    steps = _driven(stage, choice)
    rate = stage.limits.rate
    rest = [np.full(round(seconds * rate), stage.limits.home) for seconds in REST]
    drive = np.concatenate([rest[0], *(step.displacement for step in steps), rest[1]])
    clearest = _clearest(choice, judge, stage)
    part = stage.on.slices[clearest]
    picks = stage.on.rows.picks[part]
    kinematics = stage.on.rows.measurement.kinematics
    force = stage.on.force[:, part]
    variance = errors.noise + float(errors.of_form(stage.on, stage.found.ranges)[0, clearest])
    hypotheses = stage.found.fitted
    return Plan(
        phenomena=tuple(one.phenomenon for one in hypotheses if one.phenomenon),
        effects=tuple(one.effect for one in hypotheses if one.effect),
        sentence="", rig=stage.rig, limits=stage.limits, steps=steps, chances=None,
        curve=Curve(np.zeros(0), np.zeros(0), np.zeros(0)), shortest=None, would=(), parameters=(),
        untestable=tuple((name, why, all_effects()[name].separate) for name, why in stage.found.untestable.items()),
        displacement=drive, time=kinematics.time[picks] - kinematics.time[picks[0]], force=force,
        velocity=kinematics.velocity[picks], band_n=2.0 * float(np.sqrt(variance)),
        clearest=stage.steps[clearest].words,
    )  # fmt: skip


def _driven(stage: _Stage, choice: Choice) -> tuple[Step, ...]:
    """The chosen steps of all parts; random motion is another one each time, unless its force would be too large."""
    order = sorted(choice.order) * choice.parts
    steps, times = [], Counter[int]()
    for i in order:
        steps.append(stage.steps[i].repeated(times[i]))
        times[i] += 1
    largest = simulated(stage.found, steps, stage.like).largest
    inside = largest <= stage.limits.force
    return tuple(step if good else stage.steps[i] for step, good, i in zip(steps, inside, order, strict=True))


def _clearest(choice: Choice, judge: Criterion | None, stage: _Stage) -> int:
    """The chosen step whose difference is largest over the error expected on it."""
    if judge is None:
        return choice.order[0]
    each = np.mean([pair.square[:, 0] for pair in judge.pairs], axis=0)
    share = each / np.maximum(judge.expected.mean(axis=0), 1e-300)
    return max(choice.order, key=lambda step: float(share[step]))


def _too_short(minutes: float, shortest: str) -> InputError:
    return InputError(f"{minutes:g} minutes: are too short for any step; {shortest}")


def _curve(judge: Criterion, choice: Choice, seconds: np.ndarray) -> Curve:
    minutes, rights, wrongs = [], [], []
    for first in range(1, len(choice.order) + 1):
        counts = choice.counts(seconds.size, first)
        chances = judge.chances(counts)
        minutes.append((float(counts @ seconds) + sum(REST)) / 60.0)
        rights.append(chances.right)
        wrongs.append(chances.wrong)
    return Curve(np.array(minutes), np.array(rights), np.array(wrongs))


def _scaled(report: Report, begin: float, end: float) -> Report:
    return lambda text, share: report(text, begin + (end - begin) * share)


def _silent(text: str, share: float) -> None:
    """Reports nothing."""
